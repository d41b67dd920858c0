"""The period of an orbit, by which a scenario counts its times, follows the orbit wherever its values come from."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from click.testing import CliRunner

import orchestration
from orchestration.campaign.case import read_campaign
from orchestration.cli.main import main
from orchestration.scenario.source import Source
from orchestration.session.open import open_scenario
from orchestration.session.read import load

SCENARIOS = Path(__file__).parents[3] / "scenarios"
LOOP = """\
name: counted
step: 1 s
duration: 0.01 orbits
blocks:
  plant:
    fmu: plant
    start: {dipole_cmd: [0, 0, 0], wheel_torque_cmd: 0}
cycle: {name: orbits, period: 5792.4 s}
expect:
  - name: below
    signal: plant.h_w
    after: 0.005 orbits
    always: {below: 1}
shared: {orbit_radius: 6971 km}
"""


def kepler(radius):
    return 2.0 * math.pi * math.sqrt(radius**3 / 3.986004418e14)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "counted.yaml").write_text(LOOP)
    return tmp_path / "counted.yaml"


def of(path, overrides=None):
    plan = open_scenario(load(path, overrides)).plan
    return plan.scenario, plan.notes


@pytest.mark.parametrize(
    ("overrides", "radius"),
    [
        ({"altitude": "800 km"}, 7178137.0),
        ({"plant.altitude": "800 km"}, 7178137.0),
        ({"orbit_radius": "7500 km"}, 7.5e6),
        # From a point 7000 km away with 8 km/s across: vis-viva.
        (
            {
                "plant.orbit_start": "position_velocity",
                "plant.r_N0": [7e6, 0, 0],
                "plant.v_N0": [0, 5656.854, 5656.854],
            },
            1.0 / (2.0 / 7e6 - 64e6 / 3.986004418e14),
        ),
    ],
)
def test_times_counted_in_orbits_are_those_of_the_orbit_that_is_flown(path, overrides, radius):
    scenario, notes = of(path, overrides)
    assert scenario.cycle.period == pytest.approx(kepler(radius), rel=1e-6)
    assert scenario.duration == pytest.approx(0.01 * kepler(radius), rel=1e-6)
    assert scenario.expect[0].after == pytest.approx(0.005 * kepler(radius), rel=1e-6)
    (note,) = notes[:1]
    assert "cycle.period: orbits of plant last" in note
    assert "not 5792.4 s; times counted in orbits follow" in note


def test_a_rounded_period_of_the_file_stays(path):
    scenario, notes = of(path)
    assert scenario.cycle.period == 5792.4
    assert notes == []


def test_the_period_follows_a_file_that_is_extended_with_another_orbit(path, tmp_path):
    (tmp_path / "higher.yaml").write_text("extends: counted.yaml\nname: higher\nshared: {orbit_radius: 7500 km}\n")
    assert of(tmp_path / "higher.yaml")[0].duration == pytest.approx(0.01 * kepler(7.5e6), rel=1e-6)


def test_each_point_of_a_sweep_counts_its_own_orbits(path):
    points = orchestration.sweep(path, {"altitude": ["500 km", "900 km"]})
    assert [point.result.time[-1] for point in points] == [
        math.ceil(0.01 * kepler(6378137.0 + height)) for height in (500e3, 900e3)
    ]


def test_a_satellite_made_from_the_template_is_flown_higher_for_as_many_orbits(tmp_path):
    values = ["inertia={diagonal: [0.042, 0.042, 0.007]}", "dipole_max=0.3 A.m2", "wheel_torque_max=0.3 mN.m"]
    values += ["wheel_momentum_max=2 mN.m.s", "altitude=500 km", "inclination=97.4 deg", "body_width=10 cm"]
    values += ["body_length=34 cm", "body_axis=z"]
    options = [part for value in values for part in ("--set", value)]
    done = CliRunner().invoke(main, ["new", "satellite", str(tmp_path / "mine"), *options])
    assert done.exit_code == 0, done.output
    scenario, _ = of(tmp_path / "mine" / "tumble.yaml", {"altitude": "900 km"})
    assert scenario.duration == pytest.approx(3.0 * kepler(7278137.0), rel=1e-6)


CAMPAIGN = {
    "name": "c",
    "runs": 4,
    "vary": {"plant.h_w0": {"uniform": ["-1 mN.m.s", "1 mN.m.s"]}},
    "metrics": [{"name": "h", "signal": "plant.h_w", "after": "0.005 orbits", "statistic": "maximum"}],
}


def case_of(path, **entries):
    data = {**CAMPAIGN, "scenario": str(path), **entries}
    return read_campaign(Source(data, folder=path.parent))


def test_metrics_of_a_campaign_count_the_orbits_of_its_own_start_values(path):
    case = case_of(path, set={"altitude": "800 km"})
    assert case.campaign.metrics[0].after == pytest.approx(0.005 * kepler(7178137.0), rel=1e-6)


def test_a_campaign_whose_runs_have_orbits_of_their_own_says_by_which_times_are_counted(path):
    case = case_of(path, vary={"altitude": {"uniform": ["500 km", "900 km"]}})
    expected = "altitude changes how long plant takes; times are counted in the scenario's orbits, of 5792.4 s"
    assert expected in case.notes
    assert expected not in case_of(path).notes


@pytest.mark.parametrize("scenario", sorted(SCENARIOS.glob("*.yaml")), ids=lambda path: path.stem)
@pytest.mark.thorough
def test_shipped_scenarios_state_the_period_of_their_orbit(scenario):
    loaded = load(scenario)
    assert open_scenario(loaded).plan.scenario.cycle == loaded.cycle
