"""The example of a hardware team's allocator in the place of ours."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from fmus import kit
from fmus.interface import parse
from orchestration import load, run
from orchestration.acceptance.compare import compare
from orchestration.session.read import read
from orchestration.swap.option import swapped, swaps_of
from tests.commands import orchestrate

from .test_kit import ROOT, make

EXAMPLE = ROOT / "examples" / "hardware_allocator"
SCENARIO = ROOT / "scenarios" / "paper_no_singularity.yaml"
pytestmark = pytest.mark.usefixtures("c_compiler")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory) -> Path:
    """actuators.fmu, built beside copies of its sources."""
    folder = tmp_path_factory.mktemp("example")
    shutil.copytree(EXAMPLE, folder / "it", ignore=shutil.ignore_patterns("build", "*.fmu"))
    native = ROOT / "fmus" / "native"
    built = make(
        folder / "it", f"FMI_SHELL={native / 'shell'}", f"COMMON={native / 'common'}", f"TOOLS={ROOT / 'fmus' / 'kit'}"
    )
    assert built.returncode == 0, built.stderr
    return folder / "it" / "actuators.fmu"


@pytest.fixture(scope="module")
def flown(fmu):
    """V.B with their allocator."""
    return run(load(swapped(read(SCENARIO), swaps_of([f"allocator={fmu}"], [str(EXAMPLE / "mapping.yaml")]))))


def test_what_is_generated_is_that_of_its_interface():
    interface = parse((EXAMPLE / "interface.toml").read_text("utf-8"))
    for name, text in kit.generated(interface).items():
        assert (EXAMPLE / "generated" / name).read_text("utf-8") == text, (
            "python -m fmus.kit examples/hardware_allocator"
        )
    makefile = kit.makefile(interface, "../../fmus/native/shell", "../../fmus/native/common", "../../fmus/kit")
    parts = [part for part in makefile.split("\n\n") if part.startswith("#") or "vector" not in part]
    without_vector = ("\n".join(line for line in part.split("\n") if "vector" not in line) for part in parts)
    assert (EXAMPLE / "Makefile").read_text("utf-8") == "\n\n".join(without_vector)


def test_it_fits_with_its_mapping_and_not_without(fmu):
    assert orchestrate("check", fmu, "--as", "allocator").exit_code == 1
    result = orchestrate("check", fmu, "--as", "allocator", "--map", EXAMPLE / "mapping.yaml")
    assert result.exit_code == 0, result.stdout
    assert "ERROR" not in result.stdout


def test_the_paper_s_claims_of_v_b_hold_with_it(flown):
    assert len(flown.outcomes) >= 6
    assert [o.name for o in flown.outcomes if not o.passed] == []
    assert any("the expectation 'never held'" in warning for warning in flown.warnings)


def test_its_coils_are_quantised_and_off_while_the_magnetometer_is_read(flown):
    steps = flown["allocator.dipole_cmd"] / 0.1  # A m2, of 100 mA m2
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    off = ~flown["allocator.coils_on"]
    assert not flown["allocator.dipole_cmd"][off].any()
    assert off.mean() == pytest.approx(0.1 / 2.0, abs=1e-3)


def compared(fmu: Path, mapping: Path, duration: str, *tolerance: str):
    """Theirs against ours in V.B, without the page."""
    source = read(SCENARIO).with_value("duration", duration, "--duration")
    theirs = swapped(source, swaps_of([f"allocator={fmu}"], [str(mapping)]))
    return compare(source, theirs, "allocator", tolerance)


def test_signs_axes_and_units_are_those_of_ours(fmu, tmp_path):
    """Without quantisation, off-time and dead band it is our law, found by another team's arithmetic."""
    text = (EXAMPLE / "mapping.yaml").read_text()
    ideal = text.replace("off_time: 100 ms", "off_time: 0")
    ideal = ideal.replace("coil_step: 100 mA.m2", "coil_step: 0\n  coil_dead_band: 0")
    (tmp_path / "ideal.yaml").write_text(ideal)
    found = compared(fmu, tmp_path / "ideal.yaml", "100 s", "1e-9")
    shares = {d.output: d.share for d in found.differences if d.largest is not None}
    assert set(shares) == {"dipole_cmd", "wheel_torque_cmd", "b_wheel"}
    assert max(shares.values()) < 1e-12
    assert found.passed


def test_a_wrong_sign_in_the_mapping_is_seen(fmu, tmp_path):
    text = (EXAMPLE / "mapping.yaml").read_text()
    (tmp_path / "wrong.yaml").write_text(text.replace("scale: -1", "scale: 1"))
    found = compared(fmu, tmp_path / "wrong.yaml", "10 s", "dipole_cmd=100 %")
    assert [d.output for d in found.differences if not d.passed] == ["wheel_torque_cmd"]
    assert not found.passed


def test_it_is_equivalent_within_its_own_tolerances(fmu):
    found = compared(fmu, EXAMPLE / "mapping.yaml", "386.1 s", str(EXAMPLE / "tolerances.yaml"))
    assert found.passed, found.differences
    assert sum(theirs is None for _, theirs in found.claims) == 1, "the hold, which theirs does without"


def test_its_friction_compensation_gives_the_wheel_what_is_asked(fmu, tmp_path):
    """A wheel with friction stands still under small torques; compensated, its momentum follows that of a wheel
    without."""

    def fly(friction: float, compensated: float):
        source = swapped(read(SCENARIO), swaps_of([f"allocator={fmu}"], [str(EXAMPLE / "mapping.yaml")]))
        values = {
            "plant.wheel_viscous_friction": friction,  # N m s/rad
            "allocator.friction_viscous": f"{compensated!r} N.m.s/rad",
            "duration": "60 s",
        }
        return run(load(source, values))["plant.h_w"]

    ideal, bare, helped = fly(0.0, 0.0), fly(3e-6, 0.0), fly(3e-6, 3e-6)
    assert np.abs(helped - ideal).max() < 0.15 * np.abs(bare - ideal).max()
