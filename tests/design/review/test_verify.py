"""Requirements: what is asked of a file, and the verdicts, against exact binomial bounds of SciPy.

Shows RV-1.
"""

import math

import numpy as np
import pytest
from scipy.stats import beta

from design.review import tumbles, verify
from design.review.options import Options, requirements
from orchestration import InputError

TEXT = """
requirements:
  - {id: R1, text: settles, metric: settling_time, below: 0.5 h, probability: 0.9}
  - {id: R2, text: points, metric: absolute_error, below: 10 deg, probability: 0.9}
  - {id: R3, text: planted, metric: jitter, below: 1 arcsec}
  - {id: R4, text: wheel, metric: momentum_margin, above: 3}
  - {id: R5, text: tracks, metric: station_error, below: 1 deg}
power: {rod: 200 mW, efficiency: 0.7}
"""


class Rows:
    """40 runs: settled after 0 to 1950 s, one never; errors of 1 to 8.8 deg."""

    index = np.arange(40)
    manifest = {"metrics": [{"name": name} for name in ("settling_time", "absolute_error")]}  # noqa: RUF012

    def numbers(self, name):
        if name == "settling_time":
            return np.where(self.index == 7, np.inf, 50.0 * self.index)
        return 1.0 + 0.2 * self.index


def _asked(tmp_path, text=TEXT):
    (tmp_path / "asked.yaml").write_text(text, "utf-8")
    return requirements(tmp_path / "asked.yaml")


def test_verdicts_have_margin_worst_case_and_reason(tmp_path):
    asked, power = _asked(tmp_path)
    assert power == {"rod": pytest.approx(0.2), "efficiency": 0.7}
    section, said = verify.section(
        Options(requirements=asked, seed=3), Rows(), {"momentum_margin": (6.9, "")}, math.inf
    )
    rows = {row[0]: dict(zip(verify.COLUMNS, row, strict=True)) for row in section.tables[0].rows}
    assert said == ["undecided", "met", "not verifiable", "met", "not verifiable"]
    low = beta.ppf(0.05, 35, 6)  # 35 of 40 runs settle within 1800 s: the lower bound at 95 %
    assert f"at least {int(low * 1e3) / 1e3:.3f}" in rows["R1"]["why"]
    assert "--replay 7" in rows["R1"]["worst case"]  # that never settles
    assert rows["R1"]["runs, seed"] == "40, seed 3"
    assert float(rows["R2"]["margin"].split()[0]) == pytest.approx(10.0 - 8.0, rel=0.01)  # deg: 90 % are below 8
    assert rows["R3"]["why"].startswith("there is no metric 'jitter'")
    assert section.notes[1].startswith("Metrics of a review: settling_time, ")
    assert rows["R4"]["margin"].startswith("3.9")
    assert "no value of station_error" in rows["R5"]["why"]


def test_a_tumble_that_comes_below_the_goal_in_the_last_sixth_of_its_flight_has_not_settled(tmp_path):
    asked, _ = _asked(tmp_path, "requirements: [{id: R, metric: settling_time, below: 0.5 h, probability: 0.9}]")
    assert tumbles.counted(Rows(), asked[0], 1400.0)[:2] == (28, 40)  # 0 to 1400 s but for run 7
    assert tumbles.counted(Rows(), asked[0], math.inf)[:2] == (35, 40)
    assert tumbles.worst(Rows(), asked[0], 1400.0) == 7


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("{id: R, metric: settling_time}", "expected exactly one of below and above"),
        ("{id: R, metric: settling_time, below: 3 kg}", "kg"),
        ("{id: R, metric: settling_time, below: 3 s, probability: 2}", "above 0 and below 1"),
        ("{id: R, metric: settling_time, under: 3 s}", "expected one of above, below"),
        ("{metric: settling_time, below: 3 s}", "expected id, text, metric"),
        ("{id: , metric: settling_time, below: 3 s}", "expected id, text, metric"),
        ("{id: R, metric: absolute_error, below: 15}", "at most 180 deg, which all errors are, found 15 rad"),
        ("{id: R, metric: settling_time, below: -3 s}", "expected a limit above 0, found -3 s"),
        ("{id: R, metric: slew_time, below: 3 s}\n  - {id: R, metric: slew_time, below: 4 s}", "R is taken"),
    ],
)
def test_a_wrong_requirement_is_told_with_its_line(tmp_path, entry, expected):
    with pytest.raises(InputError, match=rf"asked\.yaml:\d+.*{expected}"):
        _asked(tmp_path, f"requirements:\n  - {entry}\n")


@pytest.mark.parametrize(
    ("power", "expected"),
    [
        ("power: 3", "expected rod, wheel or efficiency"),
        ("power: {rod: -1 W}", "expected a number above 0, found -1 W"),
        ("power: {efficiency: 70}", "expected a number above 0 and at most 1, found 70"),
        ("powr: {rod: 1 W}", "expected requirements or power"),
    ],
)
def test_wrong_data_of_power_are_told_with_their_line(tmp_path, power, expected):
    with pytest.raises(InputError, match=rf"asked\.yaml:2.*{expected}"):
        _asked(tmp_path, f"requirements: []\n{power}")


def test_data_of_power_need_no_requirements_and_a_number_is_shown_with_its_unit(tmp_path):
    assert _asked(tmp_path, "power: {rod: 0.2 W}") == ((), {"rod": pytest.approx(0.2)})
    (asked,), _ = _asked(tmp_path, "requirements: [{id: R, metric: slew_time, below: 30}]")
    assert asked.limit == "below 30 s"


def test_the_worst_of_single_flights_has_the_command_that_flies_it(tmp_path):
    asked, _ = _asked(tmp_path, "requirements: [{id: R, metric: slew_time, below: 30 s}]")
    section, said = verify.section(Options(requirements=asked), Rows(), {"slew_time": (90.0, "slew-180-x")}, math.inf)
    assert (said, section.tables[0].rows[0][7]) == (["not met"], "orchestrate flights/slew-180-x.yaml")
