"""Margins of the paper's loop: the same with each build of its controller, and the delay that they say loses it."""

from pathlib import Path

import numpy as np
import pytest

from fmus.build import ensure
from orchestration import load
from orchestration.margins.analysis import alike
from orchestration.margins.inject import Altered, Rig
from orchestration.margins.measure import measure
from orchestration.margins.search import pulse_dies_out
from orchestration.margins.site import site
from orchestration.session.open import open_scenario
from orchestration.session.session import Session
from tests.orchestration import as_fmi3

SCENARIO = Path("scenarios/paper_no_singularity.yaml").resolve()


def opened(**controller) -> Session:
    """The paper's loop at a step of 1 s, with another entry for its controller."""
    source = load(SCENARIO, {"step": 1.0, "duration": 386.0}).source
    entry = {**source.data["blocks"]["controller"], **controller}
    source.data["blocks"]["controller"] = entry
    return Session(open_scenario(load(source)))


def measured(session: Session):
    with session:
        rig = Rig(session, site(session.opened.plan, ["allocator.tau_cmd_B"]), 400)
        return measure(rig)


@pytest.fixture(scope="module")
def native():
    return measured(opened())


def test_a_controller_in_python_gives_the_same_response(native):
    np.testing.assert_allclose(measured(opened(flavour="python")).S, native.S, atol=1e-6)


@pytest.mark.compile
def test_a_foreign_fmu_of_fmi_3_gives_the_same_response(native, tmp_path):
    theirs = as_fmi3.write(tmp_path / "theirs.fmu", ensure("controller"))
    response = measured(opened(fmu=str(theirs), isolation="none", interface="controller"))
    np.testing.assert_allclose(response.S, native.S, atol=1e-6)


def test_a_flight_from_kept_states_has_the_bits_of_one_from_the_start():
    with opened() as session:
        rig = Rig(session, site(session.opened.plan, ["allocator.tau_cmd_B"]), 200)
        pulse = np.zeros((50, 3))
        pulse[0] = 1e-3 * rig.scales
        for altered in (Altered(), Altered(gain=0.9, delay=4)):
            anew = rig.fly(pulse, altered, starts=dict(session.opened.plan.starts))
            np.testing.assert_array_equal(rig.fly(pulse, altered), anew)
        assert session.kept(1) is not None


def test_the_delay_margin_brackets_the_loss_of_stability(native):
    margin = alike(native.omega, native.L).delay.value
    with opened() as session:
        rig = Rig(session, site(session.opened.plan, ["allocator.tau_cmd_B"]), 400)
        holds = pulse_dies_out(rig, 600)
        assert holds(Altered(delay=int(0.92 * margin)), None)
        assert not holds(Altered(delay=int(np.ceil(1.08 * margin))), None)
