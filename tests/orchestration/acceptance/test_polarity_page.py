"""The table of wrong wirings: how many of each port, how many are detected, when first and last, and by what."""

from __future__ import annotations

from types import SimpleNamespace

from orchestration.acceptance.polarity.fly import Found
from orchestration.acceptance.polarity.page import table


def test_each_port_has_the_first_and_the_last_time_and_what_shows_most():
    ports = [SimpleNamespace(name=name, causality="input") for name in ("a.u", "b.u", "c.u")]
    found = [
        (0, Found("expectation", "settles", 7.0)),
        (0, Found("expectation", "settles", 2.5)),
        (0, Found("consistency", "rates agree", 4.0)),
        (0, None),
        (1, Found("refused", "b: out of range", 0.5)),
        (2, None),
    ]
    rows = [SimpleNamespace(port=ports[i], found=one) for i, one in found]
    assert table(SimpleNamespace(rows=rows)) == [
        ("a.u", "in", "4", "3", "2.5 s", "7 s", "settles"),
        ("b.u", "in", "1", "1", "0.5 s", "0.5 s", "refused by b"),
        ("c.u", "in", "1", "0", "", "", ""),
    ]
