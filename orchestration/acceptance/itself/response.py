"""A controller by itself: its response to a step about each axis, on a rigid body that its torque turns.

The body starts turned by 5 deg about one axis from the attitude that ours holds at the end of its run, and at rest
against it. Ours flies the same, so theirs stands beside it; where ours does not settle, nothing is judged.
Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import BlockError
from ...fmu.model import Floats
from ...rotation import about, three
from ..polarity.bench import Bench
from ..polarity.fly import Loop
from ..robustness import Trial
from .motion import level
from .signals import Signals

NAME = "it settles after a step about {}"
READ = "R_NB", "omega_B", "r_N", "v_N"
_STEP = np.radians(5.0)
_SETTLED = 0.1
"""Of the step."""
_SLOWER = 3.0
"""Theirs has so many times as long as ours, up to the end of the run."""
_STEPS = 6000


@dataclass(frozen=True)
class Response:
    """The course after a step: angles (n, 3), rad, about the body's axes, every step; and the first torque, N m."""

    time: Floats
    angles: Floats
    axis: int
    torque: Floats

    @property
    def size(self) -> Floats:
        return np.asarray(np.linalg.norm(self.angles, axis=1))

    @property
    def settled(self) -> float | None:
        """Returns since when it is within a tenth of the step, s; None where it is not in the end."""
        beyond = np.flatnonzero(self.size > _SETTLED * _STEP)
        last = beyond[-1] + 1 if len(beyond) else 0
        return float(self.time[last]) if last < len(self.time) else None

    @property
    def overshoot(self) -> float:
        """Returns how far it goes beyond, as a share of the step."""
        return max(0.0, float(-self.angles[:, self.axis].min()) / _STEP)

    @property
    def across(self) -> float:
        """Returns how far it turns about the other axes, as a share of the step."""
        return float(np.abs(np.delete(self.angles, self.axis, axis=1)).max()) / _STEP

    def words(self) -> str:
        when = f"{self.settled:.3g} s" if self.settled is not None else "not settled"
        return f"{when}, {100 * self.overshoot:.2g} % beyond, {100 * self.across:.2g} % about the other axes"


def responses(ours: Loop, theirs: Loop, block: str, run: Signals, inputs: dict[str, Floats]) -> Iterator[Trial]:
    """Yields how theirs settles after a step about each axis, beside ours.

    `run` has R_NB, r_N and v_N of our run at the block's steps, `inputs` (instants, elements) what it was given.
    """
    names = [NAME.format(axis) for axis in "xyz"]
    if why := run.lacks(*READ):
        yield from (Trial(name, "", why) for name in names)
        return
    J = run.parameter("J_B", 0.0)
    if J.shape != (3, 3):
        yield from (Trial(name, "", "the inertia is not told") for name in names)
        return
    held = _held(run)
    with ExitStack() as stack:
        benches = [Bench(loop, block, stack) for loop in (ours, theirs)]
        for axis, name in enumerate(names):
            try:
                first = _flown(benches[0], run, inputs, held, J, axis)
                if first.settled is None:
                    yield Trial(name, "", f"ours does not settle in this test: {first.words()}")
                    continue
                steps = int(_SLOWER * first.settled / benches[0].step) + 1
                yield _judged(name, first, _flown(benches[1], run, inputs, held, J, axis, steps))
            except BlockError as error:
                yield Trial(name, "failed", str(error))


def _judged(name: str, ours: Response, theirs: Response) -> Trial:
    text = f"{theirs.words()}; ours {ours.words()}"
    if theirs.settled is not None:
        return Trial(name, "met", text)
    torque, axis = theirs.torque, "xyz"[theirs.axis]
    along = torque[theirs.axis] / max(float(np.linalg.norm(torque)), 1e-300)
    if along > 0.5:
        text = f"its torque turns the body on, not back: {torque[theirs.axis]:.2g} N.m about +{axis}; {text}"
    elif along > -0.5 and np.linalg.norm(torque) > 0.0:
        other = int(np.argmax(np.abs(torque)))
        sign = "+" if torque[other] > 0.0 else "-"
        text = f"its torque is about {sign}{'xyz'[other]}, for a turn about +{axis}; {text}"
    elif theirs.size.max() > 2.0 * _STEP:
        text = (
            f"the error grows to {np.degrees(theirs.size.max()):.3g} deg, though its first torque turns it back; {text}"
        )
    return Trial(name, "failed", text)


def _held(run: Signals) -> Floats:
    """The attitude (n, 3, 3) that is held: that of the end of the run, at rest along LVLH or N, whichever it was."""
    R = run.values["R_NB"]
    local = level(run.values["r_N"], run.values["v_N"])
    last = R[-max(2, len(R) // 20)], R[-1]
    in_local = [L.T @ M for L, M in zip((local[-max(2, len(R) // 20)], local[-1]), last, strict=True)]

    def moved(pair: Any) -> float:
        return float(np.abs(pair[1] - pair[0]).max())

    if moved(in_local) < moved(last):
        return local @ in_local[1]
    return np.broadcast_to(last[1], R.shape)


def _flown(
    bench: Bench, run: Signals, inputs: dict[str, Floats], held: Floats, J: Floats, axis: int, steps: int = _STEPS
) -> Response:
    """The body from the step on. Raises BlockError."""
    h, count = bench.step, min(steps, _STEPS, len(run.time) - 1)
    step = _turn(_STEP * np.eye(3)[axis])
    R, omega = held[0] @ step, step.T @ (_vector(held[0].T @ held[1]) / h)
    angles, torques = [], []
    inverse = np.linalg.inv(J)
    for k in range(count):
        angles.append(_vector(held[k].T @ R))
        row = {name: values[k] for name, values in inputs.items()}
        row |= {"R_NB": R.ravel(), "omega_B": omega}
        out = bench.begun(row, h * count) if k == 0 else bench.advanced(row)
        tau = out["tau_cmd_B"]
        if not np.isfinite(tau).all():
            raise BlockError(bench.block, "DoStep", "its torque is not finite in the test of its step response")
        torques.append(tau)
        for _ in range(4):  # finer than the sample, for a fast tumble of a controller that is wrong
            omega = omega + 0.25 * h * inverse @ (tau - np.cross(omega, J @ omega))
            R = R @ _turn(0.25 * h * omega)
        if np.linalg.norm(omega) > 1.0:
            break
    time = run.time[: len(angles)] - run.time[0]
    return Response(time, np.array(angles), axis, torques[0])


def _turn(v: Floats) -> Floats:
    """exp of a rotation vector (3,), rad."""
    angle = float(np.linalg.norm(v))
    return np.array(about(v.tolist(), angle)).reshape(3, 3) if angle > 0.0 else np.eye(3)


def _vector(R: Floats) -> Floats:
    """log of a rotation matrix: its rotation vector (3,), rad."""
    return np.array(three(R.ravel().tolist(), "rotation vector"))
