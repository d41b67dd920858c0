"""Partition of a torque over one wheel and three magnetic rods [14]-[24].

The rods can only turn the body across the field, so the wheel supplies the demand's part along it; the rods supply the
rest with the least dipole. b_hat_B is the paper's b, the field's unit vector in body axes, and B the field's strength,
T; U (3,3) has the rods' unit axes u_i as rows; axis (3,) is the wheel's unit axis, the paper's e1.

Requirement: AL-1.
"""

from __future__ import annotations

import math

import numpy as np

from .vector import Array, cross, dot, norm

E1 = np.array((1.0, 0.0, 0.0))
"""The wheel's axis in the paper."""
FIELD_MIN = 1e-12
"""T. A field below a thousandth of a nanotesla has no direction to allocate by."""
B_WHEEL_MIN = 1e-9
"""|b1| below which [20] is a division by rounding errors."""
ACROSS_MIN = 1e-3
"""Share of the demand across the field; n from a smaller one has its rounding errors."""
RANK_MIN = 1e-12
"""det(A^T A) below which the rods span only a line across the field."""


class Singular(ValueError):
    """No finite commands give the demanded torque in this field."""


def field(b_B: Array) -> tuple[float, Array]:
    """B and b_hat_B of the field b_B (3,) T. Raises Singular below FIELD_MIN."""
    B = norm(b_B)
    if B < FIELD_MIN:
        raise Singular(f"b_B: the field {b_B.tolist()} T has no direction")
    return B, b_B * (1.0 / B)


def wheel_reaction(dh_w: float, h_w: float, omega_B: Array, axis: Array = E1) -> Array:
    """Torque of the wheel on the body [14]: tau_RW = -(dl_w/dt e1 + l_w Omega x e1), (3,) N m.

    dh_w the torque on the rotor dl_w/dt, N m; h_w its momentum l_w, N m s; omega_B (3,) rad/s.
    """
    return -dh_w * axis - h_w * cross(omega_B, axis)


def wheel_torque(tau_B: Array, b_hat_B: Array, omega_B: Array, h_w: float, axis: Array = E1) -> float:
    """Wheel torque that supplies the demand's part along the field [20], dl_w/dt in N m.

    dl_w/dt = -(tau . b + l_w (Omega x e1) . b)/(e1 . b)

    tau_B (3,) N m, omega_B (3,) rad/s, h_w N m s. With the field normal to the wheel (|b1| below B_WHEEL_MIN)
    it is 0 where nothing is wanted along the field; otherwise raises Singular.
    """
    b1 = float(b_hat_B.dot(axis))
    along_field = float(tau_B.dot(b_hat_B)) + h_w * float(cross(omega_B, axis).dot(b_hat_B))
    if along_field == 0.0:
        return 0.0
    if abs(b1) < B_WHEEL_MIN:
        raise Singular(
            f"b_B: the field is normal to the wheel, b1 = {b1:g}, and {along_field:g} N m is wanted along it"
        )
    return -along_field / b1


def plane(b_hat_B: Array, tau_B: Array) -> tuple[Array, Array]:
    """An orthonormal basis n, c of the plane across the field [21]: n = unit(tau - (tau . b) b), c = b x n.

    The least-norm dipole [24] does not depend on the basis, so where tau_B has no part across the field
    (ACROSS_MIN of its size) n comes from the body axis most nearly across the field instead.
    """
    tau, b = tau_B.tolist(), b_hat_B.tolist()
    across = _across(tau, b)
    if not (length := math.hypot(*across)) > ACROSS_MIN * math.hypot(*tau):
        axis = [0.0, 0.0, 0.0]
        axis[np.abs(b_hat_B).argmin()] = 1.0
        across = _across(axis, b)
        length = math.hypot(*across)
    n = np.array([x / length for x in across])
    return n, cross(b_hat_B, n)


def _across(x: list[float], b_hat: list[float]) -> list[float]:
    """x - (x . b) b."""
    along = dot(x, b_hat)
    return [x_i - along * b_i for x_i, b_i in zip(x, b_hat, strict=True)]


