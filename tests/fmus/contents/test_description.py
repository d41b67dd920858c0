"""modelDescription.xml says what the interface says, in the words of FMI 2.0."""

from __future__ import annotations

import csv
import itertools
import math
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import asdict
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from fmus.build import ensure
from fmus.contents.description import Capabilities, model_description
from fmus.contents.references import kept_in
from fmus.interface import ABSENT_MIN, BLOCKS, Interface, InterfaceError, load, parse
from tests.blocks import folder

ROOT = Path(__file__).parents[3]


def _built(built_fmus: dict[str, Path], block: str) -> Path:
    """Its Python FMU, or the native one where it has no other."""
    return built_fmus.get(block) or ensure(block)


@pytest.mark.parametrize("block", BLOCKS)
def test_fmpy_finds_nothing_wrong_with_an_fmu(built_fmus: dict[str, Path], block: str) -> None:
    assert validate_fmu(str(_built(built_fmus, block))) == []


@pytest.mark.parametrize("block", BLOCKS)
def test_the_xml_that_fmpy_reads_is_the_interface(built_fmus: dict[str, Path], block: str) -> None:
    interface, read = load(block), fmpy.read_model_description(str(_built(built_fmus, block)))
    assert [v.name for v in read.modelVariables] == list(interface.elements)
    for found in read.modelVariables:
        variable, element = interface.elements[found.name]
        assert found.type.lower() == variable.type
        assert found.valueReference == element.value_reference
        assert (found.causality, found.variability) == (variable.causality, variable.variability)
        # FMPy fills in the standard's default, "exact", where an input says nothing
        assert found.initial == {"input": "exact", "output": "calculated", "parameter": "exact"}[variable.causality]
        assert variable.description in found.description
        assert variable.frame is None or variable.frame in found.description
        in_N = variable.frame is not None and "N" in variable.frame.split()
        assert ("mean equator and equinox of date" in found.description) == in_N
        own = variable.units[variable.elements.index(element)]
        assert found.unit == ((own or "1") if variable.type == "real" else None)
        assert found.displayUnit == variable.display_unit
        nominal = variable.nominals[variable.elements.index(element)]
        stated = [size if size is None else float(size) for size in (found.min, found.max, found.nominal)]
        assert stated == [variable.min, variable.max, nominal]
        if variable.type == "enumeration":
            assert tuple(item.name for item in found.declaredType.items) == variable.items
            assert [item.value for item in found.declaredType.items] == [str(i + 1) for i in range(len(variable.items))]
        if element.start is None:
            assert found.start is None
        elif variable.type == "real":
            assert float(found.start) == element.start
        else:
            assert found.start == (str(element.start).lower() if variable.type == "boolean" else str(element.start))
    assert read.defaultExperiment is not None
    assert float(read.defaultExperiment.stopTime) == interface.stop
    assert float(read.defaultExperiment.stepSize) == interface.step


@pytest.mark.parametrize("block", BLOCKS)
def test_starts_and_flown_inputs_are_within_the_limits_that_tools_are_told(block: str) -> None:
    interface = load(block)
    values = {e.name: [e.start] for v in interface.variables.values() if v.type == "real" for e in v.elements}
    for path in kept_in(interface, folder(block)):
        if path.suffix == ".csv":
            for row in csv.DictReader(path.read_text("utf-8").splitlines()):
                for name in row.keys() & values.keys():
                    values[name].append(float(row[name]))
    for variable in interface.variables.values():
        low, high = (-math.inf if variable.min is None else variable.min), variable.max or math.inf
        for element in variable.elements if variable.causality != "output" else ():
            assert all(low <= value <= high for value in values.get(element.name, ())), element.name


def test_limits_of_inputs_are_those_of_attitudes_orbits_fields_and_rates() -> None:
    """Those of torques, dipoles and momentum are parameters, so that no number can stand there."""
    limits = {
        "r_N": (1.3 * 5.0e7, 1e9),  # m: beyond the largest orbit_radius, and far below the Moon
        "v_N": (math.sqrt(2.0 * 3.986e14 / 6.478e6), 3e4),  # m/s: escape
        "b_B": (7e-5, 1e-2),  # T: the largest field at the surface
        "omega_B": (10.0 * math.sqrt(3.0), math.inf),  # rad/s: the fastest start of the plant
        "R_NB": (1.0, 1.001),
    }
    bounded = set()
    for block, name in itertools.product(BLOCKS, limits):
        for variable in (load(block).variables.get(f"{name}{suffix}") for suffix in ("", "_measured")):
            if variable is not None and variable.causality == "input":
                bounded.add(block)
                least, beyond = limits[name]
                ends = (-variable.min, 1e9 if variable.optional else variable.max)
                assert all(end == 1e9 or least < end < beyond for end in ends), (block, variable.name)
    assert set(BLOCKS) - bounded == {"plant", "plant_wheels"}


