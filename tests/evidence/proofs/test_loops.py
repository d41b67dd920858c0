"""Bounds of loops: a loop that no constant ends needs an entry, and an entry needs its loop.

Shows FC-2.
"""

from __future__ import annotations

import pytest

from evidence.proofs import loops
from evidence.proofs.coverage import FLIGHT
from evidence.proofs.loops import loops_of, rows
from orchestration import InputError


def test_each_loop_of_the_flight_code_counts_to_a_constant_or_has_a_bound():
    table = rows(FLIGHT)
    assert sum(sum(map(int, row[1:4])) for row in table) > 250


@pytest.mark.parametrize(
    ("text", "counted"),
    [
        ("for (int i = 0; i < N; ++i) {\n    x += i;\n}", True),
        ("for (size_t i = 0; i < COUNT(names) && good; ++i) {\n    use(i);\n}", True),
        ("for (int j = A + B; j <= N - 1; j += 3) {\n}", True),
        ("for (int i = 0; i < N; ++i) {\n    i -= 1;\n}", False),
        ("for (int i = 0; i < N; ++i) {\n    move(&i);\n}", False),
        ("for (int i = 0; i < n; ++i) {\n}", False),
        ("for (int i = 0; i < N || more; ++i) {\n}", False),
        ("for (int i = 0; i < N && good || more; ++i) {\n}", False),
        ("for (int i = 0; i < N && (good || more); ++i) {\n}", True),
        ("for (int i = 0; i < N; ++i) {\n    i >>= 1;\n}", False),
        ("for (int i = 0; i < N; ++i) {\n    i &= 1;\n}", False),
        ("for (int i = 0; i < N; --i) {\n}", False),
        ("while (x > 0) {\n    x -= 1;\n}", False),
        ("for (;;) {\n}", False),
    ],
)
def test_what_counts_to_a_constant(tmp_path, text, counted):
    path = tmp_path / "a.c"
    path.write_text(f'void f(void)\n{{\n    g("while (not a loop");\n{text}\n}}\n')
    (loop,) = loops_of(path)
    assert loop.counted == counted


def test_a_loop_without_a_bound_and_a_bound_without_a_loop_are_named(monkeypatch):
    known = loops.bounds()
    place = ("controller/planned/native/plan/renew.c", "for (;;)")
    monkeypatch.setattr(loops, "bounds", lambda: {k: n for k, n in known.items() if k != place})
    with pytest.raises(InputError, match=r"renew.c: for \(;;\): no constant bounds it"):
        rows(FLIGHT)
    monkeypatch.setattr(loops, "bounds", lambda: {**known, ("controller/a.c", "for (;;)"): 3})
    with pytest.raises(InputError, match=r"no loop is controller/a.c: for \(;;\)"):
        rows(FLIGHT)
