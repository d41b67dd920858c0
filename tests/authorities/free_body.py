"""The torque-free rigid body in closed form: Jacobi's elliptic functions and the elliptic integral of the third kind.

Landau and Lifshitz, Mechanics, 3rd ed., section 37: the rates (37.10) and the angle of precession
(37.15 and after). With the axes named so that the motion goes round axis 3,

    omega_1 = A1 cn tau,  omega_2 = A2 sn tau,  omega_3 = A3 dn tau,

the angles about the constant momentum H are cos theta = I3 omega_3/H, tan phi = I1 omega_1/(I2 omega_2), and

    d psi/dt = H (I1 omega_1^2 + I2 omega_2^2)/(I1^2 omega_1^2 + I2^2 omega_2^2)
             = H/I3 + H (2T - H^2/I3)/(H^2 - I3^2 omega_3^2),

whose integral is Legendre's Pi.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import ellipj, ellipk, ellipkinc, elliprf, elliprj


class FreeBody:
    """A rigid body without moments: `rate(t)` and `attitude(t)` from its state at t = 0."""

    def __init__(self, J: np.ndarray, Omega: np.ndarray, R: np.ndarray | None = None) -> None:
        self.R0 = np.eye(3) if R is None else R
        moments, axes = np.linalg.eigh(J)
        H = J @ Omega
        momentum2, energy2 = float(H @ H), float(Omega @ H)
        order = [0, 1, 2] if momentum2 > energy2 * moments[1] else [2, 1, 0]
        self.I = I1, I2, I3 = moments[order]
        S = axes[:, order]
        if np.linalg.det(S) < 0.0:
            S[:, 0] *= -1.0
        if float(S[:, 2] @ Omega) < 0.0:  # half a turn about axis 1 makes omega_3 positive
            S[:, 1:] *= -1.0
        self.S = S
        self.H = math.sqrt(momentum2)
        self.energy2 = energy2
        self.A = np.array(
            [
                math.sqrt((energy2 * I3 - momentum2) / (I1 * (I3 - I1))),
                math.sqrt((energy2 * I3 - momentum2) / (I2 * (I3 - I2))) * math.copysign(1.0, I3 - I2),
                math.sqrt((momentum2 - energy2 * I1) / (I3 * (I3 - I1))),
            ]
        )
        self.speed = math.sqrt((I3 - I2) * (momentum2 - energy2 * I1) / (I1 * I2 * I3))
        self.m = (I2 - I1) * (energy2 * I3 - momentum2) / ((I3 - I2) * (momentum2 - energy2 * I1))
        w = S.T @ Omega
        self.tau0 = float(ellipkinc(math.atan2(w[1] / self.A[1], w[0] / self.A[0]), self.m))

    def principal_rate(self, t):
        sn, cn, dn, _ = ellipj(self.tau0 + self.speed * t, self.m)
        return self.A * np.array([cn, sn, dn])

    def rate(self, t: float) -> np.ndarray:
        """Omega (3,), rad/s, in body axes."""
        return self.S @ self.principal_rate(t)

    def precession_rate(self, t: float) -> float:
        """d psi/dt by its definition, for a check of `precession` by quadrature."""
        w = self.principal_rate(t)
        L = self.I * w
        return self.H * float(L[:2] @ w[:2]) / float(L[:2] @ L[:2])

    def precession(self, t: float) -> float:
        """psi(t) - psi(0), rad."""
        I3, H2 = self.I[2], self.H**2
        # H^2 - I3^2 omega_3^2 = (H^2 - I3^2 A3^2)(1 - n sn^2), as dn^2 = 1 - m sn^2
        at_rest = H2 - (I3 * self.A[2]) ** 2
        n = -((I3 * self.A[2]) ** 2) * self.m / at_rest
        integral = _third_kind(n, self.tau0 + self.speed * t, self.m) - _third_kind(n, self.tau0, self.m)
        return self.H / I3 * t + self.H * (self.energy2 - H2 / I3) / at_rest * integral / self.speed

    def attitude(self, t: float) -> np.ndarray:
        """R (3,3), body to inertial."""
        start, now = self._from_momentum(0.0, 0.0), self._from_momentum(t, self.precession(t))
        return self.R0 @ self.S @ start.T @ now @ self.S.T

    def _from_momentum(self, t: float, psi: float) -> np.ndarray:
        """Principal axes to the frame whose Z lies along the momentum: Rz(psi) Rx(theta) Rz(phi)."""
        L = self.I * self.principal_rate(t)
        theta, phi = math.acos(L[2] / self.H), math.atan2(L[0], L[1])
        return _rotation(2, psi) @ _rotation(0, theta) @ _rotation(2, phi)


def _third_kind(n: float, tau: float, m: float) -> float:
    """Pi(n; am tau | m), the integral of 1/(1 - n sn^2) from 0 to tau, by Carlson's forms (DLMF 19.25.14)."""
    K = float(ellipk(m))
    periods = round(tau / (2.0 * K))
    sn, cn, dn, _ = ellipj(tau - 2.0 * K * periods, m)

    def carlson(s, c2, d2):
        return s * elliprf(c2, d2, 1.0) + n / 3.0 * s**3 * elliprj(c2, d2, 1.0, 1.0 - n * s * s)

    return float(carlson(sn, cn * cn, dn * dn) + 2.0 * periods * carlson(1.0, 0.0, 1.0 - m))


def _rotation(axis: int, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R