def rod_torque(dipole: Array, U: Array, b_B: Array) -> Array:
    """Torque of the rods on the body [16]-[18]: tau_MT = sum mu_i u_i x b_B, (3,) N m.

    dipole (3,) A m2 along the rods' axes, b_B (3,) T.
    """
    return cross(dipole.dot(U), b_B)


def least_dipole(tau_MT: Array, tau_B: Array, B: float, b_hat_B: Array, U: Array) -> Array:
    """The least-norm dipoles m (3,), A m2, along the rods' axes, that give tau_MT across the field [17]-[24].

    M_B = [u1 x b, u2 x b, u3 x b], N_p = [n, c], A = M_B^T N_p [22], m = (1/B) A (A^T A)^-1 N_p^T tau_MT [24]

    tau_MT (3,) N m, the demand tau_B less the wheel's reaction; tau_B only chooses the basis.
    Raises Singular where A has no rank of 2, which linearly independent rods rule out.
    """
    n, c = (v.tolist() for v in plane(b_hat_B, tau_B))
    # Rows of A are (u_i x b) . (n, c) = u_i . (b x n, b x c), and b x n = c, b x c = -n.
    rods = U.tolist()
    A_n = [dot(u, c) for u in rods]
    A_c = [-dot(u, n) for u in rods]
    nn, nc, cc = dot(A_n, A_n), dot(A_n, A_c), dot(A_c, A_c)
    determinant = nn * cc - nc * nc
    if determinant < RANK_MIN:
        raise Singular(f"rod_axes: the rods span no plane across the field b_hat_B = {b_hat_B.tolist()}")
    torque = tau_MT.tolist()
    t_n, t_c = dot(n, torque), dot(c, torque)
    y_n = (cc * t_n - nc * t_c) / (B * determinant)
    y_c = (nn * t_c - nc * t_n) / (B * determinant)
    return np.array([y_n * a_n + y_c * a_c for a_n, a_c in zip(A_n, A_c, strict=True)])


def allocate(tau_B: Array, b_B: Array, omega_B: Array, h_w: float, U: Array, axis: Array = E1) -> tuple[Array, float]:
    """Dipoles (3,) A m2 along the rods and wheel torque dl_w/dt, N m, that together give tau_B on the body.

    tau_B (3,) N m, b_B (3,) T, omega_B (3,) rad/s, h_w N m s. No limit acts here.
    Raises Singular where the field, the wheel or the rods leave the allocation undefined.
    """
    B, b_hat_B = field(b_B)
    dh_w = wheel_torque(tau_B, b_hat_B, omega_B, h_w, axis)
    tau_RW = wheel_reaction(dh_w, h_w, omega_B, axis)
    tau_MT = tau_B - tau_RW
    return least_dipole(tau_MT, tau_B, B, b_hat_B, U), dh_w


def demand_fraction(dipole: Array, dh_w: float, dipole_max: float, wheel_torque_max: float) -> float:
    """Largest demand of an actuator over its limit; infinite where a demand overflowed."""
    mu1, mu2, mu3 = dipole.tolist()
    if not math.isfinite(mu1 + mu2 + mu3 + dh_w):
        return math.inf
    return max(max(abs(mu1), abs(mu2), abs(mu3)) / dipole_max, abs(dh_w) / wheel_torque_max)


def achieved(
    dipole: Array,
    dh_w: float,
    b_B: Array,
    omega_B: Array,
    h_w: float,
    U: Array,
    dipole_max: float,
    wheel_torque_max: float,
    wheel_momentum_max: float,
    axis: Array = E1,
) -> Array:
    """Torque (3,) N m on the body of these commands once each actuator has met its limits.

    Rods and motor are clipped; the motor gives nothing that would drive h_w past wheel_momentum_max.
    """
    given = np.array([min(max(mu, -dipole_max), dipole_max) for mu in dipole.tolist()])
    turning = min(max(dh_w, -wheel_torque_max), wheel_torque_max)
    if abs(h_w) >= wheel_momentum_max and turning * h_w > 0.0:
        turning = 0.0
    return rod_torque(given, U, b_B) + wheel_reaction(turning, h_w, omega_B, axis)
