"""The first table of a review repeats cells of the others, and none that is not there."""

from design.review.content import Section, Table
from design.review.glance import glance


def test_the_first_table_has_what_the_sections_say():
    times = [["error below 5 deg", "9 of 10", "11", "12", "–"], ["error below 3.5 deg", "7 of 10", "21", "–", "–"]]
    settle = Table("Time to settle", ["until", "settled", "median, s", "90%, s", "worst, s"], times)
    columns = ["error", "ensemble, deg", "95% of tumbles, deg", "worst tumble, deg"]
    errors = Table("Errors of pointing", columns, [["absolute", "1.5", "2.0", "2.5"]])
    slews = Table("Slews", ["slew", "about", "below 1 deg after, s"], [["90 deg", "x", "61"], ["90 deg", "y", "62"]])
    failed = Table(
        "Single failures", ["failure", "remark"], [["none", ""], ["rod 1 dead", ""], ["gyro frozen", "lost"]]
    )
    found = glance(
        [Section("a", [settle, errors]), Section("b", [slews, failed])], ["met", "not met", "met"], 3.5, "95%"
    )
    assert dict(found.tables[0].rows) == {
        "tumbles settled below the goal": "7 of 10 below 3.5 deg; median 21 s, 90% – s, worst – s",
        "pointing error": "at most 1.5 deg in 95% of the holds; after tumbles 2.0 deg in 95%, 2.5 deg in all",
        "slews of 90 deg on a known attitude, below 1 deg after": "x: 61 s, y: 62 s",
        "single failures": "2 flown; gyro frozen (lost)",
        "requirements": "2 met, 1 not met",
    }


def test_without_tables_nothing_is_claimed():
    rows = dict(glance([Section("a")], [], 5.0, "95%").tables[0].rows)
    assert rows["pointing error"].startswith("at most – deg")
    assert rows["requirements"] == "none given"
    assert "single failures" not in rows
