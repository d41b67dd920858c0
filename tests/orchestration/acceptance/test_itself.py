"""A block judged by itself: what is planted in a plant, a controller or an estimator is told in its words, and a right
one keeps all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fmus.field import EarthField
from orchestration.acceptance.accept import accept
from orchestration.acceptance.check import check
from orchestration.acceptance.itself.block import plant
from orchestration.acceptance.itself.estimate import NAMES as ESTIMATES
from orchestration.acceptance.itself.estimate import estimate
from orchestration.acceptance.itself.signals import Signals, signals, told
from orchestration.acceptance.robustness import Trial
from orchestration.acceptance.suggest import suggest
from orchestration.scenario.source import Source
from orchestration.session.open import open_scenario
from orchestration.session.read import load, read
from orchestration.session.run import whole
from plant.time_scales import gmst, parse_epoch

from ...vendors import wrapper
from ...vendors.wrapper import Port, Vendor

pytestmark = [pytest.mark.compile, pytest.mark.fly]
SCENARIO = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"
GIVEN = "R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w"
TURNS = "its attitude turns at its rate"
MOVES = "its position moves at its velocity"
FALLS = "its acceleration is gravity's"
FIELD = "its field is the Earth's"
WHEEL = "its wheel's momentum follows the torque commanded"
MOMENTUM = "its momentum changes by the torques on it"


@pytest.fixture(scope="module")
def run() -> Signals:
    """What our plant was given and gave in V.B."""
    source = read(SCENARIO).with_entry(("record",), {"signals": ["plant.*"]})
    opened = open_scenario(load(source))
    result = whole(load(source))
    starts = {start.element: start.value for start in opened.plan.starts["plant"]}
    of = signals(result, "plant")
    given = {
        "dipole_cmd": of.values["dipole"],
        "wheel_torque_cmd": of.values["wheel_torque"],
    }
    return Signals(
        of.time, {n: v for n, v in of.values.items() if n in GIVEN} | given, told(opened.plan.models["plant"], starts)
    )


def trials(of: Signals) -> dict[str, Trial]:
    return {one.name: one for one in plant(of)}


def changed(run: Signals, **values) -> Signals:
    return replace(run, values={**run.values, **values})


def test_our_plant_keeps_all(run):
    assert {name: one.status for name, one in trials(run).items()} == dict.fromkeys(trials(run), "met")
    assert len(trials(run)) == 9


def _along(matrices, vectors):
    return np.einsum("nij,nj->ni", matrices, vectors)


def _earth_axes(run: Signals) -> np.ndarray:
    angles = gmst(parse_epoch(str(run.told["epoch"]))) + 7.2921158553e-5 * run.time
    return Rotation.from_rotvec(angles[:, None] * [0.0, 0.0, 1.0]).as_matrix().transpose(0, 2, 1)


def _orbital(run: Signals) -> np.ndarray:
    r, v = run.values["r_N"], run.values["v_N"]
    return np.cross(r, v) / (r * r).sum(axis=1, keepdims=True)


AXES = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
PLANTED: dict[str, tuple[Callable[[Signals], dict], str, str]] = {
    "rate in deg/s": (lambda x: {"omega_B": np.degrees(x.values["omega_B"])}, TURNS, "omega_B is in deg/s"),
    "rate along N": (lambda x: {"omega_B": _along(x.values["R_NB"], x.values["omega_B"])}, TURNS, "omega_B is along N"),
    "rate to LVLH": (
        lambda x: {"omega_B": x.values["omega_B"] - _along(x.values["R_NB"].transpose(0, 2, 1), _orbital(x))},
        TURNS,
        "relative to LVLH",
    ),
    "other axes": (lambda x: {"omega_B": x.values["omega_B"] @ AXES.T}, TURNS, "other axes or signs: -y +x +z"),
    "N to B": (lambda x: {"R_NB": x.values["R_NB"].transpose(0, 2, 1)}, TURNS, "R_NB is from N to B"),
    "velocity in km/s": (lambda x: {"v_N": 1e-3 * x.values["v_N"]}, MOVES, "v_N is in km/s"),
    "velocity to the Earth": (
        lambda x: {"v_N": x.values["v_N"] - np.cross([0.0, 0.0, 7.292115e-5], x.values["r_N"])},
        MOVES,
        "relative to the turning Earth",
    ),
    "orbit along the Earth's axes": (
        lambda x: {
            "r_N": (r := _along(_earth_axes(x), x.values["r_N"])),
            "v_N": _along(_earth_axes(x), x.values["v_N"]) - np.cross([0.0, 0.0, 7.2921158553e-5], r),
        },
        FALLS,
        "turning axes of the Earth",
    ),
    "orbit in km": (lambda x: {n: 1e-3 * x.values[n] for n in ("r_N", "v_N")}, FALLS, "r_N is in km"),
    "field in nT": (lambda x: {"b_B": 1e9 * x.values["b_B"]}, FIELD, "b_B is in nT"),
    "field along N": (lambda x: {"b_B": _along(x.values["R_NB"], x.values["b_B"])}, FIELD, "b_B is along N"),
    "field along the Earth's axes": (
        lambda x: {"b_B": _along(_earth_axes(x) @ x.values["R_NB"], x.values["b_B"])},
        FIELD,
        "along the axes of the Earth",
    ),
    "field turned wrongly": (
        lambda x: {"b_B": _along(x.values["R_NB"] @ x.values["R_NB"], x.values["b_B"])},
        FIELD,
        "turned by R_NB the wrong way round",
    ),
    "wheel of opposite sign": (
        lambda x: {"wheel_torque_cmd": -x.values["wheel_torque_cmd"]},
        WHEEL,
        "times -1: the opposite sign",
    ),
    "momentum of opposite sign": (
        lambda x: {"h_w": -x.values["h_w"], "wheel_torque_cmd": -x.values["wheel_torque_cmd"]},
        MOMENTUM,
        "the wheel's momentum acts on the body times -1: the opposite sign",
    ),
    "rods of opposite sign": (
        lambda x: {"dipole_cmd": -x.values["dipole_cmd"]},
        MOMENTUM,
        "the dipole of the rods acts on the body times -1: the opposite sign",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_what_is_planted_in_a_plant_is_told_and_nothing_else(run, name):
    change, trial, words = PLANTED[name]
    found = trials(changed(run, **change(run)))
    assert found[trial].status == "failed"
    assert words in found[trial].text
    others = [one.text for one in found.values() if one.status == "failed" and one.name != trial]
    said = [text for text in others if "(leaves" in text and "place of b_B" not in text]
    assert not said  # no second cause is stated


def test_another_inertia_is_told_with_its_size(run):
    """What a run with one inertia keeps is held against another one that is told."""
    for factors, words in (((1.25, 1.25, 1.25), "0.8 times J_B"), ((1.0, 1.25, 1.0), "J_B[2,2] is 0.0608, told 0.076")):
        J = run.told["J_B"] * np.diag(factors)
        one = trials(replace(run, told={**run.told, "J_B": J}))[MOMENTUM]
        assert one.status == "failed"
        assert words in one.text


@pytest.mark.parametrize(
    ("epoch", "words"),
    [("2009-08-10T03:00:00Z", "-3 h"), ("2009-08-30T00:00:00Z", "-20 days")],
)
def test_a_field_of_another_epoch_is_told_by_the_earths_angle(run, epoch, words):
    one = trials(replace(run, told={**run.told, "epoch": epoch}))[FIELD]
    assert one.status == "failed"
    assert words in one.text


@pytest.mark.parametrize(
    ("turned", "degree", "words"), [(True, 13, "taken as those of N at t = 0"), (False, 1, "dipole")]
)
def test_a_field_by_the_axes_of_N_and_a_dipole_are_told_as_such(run, turned, degree, words):
    earth = EarthField(str(run.told["epoch"]))
    rows = np.arange(0, len(run.time), 50)
    angle = (earth.zero_longitude,) if turned else ()
    B = earth.at(run.time[rows], run.values["r_N"][rows], *angle, degree=degree)
    every = np.stack([np.interp(run.time, run.time[rows], B[:, i]) for i in range(3)], axis=1)
    one = trials(changed(run, b_B=_along(run.values["R_NB"].transpose(0, 2, 1), every)))[FIELD]
    assert one.status == "failed"
    assert words in one.text


def test_a_difference_without_a_known_cause_is_told_as_a_symptom(run):
    wobble = 1.0 + 0.4 * np.sin(run.time)[:, None] * [1.0, -0.5, 0.3]
    for name, trial in (("omega_B", TURNS), ("b_B", FIELD), ("v_N", MOVES)):
        one = trials(changed(run, **{name: run.values[name] * wobble}))[trial]
        assert one.status == "failed"
        assert "(leaves" not in one.text


# ---------------------------------------------------------------- the command, on FMUs of other teams


def team(block: str, path: Path, change: Callable[[Vendor], None]) -> Path:
    """Another team's FMU: our block under our names, with what differs built in."""
    source = read(SCENARIO)
    opened = open_scenario(load(source))
    model = opened.plan.models[block]
    ports = []
    for variable in model.of("input", "output"):
        fed = {
            e.variable
            for link in opened.plan.wiring.links
            for n in link.target
            if n.block == block
            for e in [n.element]
        }
        if variable.type != "real" or (variable.causality == "input" and variable.name not in fed):
            continue
        if block == "plant" and variable.causality == "output" and variable.name not in GIVEN:
            continue
        names = [variable.label(i).replace("][", ",") for i in range(variable.size)]
        start = [float(model.starts.get(e, 0.0) or 0.0) for e in variable.elements]
        unit = str(variable.unit) if variable.unit is not None else None
        if variable.size <= 9:
            ports.append(
                Port(
                    variable.name,
                    variable.causality,
                    names,
                    unit,
                    "",
                    np.eye(variable.size),
                    np.zeros(variable.size),
                    start=start,
                )
            )
    vendor = Vendor(block, ports, direct=block != "plant")
    change(vendor)
    starts = [(s.element, s.value) for s in opened.plan.starts[block] if not isinstance(s.value, str)]
    return wrapper.pack(path, vendor, opened.fmus[block], starts)


