"""Two reviews or two runs side by side, and their pages."""

import json

import pytest

from design.review import compare, page
from design.review.content import APART, Curves, Review, Section, Table, load
from orchestration import InputError, run
from orchestration.session.read import read
from tests.commands import orchestrate


def _review(name, settled, failure="wheel stuck"):
    tables = [
        Table("Time to settle", ["until", "median, s", "worst, s"], [["5 deg", settled, "900"], ["1 deg", "–", "–"]]),
        Table("Single failures", ["failure", "rms, deg"], [["none", "1"], [failure, "3"]]),
        Table("Slews", ["slew", "about", "after, s"], [["10 deg", "x", "18"], ["10 deg", "y", settled]]),
    ]
    curves = Curves("Settled", [0.0, 1.0], "time, min", "share", {"5 deg": [0.0, 1.0]})
    return Review(
        name, f"{name} <b>", {"seed": "1"}, [Section("Tumbles", tables, [curves], ["same", f"of {name}"])], ["met"]
    )


def test_cells_that_differ_have_both_values():
    found = compare.compared(_review("a", "300"), _review("b", "400", "gyro frozen"), ("a", "b"))
    settle, failures, slews = found.sections[0].tables
    assert settle.rows == [["5 deg", f"300{APART}400", "900"], ["1 deg", "–", "–"]]
    assert failures.rows[1:] == [["wheel stuck", f"3{APART}–"], ["gyro frozen", f"–{APART}3"]]
    assert slews.rows[1] == ["10 deg", "y", f"300{APART}400"]  # two cells tell the rows apart
    assert found.sections[0].notes == ["same", "a: of a", "b: of b"]
    assert list(found.sections[0].figures[0].y) == ["5 deg, A", "5 deg, B"]
    assert found.description.startswith("A: a. B: b. 4 values differ")


def test_the_same_review_twice_has_no_difference():
    found = compare.compared(_review("a", "300"), _review("a", "300"), ("a", "b"))
    assert not any(APART in cell for table in found.sections[0].tables for row in table.rows for cell in row)


def test_a_page_marks_differences_and_escapes_what_it_is_given(tmp_path):
    text = page.page(compare.compared(_review("<i>", "300"), _review("b", "400"), ("<i>", "b")))
    assert f'<span class="off">300{APART}400</span>' in text
    assert "<i>" not in text.partition("<body>")[2]
    assert '<span class="good">met</span>' not in text


def test_a_review_is_read_back_as_it_was_saved(tmp_path):
    saved = _review("a", "300")
    saved.save(tmp_path)
    assert load(tmp_path) == saved
    assert (tmp_path / "time_to_settle.csv").read_text("utf-8").splitlines()[1] == "5 deg,300,900"
    (tmp_path / "review.json").write_text("{}", "utf-8")
    with pytest.raises(InputError, match=r"review\.json: expected what a review wrote"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("name",), 3),
        (("facts",), ["seed"]),
        (("verdicts",), 0.5),
        (("sections", 0, "heading"), True),
        (("sections", 0, "tables", 0, "rows"), [1]),
        (("sections", 0, "tables", 0, "rows", 0, 1), 300.0),
        (("sections", 0, "tables", 0, "rows", 0), ["5 deg"]),
        (("sections", 0, "figures", 0, "y", "5 deg"), []),
        (("sections", 0, "figures", 0, "x", 0), "none"),
        (("sections", 0, "motion"), {}),
    ],
)
def test_a_damaged_review_is_told(tmp_path, path, value):
    _review("a", "300").save(tmp_path)
    data = json.loads((tmp_path / "review.json").read_text("utf-8"))
    entry = data
    for key in path[:-1]:
        entry = entry[key]
    entry[path[-1]] = value
    (tmp_path / "review.json").write_text(json.dumps(data), "utf-8")
    with pytest.raises(InputError, match=r"review\.json: expected what a review wrote, found ."):
        compare.of_folder(tmp_path)


def test_two_runs_are_compared_by_start_values_and_expectations(satellite, tmp_path):
    folders = []
    soon = {"name": "wheel within 1 N m s", "signal": "plant.h_w", "always": {"within": "1 N.m.s"}}
    flown = read(satellite).with_entry(("expect",), [soon])
    for dipole in ("0.3 A.m2", "0.2 A.m2"):
        folders.append(tmp_path / dipole[:3])
        run(flown, {"dipole_max": dipole}, duration="4 s", out=folders[-1])
    strong, weak = map(compare.of_folder, folders)
    found = compare.compared(strong, weak, ("strong", "weak"))
    starts = {row[0]: row[1] for row in found.sections[0].tables[0].rows}
    assert starts["plant.dipole_max"] == f"0.3{APART}0.2"
    assert APART not in starts["plant.J_B"]
    assert [row[:2] for row in found.sections[1].tables[0].rows] == [[soon["name"], "met"]]
    assert found.sections[1].figures
    with pytest.raises(InputError, match="expected the folder of a review or of a run"):
        compare.of_folder(tmp_path)


def test_one_folder_is_shown_and_two_are_compared_by_the_command(satellite, tmp_path):
    """That of a run, and that of a review, which stays where it is."""
    run(read(satellite), duration="4 s", out=tmp_path / "flown")
    saved = _review("a", "300")
    saved.save(tmp_path / "a-review")
    one = orchestrate("review", tmp_path / "flown", "--out", tmp_path / "shown")
    assert one.exit_code == 0, one.stderr
    assert "Start values" in (tmp_path / "shown" / "review.html").read_text("utf-8")
    assert (tmp_path / "shown" / "start_values.csv").is_file()
    two = orchestrate("review", tmp_path / "a-review", tmp_path / "flown", "--out", tmp_path / "two")
    assert two.exit_code == 0, two.stderr
    assert "A: a. B: flown." in (tmp_path / "two" / "review.html").read_text("utf-8")
    assert load(tmp_path / "a-review") == saved


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("manifest.json", "[" * 100_000),
        ("manifest.json", '{"scenario": {"name": "a"}}'),
        ("expectations.json", '{"expectations": [{}]}'),
        ("signals.csv", "time,a\n1,x\n"),
        ("signals.csv", ""),
    ],
)
def test_a_damaged_folder_of_a_run_is_told_by_its_files(tmp_path, name, text):
    good = {
        "manifest.json": '{"scenario": {"name": "a"}, "parameters": {}, "simulated_time": 1.0, "outcome": "met"}',
        "expectations.json": '{"expectations": [{"name": "b", "status": "met", "signal": "a"}]}',
        "signals.csv": "time,a\n1,2\n",
    }
    for place, content in good.items():
        (tmp_path / place).write_text(content)
    assert compare.of_folder(tmp_path).name == "a"
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=r"manifest\.json, expectations\.json or signals\.csv is damaged"):
        compare.of_folder(tmp_path)
