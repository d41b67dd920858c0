"""docs/evidence/flight.md and docs/evidence/flight.csv: that they agree, and that the blocks as they are fly what is written there."""

import csv
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evidence.flight import cases, conditions, kept
from evidence.paper import ORBIT, ROOT
from orchestration import InputError
from orchestration.campaign.flying.job import Pilot

TEXT = (ROOT / "docs" / "evidence" / "flight.md").read_text("utf-8")
with (ROOT / "docs" / "evidence" / "flight.csv").open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))


def rows(group):
    return [row for row in ROWS if row["group"] == group]


def times(group, degrees=5):
    return np.sort([float(row[f"settled_{degrees}deg_s"] or "inf") / ORBIT for row in rows(group)])


def cells(start):
    """The cells of the first line of a table that begins so."""
    line = next(line for line in TEXT.splitlines() if line.startswith(f"| {start} |"))
    return [cell.strip() for cell in line.strip("| \n").split("|")]


def said(value):
    return f"{value:.3f}" if math.isfinite(value) else "not settled"


@pytest.mark.parametrize(
    ("group", "line"),
    [
        ("nominal", "**planned**, nominal"),
        ("errors", "**planned**, all errors"),
        ("nominal tuned", "law [8], tuned, nominal"),
        ("errors tuned", "law [8], tuned, all errors"),
        ("nominal paper", "the paper's scheme, nominal"),
        ("errors paper", "the paper's scheme, all errors"),
    ],
)
def test_the_table_says_what_the_cases_say(group, line):
    t, found = times(group), cells(line)
    assert int(found[1]) == len(t)
    assert found[2] == f"{100.0 * np.isfinite(t).mean():.4g}%"
    n = len(t)
    quantiles = [t[math.ceil(q * n) - 1] for q in (0.5, 0.9, 1.0)]
    assert found[3:6] == [said(q) for q in quantiles]
    assert found[8] == said(times(group, 1)[-1])


def test_the_page_says_how_many_tumbles_were_flown_none_of_them_sooner_than_its_bound():
    for group, name in (("nominal", "nominal"), ("errors", "all errors")):
        found = rows(group)
        assert len(found) >= 300
        assert len(found) == 1000 or f"{len(found)} ({name})" in TEXT
        for row in found:
            if row["settled_5deg_s"]:
                # Times have no decimals, and older ones are a second apart.
                assert float(row["settled_5deg_s"]) > float(row["momentum_bound_s"]) - 1.0


def test_every_failure_is_listed():
    for group, name in (("nominal", "nominal"), ("errors", "all errors")):
        for degrees in (5, 1):
            lines = [x for x in TEXT.splitlines() if x.startswith(f"- {name}, ") and f"not below {degrees}°: " in x]
            assert len(lines) == sum(not row[f"settled_{degrees}deg_s"] for row in rows(group))


@pytest.mark.parametrize("which", ["vb", "vc"])
def test_the_blocks_as_they_are_fly_what_is_written(which):
    """The last node of each: a page of older blocks is found out. Remedy: make flight."""
    row = rows(which)[-1]
    case = replace(cases.manoeuvre(which), duration=float(row["duration_s"])).case
    pilot = Pilot(case.job)
    flown = pilot.fly(35, case.job.design.points([35])[0])
    pilot.close()
    metric: dict[str, Any] = dict(zip((name for name, _ in case.job.columns), flown, strict=True))
    for degrees in (5, 1):
        time = max(metric[f"angle_{degrees}"], metric["rate"])
        assert time == pytest.approx(float(row[f"settled_{degrees}deg_s"] or "inf"), abs=2.0)
    assert math.degrees(metric["hold_rms"]) == pytest.approx(float(row["hold_rms_deg"]), rel=0.02)


def flights(*early_settled_largest):
    """Flights of a condition, by when they were settled first, for good, and the largest error later."""
    names = ("early_5deg_s", "settled_5deg_s", "later_max_deg")
    return kept.Flights(
        tuple(
            dict.fromkeys(kept.COLUMNS, "") | {"group": "x"} | dict(zip(names, f, strict=True))
            for f in early_settled_largest
        )
    )


def test_the_page_says_of_each_condition_what_became_of_those_that_were_settled():
    stays, never, back = ("400", "400", "0.1"), ("", "", "170"), ("400", "", "12.3")
    assert conditions.became(flights(stays, stays, never), "x") == "2, all stay"
    assert conditions.became(flights(stays, ("5000", "", "55"), never, back), "x") == "3, 2 lose it, up to 55°"
    assert conditions.became(flights(never), "x") == "0"


def test_a_file_of_the_older_form_is_refused_with_its_remedy(tmp_path):
    (tmp_path / "flight.csv").write_text("group,seed\nnominal,100000\n")
    with pytest.raises(InputError, match="flight.csv: expected a column 'run', found none; remedy: make flight"):
        kept.load(tmp_path / "flight.csv")