@pytest.mark.parametrize("block", BLOCKS)
def test_no_value_of_the_reference_data_is_far_above_its_variable_s_nominal_value(block: str) -> None:
    """Tools scale residuals and steps by it: without one, a position of 7e6 m stands where 1 is expected."""
    interface = load(block)
    tables = [path for path in kept_in(interface, folder(block)) if path.suffix == ".csv"]
    assert len(tables) == 2
    for path in tables:
        for name, *cells in zip(*csv.reader(path.read_text("utf-8").splitlines()), strict=True):
            variable, element = interface.elements.get(name, (None, None))
            if variable is not None and variable.type == "real":
                largest = max((abs(x) for x in map(float, cells) if abs(x) < ABSENT_MIN), default=0.0)
                assert largest <= 1000.0 * (variable.nominals[variable.elements.index(element)] or 1.0), name


@pytest.mark.parametrize(
    "line", ["nominal = 0.0", "nominal = -1.0", "nominal = inf", "nominal = [1.0, 2.0]", 'nominal = "1 km"']
)
def test_a_nominal_value_that_is_no_size_is_refused_by_name(line: str) -> None:
    text = load("controller").source.replace("nominal = 7e6", line, 1)
    with pytest.raises(InterfaceError, match=r"controller.toml: variables.r_N: nominal: expected"):
        parse(text, "controller.toml")


@pytest.mark.parametrize("block", BLOCKS)
def test_outputs_and_initial_unknowns_list_the_interface_s_dependencies(
    built_fmus: dict[str, Path], block: str
) -> None:
    interface, read = load(block), fmpy.read_model_description(str(_built(built_fmus, block)))
    for unknowns, resolve in (
        (read.outputs, interface.feedthrough),
        (read.initialUnknowns, interface.initial_dependencies),
    ):
        found = {u.variable.name: {d.name for d in u.dependencies} for u in unknowns}
        expected = {
            element.name: {e.name for e in resolve(variable, i)}
            for variable in interface.of("output")
            for i, element in enumerate(variable.elements)
        }
        assert found == expected
        assert all(set(u.dependenciesKind) <= {"dependent"} for u in unknowns)


def test_the_plant_has_no_feedthrough_to_what_the_laws_see(built_fmus: dict[str, Path]) -> None:
    """This is what makes the loop free of algebraic loops."""
    read = fmpy.read_model_description(str(built_fmus["plant"]))
    free = {u.variable.name.partition("[")[0] for u in read.outputs if not u.dependencies}
    assert {"R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w"} <= free


@pytest.mark.parametrize("capable", [True, False])
def test_the_capabilities_are_those_of_the_flavour(capable: bool, plant: Interface) -> None:
    chosen = Capabilities(needsExecutionTool=not capable, canSerializeFMUstate=capable)
    text = model_description(plant, "{0}", chosen, "tool").decode()
    for name, value in asdict(chosen).items():
        assert f'{name}="{str(value).lower()}"' in text


@pytest.fixture
def plant() -> Interface:
    return load("plant")


def test_elements_say_their_axes_and_items_what_they_mean() -> None:
    def described(block: str) -> tuple[dict[str, str], dict[str, str]]:
        root = ET.fromstring(model_description(load(block), "{}", Capabilities(False), "tool"))
        elements = {v.attrib["name"]: v.attrib["description"] for v in root.iter("ScalarVariable")}
        return elements, {i.attrib["name"]: i.attrib.get("description", "") for i in root.iter("Item")}

    plant, _ = described("plant")
    assert plant["omega_B[2]"] == "Body rate relative to N (frame: B) [y]"
    assert plant["R_NB[2,3]"].endswith("[row y, column z]")
    assert plant["q_NB[1]"].endswith("[scalar]")
    assert plant["dipole_cmd[3]"].endswith("[rod 3]")
    wheels, _ = described("plant_wheels")
    assert wheels["wheel_axis[2,3]"].endswith("[wheel 2, z]")
    assert wheels["h_w[4]"].endswith("[wheel 4]")
    for block in BLOCKS:
        _, items = described(block)
        assert all(items.values()), block
    assert described("controller")[1]["inertial"] == "hold R_d0 in N"


def test_the_description_has_its_authors_version_and_a_date_that_is_no_builds() -> None:
    root = fmpy.read_model_description(str(ensure("allocator", here=True)))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert (root.version, root.author) == (project["version"], "the attitude-cosim authors")
    assert root.copyright == "Copyright (c) 2026, the attitude-cosim authors"
    assert root.generationDateAndTime == "2026-11-21T00:00:00Z"
    assert float(root.defaultExperiment.tolerance) > 0.0
