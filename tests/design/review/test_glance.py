"""The first table of a review repeats cells of the others, and none that is not there."""

from design.review.content import Section, Table
from design.review.glance import glance


def test_the_first_table_has_what_the_sections_say():
    times = [["error below 5 deg", "9 of 10", "11", "12", "–"], ["error below 3.5 deg", "7 of 10", "21", "–", "–"]]
    settle = Table("Time to settle", ["until", "settled", "median, s", "90%, s", "worst, s"], times)
    errors = Table("Errors of pointing", ["error", "mixed, deg", "worst tumble, deg"], [["absolute", "1.5", "2.5"]])
    slews = Table("Slews", ["slew", "about", "below 1 deg after, s"], [["90 deg", "x", "61"], ["90 deg", "y", "62"]])
    failed = Table(
        "Single failures", ["failure", "remark"], [["none", ""], ["rod 1 dead", ""], ["gyro frozen", "lost"]]
    )
    found = glance([Section("a", [settle, errors]), Section("b", [slews, failed])], ["met", "not met", "met"], 3.5)
    assert dict(found.tables[0].rows) == {
        "tumbles settled below 3.5 deg": "7 of 10; median 21 s, 90% – s, worst – s",
        "pointing error": "1.5 deg in the hold, 2.5 deg in the second orbit of the worst tumble",
        "slews of 90 deg, below 1 deg after": "x: 61 s, y: 62 s",
        "single failures": "2 flown; gyro frozen (lost)",
        "requirements": "2 met, 1 not met",
    }


def test_without_tables_nothing_is_claimed():
    rows = dict(glance([Section("a")], [], 5.0).tables[0].rows)
    assert rows["pointing error"].startswith("– deg")
    assert rows["requirements"] == "none given"
    assert "single failures" not in rows
