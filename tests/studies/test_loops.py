"""Many loops at once against the blocks' own, case by case and signal by signal."""

import math

import numpy as np
import pytest

from studies.claims import constants
from studies.loops import Loops
from studies.setup import read
from studies.watch import fly
from tests.studies import flown

FULL = np.array([[0.0426, 0.002, -0.003], [0.002, 0.0608, 0.001], [-0.003, 0.001, 0.0618]])
SIGNALS = {
    "attitude_error": lambda p, c, a: c.attitude_error,
    "rate_error_B": lambda p, c, a: c.rate_error_B,
    "lyapunov": lambda p, c, a: c.lyapunov,
    "tau_cmd_B": lambda p, c, a: c.tau_cmd_B,
    "dipole_cmd": lambda p, c, a: a.dipole_cmd,
    "wheel_torque_cmd": lambda p, c, a: a.wheel_torque_cmd,
    "holding": lambda p, c, a: a.holding,
    "b_wheel": lambda p, c, a: a.b_wheel,
    "b_B": lambda p, c, a: p.b_B,
    "h_w": lambda p, c, a: p.h_w,
    "dipole": lambda p, c, a: p.dipole,
    "dipole_saturated": lambda p, c, a: p.dipole_saturated,
    "wheel_momentum_saturated": lambda p, c, a: p.wheel_momentum_saturated,
}


def cases():
    loop = read("scenarios/paper_singularity.yaml").loop.change({"plant.integrator_order": 2})
    return [
        loop,
        # The hold latches and drives the wheel into its limit; drag counts.
        loop.change({"plant.node_longitude": math.radians(200.0), "plant.drag_factor": 5.0}),
        # Every term of the moment, full inertias that differ, another Phi, constant gains, a true dipole limit below the law's.
        loop.change(
            constants(k=0.5)
            | {
                "plant.J_B": FULL,
                "plant.J_error_B": 0.05 * FULL,
                "controller.J_B": FULL,
                "controller.L0": 0.3 * FULL,
                "controller.phi": "logarithm",
                "controller.phi_scale": 1e-3,
                "controller.gain_schedule": "constant",
                "controller.kappa0": 0.012,
                "controller.lambda0": 0.16,
                "plant.residual_dipole_B": [0.5, -0.3, 0.2],
                "plant.disturbance_torque_B": [1e-6, 2e-6, -1e-6],
                "plant.h_w0": 0.004,
                "plant.dipole_max": 8.0,
                "plant.node_longitude": 1.0,
                "plant.epoch": "2012-02-03T04:05:06Z",
            }
        ),
    ]


@pytest.mark.parametrize("step", [0.1, 0.25])
def test_loops_flown_together_are_the_blocks_loops(step):
    samples = []
    Loops(cases()).fly(step, 60.0, samples.append)
    for i, loop in enumerate(cases()):
        alone = flown.fly(loop, step, 60.0)
        assert len(alone) == len(samples)
        for name, of in SIGNALS.items():
            expected = np.array([of(*y) for y in alone], float)
            found = np.array([np.asarray(getattr(s, name), float)[..., i] for s in samples])
            scale = max(np.abs(expected).max(), 1e-12)
            assert np.abs(found - expected).max() <= 1e-9 * scale, (i, name)
    assert samples[-1].wheel_momentum_saturated[1]  # so the step that the wheel's limit divides was flown
    assert samples[-1].dipole_saturated[2] or any(s.dipole_saturated[2] for s in samples)


def test_what_many_loops_cannot_fly_is_refused_by_name():
    loop = cases()[0].change({"plant.integrator_order": 4})
    with pytest.raises(ValueError, match=r"plant\.integrator_order is 4"):
        Loops([loop])


def test_the_figures_of_a_run_are_those_of_its_signals():
    loop = cases()[0]
    seen = fly([loop], 0.1, 60.0).pick(0)
    alone = flown.fly(loop, 0.1, 60.0)
    held = [i for i, (_, _, a) in enumerate(alone) if a.holding]
    assert seen["held"] == pytest.approx(0.1 * held[0])
    assert seen["hold_ends"] == pytest.approx(0.1 * (held[-1] + 1))
    assert seen["holds"] == 1
    assert seen["held_at_zero"] == 0
    assert seen["dipole"] == pytest.approx(max(np.abs(p.dipole).max() for p, _, _ in alone))
    assert seen["wheel_momentum"] == pytest.approx(max(abs(p.h_w) for p, _, _ in alone))
    assert math.isnan(seen["settled"])  # 60 s are too short
