"""docs/evidence/optimum.md and docs/evidence/optimum.csv: that they agree, and that the lines can be."""

import pytest
from click.testing import CliRunner

from evidence.__main__ import main
from evidence.optimum import page
from evidence.optimum.kept import FILE, load, others, save
from evidence.paper import ROOT
from orchestration import InputError

FOLDER = ROOT / "docs" / "evidence"
LINES = load(FOLDER / FILE)
TEXT = (FOLDER / "optimum.md").read_text("utf-8")


def test_the_page_is_made_from_the_file():
    assert page.text(*page.least(LINES, others(FOLDER))) == TEXT


def test_of_two_searches_the_lesser_time_counts_tumble_by_tumble():
    first, second, third = LINES[:3]
    times = {first.run: first.best_s - 1.0, second.run: second.best_s + 1.0}
    lines, number = page.least([first, second, third], times)
    assert number == 1
    assert [line.best_s for line in lines] == [first.best_s - 1.0, second.best_s, third.best_s]


def test_the_times_of_another_search_are_not_below_the_momentum_bound():
    bounds = {line.run: line.bound_s for line in LINES}
    assert all(time > bounds[run] for run, time in others(FOLDER).items())


def test_no_time_found_is_below_its_momentum_bound_or_later_than_the_flight():
    for line in LINES:
        assert not line.best_s < line.bound_s
        assert line.best_s <= 1.1 * line.flown_s
        assert line.check_angle_deg < 5.0
        assert line.check_rate_rad_s < 1e-3


def test_a_file_is_read_as_it_was_written(tmp_path):
    save(tmp_path / FILE, LINES[::-1])
    assert (tmp_path / FILE).read_bytes() == (FOLDER / FILE).read_bytes()


def test_a_file_of_another_form_is_refused(tmp_path):
    (tmp_path / FILE).write_text("run,best\n1,2\n", "utf-8")
    with pytest.raises(
        InputError, match="expected a column 'initial_rate_deg_s', found none; remedy: python -m evidence"
    ):
        load(tmp_path / FILE)


def test_without_casadi_the_command_says_what_to_install(monkeypatch):
    monkeypatch.setattr("evidence.__main__.find_spec", lambda name: None)
    found = CliRunner().invoke(main, ["optimum"])
    assert found.exit_code == 2
    assert "remedy: pip install casadi" in found.stderr
