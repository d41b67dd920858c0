"""The least change that loses a loop, beside what its characteristic polynomial says."""

import control
import numpy as np
import pytest

from orchestration.errors import InputError
from orchestration.margins.analysis import alike, loci
from orchestration.margins.inject import Altered
from orchestration.margins.measure import measure
from orchestration.margins.search import Change, lost, pulse_dies_out

from .loops import STEP, law, linear, rig
from .test_measure import GAINS, A, B, lagging


def unstable(gain: float, delay: int) -> bool:
    """Whether the loop with these has a pole outside the unit circle."""
    line = np.eye(3 + delay, k=-1)
    line[:3, :3], line[3:, :3] = A, 0.0
    if delay:
        line[:3, 3:], line[3, :], line[:3, -1] = 0.0, 0.0, B[:, 0]
        line[3, :3] = -gain * GAINS
    else:
        line[:3, :3] -= gain * B @ GAINS[None, :]
    return bool(np.abs(np.linalg.eigvals(line)).max() > 1)


@pytest.fixture(scope="module")
def response():
    return measure(rig(lagging))


def test_the_delay_that_loses_the_loop_is_that_of_its_poles_and_of_the_margin(response):
    steps = next(n for n in range(1, 100) if unstable(1.0, n))
    found = lost(rig(lagging), Change("delay", 0.0, 5.0), pulse_dies_out(rig(lagging), 600))
    assert found.holds < steps * STEP <= found.lost + 1e-9
    assert found.lost - found.holds <= 1.01 * STEP + 0.02 * found.lost
    margin = alike(response.omega, response.L).delay.value
    assert (steps - 1) * STEP < margin < steps * STEP * 1.05


@pytest.mark.parametrize(("start", "end"), [(1.0, 0.3), (1.0, 100.0)])
def test_the_gain_that_loses_the_loop_is_that_of_its_poles(start, end, response):
    loop = rig(lagging)
    found = lost(loop, Change("gain", start, end), pulse_dies_out(loop, 600))
    if end < 1:
        assert found.lost == np.inf
        return
    assert not unstable(0.98 * found.holds, 0)
    assert unstable(1.02 * found.lost, 0)
    assert found.lost / found.holds < 1.03
    assert alike(response.omega, response.L).gain_up.value == pytest.approx(found.lost, rel=0.03)


def test_the_loci_are_curves_of_eigenvalues():
    omega = np.geomspace(0.1, 10, 50)
    first, second = 1 / (1j * omega), 50 / (1 + 1j * omega)
    turn = np.array([[1.0, 0.4], [-0.3, 1.0]])
    L = turn @ (np.stack([first, second], axis=1)[:, :, None] * np.linalg.inv(turn))
    curves = loci(L)
    k = int(np.abs(curves[0] - first[0]).argmin())
    np.testing.assert_allclose(curves[:, [k, 1 - k]], np.stack([first, second], axis=1), rtol=1e-9)


def test_a_loop_that_does_not_hold_to_begin_with_is_refused():
    loop = rig(lambda: [linear(A, B, np.eye(3)), law(lambda y: GAINS @ y, 3)])
    with pytest.raises(InputError, match="the loop does not hold at 1, where it should"):
        lost(loop, Change("gain", 1.0, 2.0), pulse_dies_out(loop, 200))


@pytest.mark.parametrize("text", ["gain", "gain=1", "gain=1..1", "gain=0..2", "delay=-1..2", "=1..2", "gain=1..nan"])
def test_a_wrong_change_is_refused(text):
    with pytest.raises(InputError, match="expected NAME=FROM..TO with two numbers"):
        Change.of(text)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("plan.x", "there is no block 'plan'; did you mean 'plant'?"),
        ("plant.x", "plant has no parameter 'x'"),
        ("x", "expected block.variable"),
    ],
)
def test_a_parameter_that_is_none_is_refused(name, message):
    loop = rig(lagging)
    with pytest.raises(InputError, match=message):
        lost(loop, Change(name, 1.0, 2.0), pulse_dies_out(loop, 10))


def test_the_witness_of_this_file_agrees_with_python_control():
    gain = control.stability_margins(control.ss(A, B, GAINS[None, :], 0, STEP), method="frd")[0]
    assert not unstable(0.99 * gain, 0)
    assert unstable(1.01 * gain, 0)


def test_a_loop_that_is_lost_at_once_and_stands_at_its_limits_does_not_hold():
    """With a gain of 1000 the law switches between its limits, where pulses change little."""
    loop = rig(lambda: [linear(A, B, np.eye(3)), law(lambda y: np.clip(-GAINS @ y, -1e6, 1e6), 3)], first=400)
    holds = pulse_dies_out(loop, 300)
    assert holds(Altered(), None)
    assert not holds(Altered(gain=1e3), None)
