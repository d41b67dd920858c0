"""What `orchestrate check` says of an FMU, and its exit status."""

from __future__ import annotations

import json
import re
import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest

from fmus.contents.description import Capabilities, model_description
from fmus.interface import load, parse
from orchestration.acceptance.check import _blocks, check
from orchestration.acceptance.facts import facts
from orchestration.errors import InputError
from orchestration.session.read import load as load_scenario
from tests.commands import orchestrate
from tests.machine import require_elf_tools

from .. import fmus, vendor
from ..wrong_inputs import SCENARIO

pytestmark = pytest.mark.compile

ROOT = Path(__file__).parents[3]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    fmus.write_pair(tmp_path, runnable=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def findings(path: Path, map_: Path | None = None, as_: str = "regulator.fmu", topic: str = "", level: str = ""):
    found, _ = check(path, as_, map_)
    return [f for f in found if (not topic or f.topic == topic) and (not level or f.level == level)]


def texts(found) -> str:
    return "\n".join(str(f) for f in found)


# ---------------------------------------------------------------- fits


def test_an_fmu_fits_its_own_interface(here):
    result = orchestrate("check", "regulator.fmu", "--as", "regulator.fmu")
    assert result.exit_code == 0
    assert re.search(r"^ok +port +input speed, a real scalar, rad/s$", result.stdout, re.M)
    assert result.stdout.endswith("\nfits: 1 warning\n"), "it says nothing of its step"


def test_the_project_s_own_blocks_fit_themselves_in_both_flavours(here):
    for flavour, warnings in (("native", 0), ("python", 2)):
        from fmus.build import ensure

        found = findings(ensure("allocator", flavour), as_="allocator")
        assert not [f for f in found if f.level == "error"]
        assert sum(f.level == "warning" for f in found) <= warnings


def test_a_mapping_makes_it_fit_and_the_factors_are_told(here):
    vendor.write(here, runnable=True)
    result = orchestrate("check", "vendor.fmu", "--as", "regulator.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 0
    assert "input speed = rate, a real scalar, rad/s to rpm: times 9.549296586" in result.stdout
    assert "output voltage = command, a real scalar, V to mV: times 1000" in result.stdout


def test_a_start_value_is_told_where_it_differs_from_ours_and_only_there(here):
    """Of a speed that starts at 0, a gain at -1 and a flag that is true."""
    assert findings(here / "regulator.fmu", topic="start") == []
    for old, new in (('<Boolean start="true"/>', '<Boolean start="false"/>'), ('start="-1"', 'start="-1.00001"')):
        vendor.write(here, (old, new), runnable=True, own_names=False)
        assert len(findings(here / "vendor.fmu", topic="start")) == 1


def test_the_facts_of_an_fmu_have_numbers_as_numbers_and_text_only_where_json_has_none(here):
    vendor.write(here, ('start="-1"', 'start="-INF"'), own_names=False)
    for path, start in ((here / "regulator.fmu", -1.0), (here / "vendor.fmu", "-inf")):
        by_name = {v["name"]: v["start"] for v in facts(str(path), lenient=True)["variables"]}
        assert (by_name["gain"], by_name["speed"], by_name["enabled"]) == (start, 0.0, True)


def test_the_blocks_of_a_scenario_are_found_by_their_interface_or_their_name(here):
    (here / "loop.yaml").write_text(SCENARIO, "utf-8")
    loop = load_scenario("loop.yaml")
    for as_ in ("regulator.fmu", "regulator"):
        assert _blocks(loop, as_) == ["regulator"]
    with pytest.raises(InputError, match="no block with the interface 'rotor'; its blocks are motor, regulator"):
        _blocks(loop, "rotor")


def test_json_says_the_same(here):
    vendor.write(here, runnable=True)
    result = orchestrate("check", "vendor.fmu", "--as", "regulator.fmu", "--json")
    told = json.loads(result.stdout)
    assert (result.exit_code, told["fits"]) == (1, False)
    assert {f["level"] for f in told["findings"]} <= {"ok", "note", "warning", "error"}
    assert all(f["remedy"] for f in told["findings"] if f["level"] in ("error", "warning"))


# ---------------------------------------------------------------- the file


def test_another_version_or_kind_does_not_fit(here):
    fmus.write(here / "one.fmu", fmus.description("regulator", version="1.0"))
    fmus.write(here / "exchange.fmu", fmus.description("regulator", kind="ModelExchange"))
    assert "is an FMU of FMI 1.0; expected FMI 2.0 or 3.0 for co-simulation; remedy: export it so" in texts(
        findings(here / "one.fmu")
    )
    assert "is for model exchange only; expected an FMU for co-simulation" in texts(findings(here / "exchange.fmu"))
    assert orchestrate("check", "one.fmu", "--as", "regulator.fmu").exit_code == 1


@pytest.mark.skipif(fmpy.platform != "linux64", reason="names the other platform")
def test_a_binary_for_another_platform_only_is_told_with_those_that_there_are(here):
    fmus.write(here / "vendor.fmu", fmus.description("regulator"), b"MZ", folder="win64")
    told = texts(findings(here / "vendor.fmu", topic="binary"))
    assert "none for this platform: expected binaries/linux64/probe.so, found binaries for win64" in told


def test_the_other_platforms_of_a_library_are_told_beside_this_one(here):
    path = here / "regulator.fmu"
    assert texts(findings(path, topic="binary")).endswith(", this platform; no other")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("binaries/other64/probe.so", b"")
    assert ", this platform; also other64\n" in texts(findings(path, topic="binary"))


def test_what_is_no_library_is_told(here):
    fmus.write(here / "vendor.fmu", fmus.description("regulator"), b"text")
    assert "it is no shared library" in texts(findings(here / "vendor.fmu", topic="binary", level="error"))
    damaged = fmus.library()[:2000]
    fmus.write(here / "vendor.fmu", fmus.description("regulator"), damaged)
    assert "its tables are damaged" in texts(findings(here / "vendor.fmu", topic="binary", level="error"))


def test_missing_functions_symbols_and_libraries_are_told_without_loading_it(here):
    require_elf_tools("cc")
    folder = fmus.Path(__file__).parents[1]
    source = folder.joinpath("probe.c").read_text()
    source = source.replace('#include "small_fmu.h"', folder.joinpath("small_fmu.h").read_text())
    source = source.replace("fmi2DoStep(", "FMI2_doStep(").replace(
        "(void)keep;", "(void)keep; extern int vendor_driver(void); vendor_driver();"
    )
    source = source.replace("UNUSED(fmi2CancelStep, void *c)", "")
    (here / "p.c").write_text(source)
    (here / "q.c").write_text("int q(void) { return 1; }")
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-o", "libvendorrt.so.3", "-Wl,-soname,libvendorrt.so.3", "q.c"], check=True
    )
    for needed, topic, message in (
        ([], "symbols", "linux64: needs symbols that no library gives it: vendor_driver"),
        (
            ["-Wl,--no-as-needed", "libvendorrt.so.3"],
            "symbols",
            "needs libraries that this machine has not: libvendorrt.so.3",
        ),
        ([], "functions", "linux64: the library lacks fmi2DoStep"),
    ):
        subprocess.run(["cc", "-shared", "-fPIC", "-w", "-o", "p.so", "p.c", *needed], check=True)
        fmus.write(here / "vendor.fmu", fmus.description("regulator"), (here / "p.so").read_bytes())
        assert message in texts(findings(here / "vendor.fmu", topic=topic, level="error"))


def test_what_it_asks_of_its_host_is_told(here):
    fmus.write(
        here / "vendor.fmu",
        fmus.description("regulator").replace(
            "modelIdentifier=", 'needsExecutionTool="true" canBeInstantiatedOnlyOncePerProcess="true" modelIdentifier='
        ),
        fmus.library(),
    )
    told = texts(findings(here / "vendor.fmu", topic="host"))
    assert "needs the tool or the interpreter that made it" in told
    assert "one instance in a process only" in told


def test_what_the_validator_finds_is_told(here):
    vendor.write(here, ('<Real start="-1"/>', "<Real/>"), own_names=False)
    assert 'Variable "gain"' in texts(findings(here / "vendor.fmu"))


# ---------------------------------------------------------------- ports


@pytest.mark.parametrize(
    ("change", "topic", "level", "message"),
    [
        (
            ('name="speed" valueReference="2"', 'name="spede" valueReference="2"'),
            "missing",
            "error",
            "input speed, a real scalar in rad/s, is missing; by name or unit it may be spede; remedy: 'speed: "
            "spede' under ports in the mapping",
        ),
        (('name="voltage"', 'name="v"'), "missing", "note", "output voltage"),
        (
            ('<Real unit="rad/s" start="0"/>', '<Real unit="V" start="0"/>'),
            "unit",
            "error",
            "input speed: the units do not fit: ours is rad/s, theirs V",
        ),
        (
            ('<BaseUnit s="-1" rad="1"/>', '<BaseUnit s="-1" rad="1" factor="0.017"/>'),
            "unit",
            "error",
            "the FMU declares the unit rad/s to be 0.017 s-1.rad, but usually it is 1 s-1.rad",
        ),
        (
            ('<BaseUnit s="-1" rad="1"/>', '<BaseUnit s="-1"/>'),
            "unit",
            "error",
            "they differ by the radian only: state what it is, such as 'unit: rad/s'",
        ),
        (
            ('<Real unit="rad/s" start="0"/>', '<Real start="0"/>'),
            "unit",
            "warning",
            "input speed: theirs has no unit, so it is taken to be in rad/s",
        ),
        (
            ('<Real unit="rad/s" start="0"/>', '<Integer start="0"/>'),
            "type",
            "error",
            "speed is integer, expected real",
        ),
        (('<Boolean start="true"/>', '<Integer start="1"/>'), "type", "error", "enabled is integer, expected boolean"),
        (
            (
                'name="samples[2]" valueReference="21" causality="output"',
                'name="samples[3]" valueReference="21" causality="output"',
            ),
            "missing",
            "note",
            "output samples, a real [2]",
        ),
        (
            (
                'name="gain" valueReference="3" causality="parameter" variability="tunable"',
                'name="gain" valueReference="3" causality="input"',
            ),
            "causality",
            "note",
            "gain is an input, which keeps its start value unless it is connected",
        ),
        (('<Real start="-1"/>', '<Real start="-2"/>'), "start", "note", "gain: -2, ours -1"),
        (
            ('<Unknown index="5" dependencies="3"/>', '<Unknown index="5"/>'),
            "feedthrough",
            "warning",
            "does not say on which inputs voltage depends directly",
        ),
        (
            ('<Unknown index="7" dependencies=""/>', '<Unknown index="7" dependencies="3"/>'),
            "feedthrough",
            "note",
            "depends directly where ours does not: samples on speed",
        ),
    ],
)
def test_what_differs_is_told_by_name(here, change, topic, level, message):
    path = vendor.write(here, change, own_names=False)
    assert message in texts(findings(path, topic=topic, level=level))


def test_outputs_of_an_fmu_without_inputs_depend_on_none(here):
    speed = 'name="speed" valueReference="2" causality="input"'
    enabled = 'valueReference="5" causality="input"'
    none = [(text, text.replace("input", "local")) for text in (speed, enabled)]
    undeclared = ('<Unknown index="5" dependencies="3"/>', '<Unknown index="5"/>')
    path = vendor.write(here, *none, undeclared, own_names=False)
    assert texts(findings(path, topic="feedthrough")) == "closes no algebraic loop"


@pytest.mark.parametrize("step", ["0", "-1", "INF", "NaN"])
def test_a_step_that_is_none_does_not_fit(here, step):
    change = ("<ModelVariables>", f'<DefaultExperiment stepSize="{step}"/><ModelVariables>')
    told = texts(findings(vendor.write(here, change, own_names=False), topic="step", level="error"))
    assert f"its stepSize is {step}, expected a finite number above 0; remedy: declare" in told


def test_an_extra_input_does_not_fit_unless_the_mapping_feeds_it(here):
    extra = '<ScalarVariable name="samples[1]"'
    path = vendor.write(
        here,
        (
            extra,
            '<ScalarVariable name="brake" valueReference="30" causality="input"><Real start="0"/></ScalarVariable>'
            + extra,
        ),
        ('index="7"', 'index="8"'),
        ('index="8" dependencies=""/><Unknown index="8"', 'index="8" dependencies=""/><Unknown index="9"'),
        own_names=False,
    )
    assert "input brake, a real scalar, is only in their FMU, and nothing feeds it" in texts(
        findings(path, level="error")
    )
    (here / "mapping.yaml").write_text("start: {brake: 0.5}")
    assert "input brake of theirs is 0.5, as the mapping says" in texts(
        findings(path, here / "mapping.yaml", topic="extra")
    )


def test_a_dependence_that_closes_a_loop_with_the_other_blocks_does_not_fit(here):
    text = load("plant").source
    plant = load("plant")
    assert not plant.variables["r_N"].depends_on
    text = text.replace("[variables.r_N]\n", '[variables.r_N]\ndepends_on = ["wheel_torque_cmd"]\n', 1)
    xml = model_description(parse(text), "{1}", Capabilities(needsExecutionTool=False), "test").decode()
    with zipfile.ZipFile(here / "vendor.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", xml)
    (told,) = [f.text for f in findings(here / "vendor.fmu", as_="plant", topic="feedthrough", level="error")]
    for name in ("plant.r_N", "controller.tau_cmd_B", "allocator.wheel_torque_cmd"):
        assert name in told


def test_a_hostile_description_is_not_read(here):
    xml = fmus.description("regulator").replace(
        "<fmiModelDescription", '<!DOCTYPE x [<!ENTITY a "b">]>\n<fmiModelDescription', 1
    )
    fmus.write(here / "vendor.fmu", xml)
    result = orchestrate("check", "vendor.fmu", "--as", "regulator.fmu")
    assert (result.exit_code, "has a DOCTYPE" in result.stderr) == (2, True)


def test_an_interface_is_one_of_the_project_s_or_an_fmu(here):
    for arguments, message in (
        (("regulator.fmu", "--as", "alocator"), "this project has no interface 'alocator'; did you mean 'allocator'?"),
        (("regulater.fmu", "--as", "allocator"), "there is no FMU regulater.fmu; did you mean 'regulator.fmu'?"),
        (("regulator.fmu", "--as", "motr.fmu"), "there is no FMU motr.fmu; did you mean 'motor.fmu'?"),
        (("regulator.fmu", "--as", "motor.fmu", "--map", "no.yaml"), "no.yaml: there is no such file"),
    ):
        result = orchestrate("check", *arguments)
        assert result.exit_code == 2
        assert message in result.stderr


# ---------------------------------------------------------------- what a run would refuse


def test_an_output_that_others_need_is_not_ignored(tmp_path):
    from fmus.build import ensure

    (tmp_path / "mapping.yaml").write_text("ports: {}\nignore: [dipole_cmd]\n")
    allocator, map_ = ensure("allocator", "native"), tmp_path / "mapping.yaml"
    told = texts(findings(allocator, map_, "allocator", level="error"))
    assert told.startswith(
        "output dipole_cmd is ignored, but other blocks need it; remedy: map it: 'dipole_cmd: THEIRS'"
    )
    scenario = load_scenario(ROOT / "scenarios" / "paper_no_singularity.yaml")
    found, _ = check(allocator, "allocator", map_, scenario=scenario)
    assert "output dipole_cmd is ignored, but plant.dipole_cmd needs it" in texts(found)
    (tmp_path / "mapping.yaml").write_text("ports: {}\nignore: [demand_fraction]\n")
    assert findings(allocator, map_, "allocator", level="error") == []


@pytest.mark.parametrize("declared", ['deg"><BaseUnit rad="1" factor="0.0174532925199433"/>', 'm"><BaseUnit m="1"/>'])
def test_a_unit_that_a_mapping_can_correct_needs_no_other_fmu(here, declared):
    """Gyros in deg/s whose FMU declares deg."""
    unit = declared.partition('"')[0]
    changes = ('<Unit name="rpm">', f'<Unit name="{declared}</Unit><Unit name="rpm">'), ('unit="rpm"', f'unit="{unit}"')
    vendor.write(here, *changes, runnable=True)
    (refused,) = findings(here / "vendor.fmu", here / "mapping.yaml", topic="unit", level="error")
    assert (
        "where the FMU declares a wrong unit, state the right one in the mapping, such as 'unit: rad/s'"
        in refused.remedy
    )
    stated = vendor.MAPPING.replace("speed: rate", "speed: {theirs: rate, unit: deg/s}")
    (here / "mapping.yaml").write_text(stated)
    assert findings(here / "vendor.fmu", here / "mapping.yaml", level="error") == []
