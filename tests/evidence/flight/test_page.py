"""docs/evidence/flight.md and docs/evidence/flight.csv: that they agree, and that the blocks as they are fly what is
written there."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evidence.flight import cases, conditions, kept, page
from evidence.paper import ORBIT, ROOT
from orchestration import InputError
from orchestration.campaign.flying.job import Pilot

DOCS = ROOT / "docs" / "evidence"


def test_the_page_is_that_of_the_kept_flights():
    assert (DOCS / "flight.md").read_text("utf-8") == page.text(kept.load(DOCS / "flight.csv"))


def test_no_tumble_settles_sooner_than_its_bound():
    flown = kept.load(DOCS / "flight.csv")
    for group in ("nominal", "errors"):
        least = flown.least(group)
        # Times have no decimals, and older ones are a second apart.
        assert (flown.times(group) > np.nan_to_num(least) - 1.0 / ORBIT).all()


@pytest.mark.parametrize("which", ["vb", "vc"])
def test_the_blocks_as_they_are_fly_what_is_written(which):
    """The last node of each: a page of older blocks is found out. Remedy: make flight."""
    row = kept.load(DOCS / "flight.csv").of(which)[-1]
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
    assert conditions.became(flights(stays, stays, never), "x") == "0"
    assert conditions.became(flights(stays, ("5000", "", "55"), never, back), "x") == "2 of 3, up to 55°"
    assert conditions.became(flights(never), "x") == "0"


def test_a_file_of_the_older_form_is_refused_with_its_remedy(tmp_path):
    (tmp_path / "flight.csv").write_text("group,seed\nnominal,100000\n")
    with pytest.raises(InputError, match="flight.csv: expected a column 'run', found none; remedy: make flight"):
        kept.load(tmp_path / "flight.csv")
