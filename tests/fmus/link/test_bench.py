"""When the bench takes what a device gives for what is expected."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.link import bench

NAN = float("nan")


@pytest.mark.parametrize(
    ("given", "right"),
    [
        ([1.0, -2.0, 0.5], True),
        ([1.0, -2.0 + 1e-6, 0.5], True),  # a millionth of the largest value, 2, is twice as much
        ([1.0, -2.0 + 1e-5, 0.5], False),
        ([1.0, NAN, 0.5], False),
        ([], False),
    ],
)
def test_outputs_are_as_expected_within_a_share_of_their_largest_value(monkeypatch, capsys, given, right):
    expected = [1.0, -2.0, 0.5]
    rows = [(0.1 * i, {"y": x}, {"y": expected[i]}) for i, x in enumerate(given)]
    monkeypatch.setattr(bench, "play", lambda *_: iter(rows))
    assert bench.compare(None, Path(), None) is right
    assert ("all outputs are as expected" in capsys.readouterr().out) is right


def test_the_largest_difference_is_told_with_its_first_time(monkeypatch, capsys):
    rows = [(t, {"y": 1.0 + off}, {"y": 1.0}) for t, off in ((0.0, 0.0), (0.1, 0.25), (0.2, 0.25), (0.3, 0.125))]
    monkeypatch.setattr(bench, "play", lambda *_: iter(rows))
    assert not bench.compare(None, Path(), None)
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("DIFFER"))
    assert line.split() == ["DIFFER", "y", "0.25", "0.25", "0.1", "s"]