def accepted(block: str, path: Path, source: Source | None = None) -> dict[str, Trial]:
    fitted = check(path, block)[1]
    assert fitted is not None
    mapping = path.with_suffix(".yaml")
    mapping.write_text(suggest(fitted), "utf-8")
    made = accept(path, block, mapping, source or read(SCENARIO), block)
    return {one.name: one for one in made.requirements}


def _scaled(port: str, by: float | np.ndarray) -> Callable[[Vendor], None]:
    def change(vendor: Vendor) -> None:
        vendor.port(port).A = by * vendor.port(port).A if isinstance(by, float) else by @ vendor.port(port).A

    return change


def _heavier(vendor: Vendor) -> None:
    vendor.changed.update({("J_B", i): 1.25 for i in range(9)})


TEAMS: dict[str, tuple[Callable[[Vendor], None], str, str]] = {
    "inertia": (_heavier, MOMENTUM, "its inertia is 1.25 times J_B"),
    "velocity in km/s": (_scaled("v_N", 1e-3), MOVES, "v_N is in km/s"),
    "field along other axes": (_scaled("b_B", AXES.T), FIELD, "b_B has other axes or signs: +y -x +z"),
    "torque of the wheel on the body": (_scaled("wheel_torque_cmd", -1.0), WHEEL, "times -1: the opposite sign"),
    "epoch": (lambda vendor: None, FIELD, "-20 days"),
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", TEAMS)
def test_accept_tells_of_a_vendors_plant_what_is_planted(name, tmp_path):
    change, trial, words = TEAMS[name]
    source = read(SCENARIO)
    if name == "epoch":  # theirs has that of its start, and no parameter for it
        source = source.with_entry(("shared", "epoch"), "2009-08-30T00:00:00Z")
    found = accepted("plant", team("plant", tmp_path / "plant.fmu", change), source)
    assert found[trial].status == "failed", found
    assert words in found[trial].text
    others = {n: found[n] for n in (TURNS, MOVES, FALLS, FIELD, WHEEL, MOMENTUM) if n != trial}
    said = [one.text for one in others.values() if one.status == "failed" and "(leaves" in one.text]
    assert all("place of b_B" in text for text in said), said


def test_accept_tells_that_a_controllers_torque_turns_the_body_on(tmp_path):
    def opposite(vendor: Vendor) -> None:
        vendor.port("tau_cmd_B").A = -vendor.port("tau_cmd_B").A

    found = accepted("controller", team("controller", tmp_path / "controller.fmu", opposite))
    for axis in "xyz":
        one = found[f"it settles after a step about {axis}"]
        assert one.status == "failed"
        assert "turns the body on, not back" in one.text


def test_accept_shows_a_right_controllers_steps_beside_ours(tmp_path):
    found = accepted("controller", team("controller", tmp_path / "controller.fmu", lambda vendor: None))
    for axis in "xyz":
        one = found[f"it settles after a step about {axis}"]
        assert one.status == "met"
        theirs, ours = one.text.split("; ours ")
        assert theirs == ours


@pytest.mark.thorough
def test_a_controller_that_reads_what_a_plant_gives_is_not_judged_as_one():
    path = SCENARIO.with_name("flight_pyramid.yaml")
    fmu = open_scenario(load(read(path))).fmus["controller"].path
    made = accept(Path(fmu), "controller_wheels", None, read(path), "controller")
    assert made.passed
    assert not made.alone
    assert {one.name: one.status for one in made.trials}["a saved state is restored whole"] == "met"


# ---------------------------------------------------------------- an estimator


@pytest.fixture(scope="module")
def estimated() -> tuple[Signals, Signals]:
    """What our estimator was given and gave in the first quarter of an hour of a tumble, and the truth."""
    source = read(SCENARIO.with_name("flight_estimated.yaml")).with_entry(("duration",), "900 s")
    source = source.without([("expect",), ("figures",)])
    source = source.with_entry(("record",), {"signals": ["estimator.*", "sensors.*", "plant.R_NB"]})
    opened = open_scenario(load(source))
    result = whole(load(source))
    starts = {start.element: start.value for start in opened.plan.starts["plant"]}
    parts = []
    for block in ("estimator", "plant"):
        of = signals(result, block)
        parts.append(Signals(of.time[::5], {n: v[::5] for n, v in of.values.items()}))
    measured = {n: np.asarray(result[f"sensors.{n}"], float)[::5] for n in ("b_B_measured", "r_N_measured")}
    return changed(parts[0], **measured), replace(parts[1], told=told(opened.plan.models["plant"], starts))


def test_our_estimator_keeps_all(estimated):
    assert [one.status for one in estimate(*estimated)] == ["met"] * 3


def test_what_is_planted_in_an_estimator_is_told(estimated):
    of, truth = estimated
    R = of.values["R_NB"]
    off = Rotation.from_euler("x", 8.0, degrees=True).as_matrix()
    planted = (
        ({"R_NB": R.transpose(0, 2, 1)}, 0, "R_NB is from N to B (transposed)"),
        ({"omega_B": np.degrees(of.values["omega_B"])}, 0, "omega_B is in deg/s"),
        ({"R_NB": R @ off}, 2, "within the bound that it states at 0 %"),
    )
    for change, trial, words in planted:
        found = {one.name: one for one in estimate(changed(of, **change), truth)}
        assert found[ESTIMATES[trial]].status == "failed"
        assert words in found[ESTIMATES[trial]].text
