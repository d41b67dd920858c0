"""How quick the laws to compare with are, by two rules of practice that need no flight.

The actuators' torque is demanded whole at an error of 1 rad, so w^2 = tau/J, but a period of the control is at most a
tenth of 1/w. The torque is that which a set of wheels gives about any axis, or that of a rod across a field B where it
is more. Where wheels leave an axis to the rods, as one does, half of that frequency: about it there is torque across
the field alone. Without a wheel the axis along the field has none until the field has turned: a fifth.
Tests: tests/design/test_rank.py.
"""

from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

B = 4.4e-5  # T, a mean of the field
SAMPLED, LEFT, ALONE, SLOWER = 0.1, 0.5, 0.2, 10.0
NONE = 1e-8  # N m s: below it a wheel is none


def frequency(parameters: Any) -> float:
    """w, rad/s."""
    axes, torques, momenta = wheels(parameters)
    wheeled = _any_axis(axes.tobytes(), torques.tobytes())
    share = ALONE if momenta.max(initial=0.0) <= NONE else 1.0 if wheeled else LEFT
    w = share * np.sqrt(3.0 * max(parameters.dipole_max * B, wheeled) / np.trace(parameters.J_B))
    period = getattr(parameters, "control_period", None) or getattr(parameters, "command_period", 0.0)
    return float(min(w, SAMPLED / period)) if period else float(w)


def emptied_in(parameters: Any) -> float:
    """s: ten times slower than the attitude, and full wheels ask no more than a rod gives."""
    full = float(wheels(parameters)[2].sum())
    return max(SLOWER / frequency(parameters), full / (parameters.dipole_max * B))


def wheels(parameters: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Axes (n,3), torques (n,) N m and momenta (n,) N m s of the wheels that there are."""
    n = int(getattr(parameters, "wheels", 1))
    axes = np.reshape(parameters.wheel_axis, (-1, 3))[:n]
    return axes, np.ravel(parameters.wheel_torque_max)[:n], np.ravel(parameters.wheel_momentum_max)[:n]


@lru_cache
def _any_axis(axes: bytes, torques: bytes) -> float:
    """The torque that wheels give about any axis: the radius of the largest ball in {sum x_i a_i, |x_i| <= limit_i};
    zero where their axes lie in a plane."""
    a, limits = np.frombuffer(axes).reshape(-1, 3), np.frombuffer(torques)
    if np.linalg.matrix_rank(a) < 3:
        return 0.0
    normals = [np.cross(one, other) for one, other in combinations(a, 2)]
    return min(float(np.abs(a @ n) @ limits / np.linalg.norm(n)) for n in normals if np.linalg.norm(n) > 1e-6)
