"""The outputs of controller and allocator from the paper's equations, in balls of 256 bits (Arb, by python-flint).

Written from Sanyal and Lee-Ho (AIAA 2009-5902), not from the C; numbers in brackets are its equations.
"""

from __future__ import annotations

from typing import Any

from flint import arb, arb_mat, ctx

BITS = 256


def column(v: Any) -> arb_mat:
    return arb_mat([[arb(float(x))] for x in v])


def matrix(m: Any) -> arb_mat:
    return arb_mat([[arb(float(x)) for x in row] for row in m])


def hat(v: arb_mat) -> arb_mat:
    x, y, z = v.entries()
    return arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def dot(u: arb_mat, v: arb_mat) -> Any:
    return (u.transpose() * v)[0, 0]


def length(v: arb_mat) -> Any:
    return dot(v, v).sqrt()


def lvlh(r: arb_mat, v: arb_mat) -> tuple[arb_mat, arb_mat, arb_mat]:
    """Z to nadir, Y against the orbit's normal; Omega_d = (0, -n, 0) with n = |r x v|/r^2, and its derivative."""
    h = hat(r) * v
    z, y = r * (-1 / length(r)), h * (-1 / length(h))
    x = hat(y) * z
    n = length(h) / dot(r, r)
    change = -2 * n * dot(r, v) / dot(r, r)
    axes = arb_mat([list(row) for row in zip(x.entries(), y.entries(), z.entries(), strict=True)])
    return axes, arb_mat([[0], [-n], [0]]), arb_mat([[0], [-change], [0]])


def errors(R: arb_mat, omega_B: arb_mat, desired: tuple[arb_mat, arb_mat, arb_mat]) -> tuple[Any, ...]:
    """Q = R_d^T R, |zeta| by sine and cosine, omega = Omega - Q^T Omega_d [4]."""
    Q = desired[0].transpose() * R
    skew = Q - Q.transpose()
    sine = (skew[2, 1] ** 2 + skew[0, 2] ** 2 + skew[1, 0] ** 2).sqrt() / 2
    angle = arb.atan2(sine, (Q[0, 0] + Q[1, 1] + Q[2, 2] - 1) / 2)
    return Q, angle, omega_B - Q.transpose() * desired[1]


def controller(p: Any, u: Any, first: Any) -> dict[str, list[Any]]:
    """[8] to [11] of the inputs u, with |zeta(0)| and |omega(0)| [10] of the inputs `first`."""
    ctx.prec = BITS
    (_, angle_0, omega_0), (Q, angle, omega), desired = *(_errors(w) for w in (first, u)), _desired(u)
    J, L0, r = matrix(p.J_B), matrix(p.L0), column(u["r_N"])
    k = arb(p.kappa0) * (p.a1 + angle) / (p.a2 + angle_0)
    l_ = arb(p.lambda0) * (p.c1 + length(omega)) / (p.c2 + length(omega_0))
    K = [k * x for x in p.K0]
    x = sum((K[i] * (1 - Q[i, i]) for i in range(3)), arb(0)).max(arb(0))
    s = arb(p.phi_scale)
    value, slope = {
        "linear": lambda: (x, arb(1)),
        "logarithm": lambda: (s * (1 + x / s).log(), 1 / (1 + x / s)),
        "square_root": lambda: (2 * s * ((1 + x / s).sqrt() - 1), 1 / (1 + x / s).sqrt()),
    }[p.phi]()
    attitude = column([0, 0, 0])
    for i in range(3):
        e = column([float(i == j) for j in range(3)])
        attitude += hat(e) * (Q.transpose() * e) * K[i]
    to_body = Q.transpose() * desired[1]
    nadir = matrix(u["R_NB"]).transpose() * r * (1 / length(r))
    gravity = hat(nadir) * (J * nadir) * (3 * arb(p.gravitational_parameter) / length(r) ** 3)
    tau = (
        L0 * omega * -l_ + J * (Q.transpose() * desired[2]) + hat(to_body) * (J * to_body) + attitude * slope - gravity
    )
    return {
        "tau_cmd_B": tau.entries(),
        "attitude_error": [angle],
        "rate_error_B": omega.entries(),
        "lyapunov": [dot(omega, J * omega) / 2 + value],
        "gain_k": [k],
        "gain_l": [l_],
    }


def _desired(u: Any) -> tuple[arb_mat, arb_mat, arb_mat]:
    if abs(u["R_ref"][0][0]) < 2:
        return matrix(u["R_ref"]), column(u["Omega_ref"]), column(u["dOmega_ref"])
    return lvlh(column(u["r_N"]), column(u["v_N"]))


def _errors(u: Any) -> tuple[Any, ...]:
    return errors(matrix(u["R_NB"]), column(u["omega_B"]), _desired(u))


def allocator(p: Any, u: Any) -> dict[str, list[Any]]:
    """[14] to [24], whether or not the commands would be held."""
    ctx.prec = BITS
    tau, b_B, Omega, h_w = column(u["tau_cmd_B"]), column(u["b_B"]), column(u["omega_B"]), arb(float(u["h_w"]))
    axes = [column(row) for row in p.rod_axes]
    rods, e1 = [a * (1 / length(a)) for a in axes], column(p.wheel_axis)
    e1 = e1 * (1 / length(e1))
    B = length(b_B)
    b = b_B * (1 / B)
    spin = hat(Omega) * e1 * h_w
    dl_w = -dot(tau + spin, b) / dot(b, e1)  # [20]
    tau_MT = tau + e1 * dl_w + spin  # tau less that of the wheel [14]
    # Any two vectors that span the plane across the field are N_p's columns.
    axis = min(range(3), key=lambda i: abs(float(b[i, 0])))
    first = hat(b) * column([float(i == axis) for i in range(3)])
    N_p = arb_mat([list(row) for row in zip(first.entries(), (hat(b) * first).entries(), strict=True)])
    M_B = arb_mat([list(row) for row in zip(*((hat(u_i) * b).entries() for u_i in rods), strict=True)])
    A = M_B.transpose() * N_p
    m = A * (A.transpose() * A).solve(N_p.transpose() * tau_MT) * (1 / B)  # [24]
    dipoles = m.entries()
    fraction = max(*(abs(x) / p.dipole_max for x in dipoles), abs(dl_w) / p.wheel_torque_max, key=float)
    return {
        "dipole_cmd": dipoles,
        "wheel_torque_cmd": [dl_w],
        "demand_fraction": [fraction],
        "tau_residual_B": [arb(0)] * 3,  # where no limit acts
        "b_wheel": [dot(b, e1)],
    }
