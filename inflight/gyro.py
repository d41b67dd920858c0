"""Bias and scale of a gyro from a spin, and the tilt of the magnetometer: what the bank's states say of them.

Along the spin the record shows one number, the rate's error; bias and scale are told apart by changes of the rate only.
Across the spin a bias and a tilt of the magnetometer's axes against the gyro's are one and the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimator.bank import Noise
from orchestration.quantities import parse_unit

from .attitude import Attitudes
from .records import Flight

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Spin:
    """Parameters of a gyro that a spin shows."""

    axis: Floats
    """(3,) of the mean measured rate"""
    along: float
    """rad/s: the measured rate less the true one, along the axis"""
    along_sigma: float
    across: Floats
    """(3,) rad/s: the same across it, if the magnetometer's axes are those of the gyro"""
    across_sigma: float
    tilt: Floats
    """(3,) rad: the turn of the magnetometer's axes that stands for `across`"""
    bias: Floats
    scale: Floats
    bias_sigma: Floats
    scale_sigma: Floats
    attitude: str

    def data(self, noise: Noise, unit: str = "rad/s") -> dict[str, Any]:
        """For JSON; `matrix` and `offset` are those of a column of telemetry in this unit, `estimator` what that block
        takes beside them, `sensors` a gyro with such errors."""
        apart = bool((self.scale_sigma < 0.3 * noise.scale).any())
        return {
            "unit": unit,
            "matrix": np.diag(1.0 / (1.0 + self.scale)).tolist(),
            "offset": (self.bias / parse_unit(unit).factor).tolist(),
            "axis": self.axis.tolist(),
            "rate_error_along": self.along,
            "rate_error_along_sigma": self.along_sigma,
            "rate_error_across": self.across.tolist(),
            "rate_error_across_sigma": self.across_sigma,
            "magnetometer_tilt": self.tilt.tolist(),
            "bias": self.bias.tolist(),
            "bias_sigma": self.bias_sigma.tolist(),
            "scale": self.scale.tolist(),
            "scale_sigma": self.scale_sigma.tolist(),
            "verdict": {
                "rate along the spin": "shown" if self.along_sigma < 0.1 * noise.bias else "weak",
                "bias and scale apart": "shown" if apart else "not shown",
                "bias across the spin and tilt of the magnetometer apart": "not shown",
                "attitude": self.attitude,
            },
            "sensors": {"rate_bias_B": self.bias.tolist(), "rate_scale": np.diag(self.scale).tolist()},
            "estimator": {
                "angle_random_walk": noise.angle,
                "rate_random_walk": noise.bias_walk,
                "rate_bias_sigma": float(self.bias_sigma.max()),
            },
        }


def spin(flight: Flight, found: Attitudes) -> Spin:
    """Returns what the end of a flight through the bank says of the gyro."""
    mean = flight.omega.mean(axis=0)
    size = float(np.linalg.norm(mean))
    axis = mean / size
    true = (mean - found.bias) / (1.0 + found.scale)
    error = mean - true
    across = error - (error @ axis) * axis
    J = np.hstack((np.eye(3), np.diag(true)))
    P = J @ found.covariance @ J.T
    turn = np.cross(true, mean)
    length = float(np.linalg.norm(turn))
    angle = float(np.arctan2(length, true @ mean))
    tilt = turn / length * angle if length > 0.0 else np.zeros(3)
    sigma = np.sqrt(np.diag(found.covariance))
    aside = float(np.sqrt(max(np.trace(P) - axis @ P @ axis, 0.0) / 2.0))
    along = float(np.sqrt(axis @ P @ axis))
    return Spin(
        axis,
        float(error @ axis),
        along,
        across,
        aside,
        tilt,
        found.bias,
        found.scale,
        sigma[:3],
        sigma[3:],
        found.verdict(),
    )
