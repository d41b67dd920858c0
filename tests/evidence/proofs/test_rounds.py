"""Rounds of loops: what a loop that counts is checked for, and with Frama-C that a wrong bound is not proved.

Shows FC-2.
"""

from __future__ import annotations

import shutil
from dataclasses import replace

import pytest

from evidence.proofs import make, rounds
from evidence.proofs.analysis import Result
from evidence.proofs.rounds import counts, marked, proved, refuse_assumptions
from evidence.proofs.subjects import SUBJECTS
from orchestration import InputError


@pytest.mark.parametrize(
    ("head", "body", "term"),
    [
        ("for (int i = 0; i < n; ++i)", "{ x += i; }", "(n) - (0)"),
        ("for (int32_t k = first + 1; k <= bank->count; ++k)", "{ }", "(bank->count) - (first + 1) + 1"),
        ("for (int i = n - 1; i >= 0; --i)", "{ }", "(n - 1) - (0) + 1"),
        ("for (int i = 0; i < WHEELS(&law->p) && good; ++i)", "{ }", "(WHEELS(&law->p)) - (0)"),
        ("for (int i = 0; i < n; ++i)", "{ --i; }", ""),
        ("for (int i = 0; i < n; ++i)", "{ n = 9; }", ""),
        ("for (int i = 0; i < bank->count; ++i)", "{ ++bank->count; }", ""),
        ("for (int i = 0; i < bank->count; ++i)", "{ bank->count += 1; }", ""),
        ("for (int i = 0; i < n || more; ++i)", "{ }", ""),
        ("for (int i = 0; i < n && good || more; ++i)", "{ }", ""),
        ("for (int i = 0; i < n; ++i)", "{ i >>= 1; }", ""),
        ("for (int i = 0; i < a->n + 1; ++i)", "{ a->n += 1; }", ""),
        ("for (int i = 0; i < bank->count; ++i)", "{ bank->count <<= 1; }", ""),
        ("for (int i = 0; i < n; i += m)", "{ }", ""),
        ("for (;;)", "{ }", ""),
    ],
)
def test_how_often_a_loop_goes_round(head, body, term):
    assert counts(head, body) == term


def test_the_check_stands_in_the_line_of_its_loop_and_before_what_the_loop_says_of_itself():
    text = (
        "/* for (int i = 0; i < n; ++i) */\nvoid f(int n)\n{\n    for (int i = 0; i < n; ++i) {\n    }\n"
        "    //@ loop assigns i;\n    for (int j = 0; j < n; ++j) {\n    }\n}\n"
    )
    most = {"for (int i = 0; i < n; ++i)": 3, "for (int j = 0; j < n; ++j)": 4}
    new, heads = marked(text, most)
    lines = new.splitlines()
    assert heads == {4: "for (int i = 0; i < n; ++i)", 6: "for (int j = 0; j < n; ++j)"}
    assert "/*@ check (n) - (0) <= 3; */ for (int i" in lines[3]
    assert "/*@ check (n) - (0) <= 4; */ //@ loop assigns i;" in lines[5]
    assert len(lines) == len(text.splitlines())


def refused(tmp_path, good, bad, says):
    """Whether C is taken in the place of a block's, and other C is refused in these words."""
    path = tmp_path / "allocator" / "a.c"
    path.parent.mkdir()
    path.write_text(good)
    refuse_assumptions(tmp_path)
    path.write_text(bad)
    with pytest.raises(InputError, match=f"(?s)allocator/a.c: .*{says}"):
        refuse_assumptions(tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "//@ admit x < 2;",
        "/*@ admit\n x < 2; */",
        "/*@ axiomatic A { axiom a: 0 == 1; } */",
        "//@ assert \\false;",
        "again:\n    goto again;",
    ],
)
def test_c_that_asks_to_take_something_as_given_is_refused(tmp_path, text):
    good, bad = "/* No axiom. */\n//@ assert x > 1;\nint x;\n", f"void f(void)\n{{\n{text}\n}}\n"
    refused(tmp_path, good, bad, "expected a proof, not an assumption")


@pytest.mark.parametrize(
    "text",
    [
        "#if defined(__arm__)\nint y;\n#endif",
        "#if 0\n#elif __OPTIMIZE__\nint y;\n#endif",
        "long y;",
        'void f(void) { asm("nop"); }',
        "int f(int x) { return __builtin_abs(x); }",
        "/*@ ghost int y; */",
    ],
)
def test_c_that_is_another_for_one_compiler_than_for_another_is_refused(tmp_path, text):
    good = '#ifndef A_H\n#define A_H\n/* As long as asm. */\n// long\nint x; char y[] = "too long";\n#endif\n'
    refused(tmp_path, good, f"{text}\n", "expected the same C for each compiler and processor")


@pytest.mark.parametrize(
    "text",
    [
        "#ifndef __FRAMAC__\n    y[9] = 0.0;\n#endif",
        "#ifdef __FRAMAC__\n    y[0] = 0.0;\n#endif",
        "#ifdef __FRAMAC__\n#undef A_FINITE\n#endif",
        "#ifdef PROOF_APART\n    //@ assert x > 1;\n    y[0] = 0.0;\n#endif",
        "#ifdef PROOF_APART\nextern int f(int x);\n#endif",
    ],
)
def test_c_that_is_another_for_the_proof_than_for_the_compiler_is_refused(tmp_path, text):
    good = (
        "#ifdef __FRAMAC__\n#define A_FINITE(y) \\\n    ensures x;\n#endif\n"
        "#ifdef PROOF_APART\n    //@ assert x > 1;\n#endif\n"
        "#ifdef PROOF_APART\nextern int f(int x);\n#else\nstatic inline int f(int x)\n{\n    return x;\n}\n#endif\n"
    )
    refused(tmp_path, good, f"{text}\n", "expected the C that flies")


def test_a_loop_is_proved_only_where_every_program_that_has_it_proves_it():
    assert proved([(("a", True), ("b", True)), (("b", False),)]) == {"a": True, "b": False}


def test_a_bound_that_is_not_proved_ends_the_proof(monkeypatch):
    loop = ("a.c: for (int i = 0; i < n; ++i)", False)
    monkeypatch.setattr(make, "side_by_side", lambda f, of: [Result((), 1, (1, 1), 0.0, (), (loop,)) for _ in of])
    with pytest.raises(InputError, match="1 properties are neither proved nor argued for"):
        make.prove(["field"])


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("frama-c") is None, reason="frama-c is not installed (Debian: frama-c-base)")
def test_a_bound_that_is_too_low_is_not_proved(tmp_path, monkeypatch):
    subject = replace(next(s for s in SUBJECTS if s.name == "field"))
    known = rounds.bounds()
    monkeypatch.setattr(rounds, "bounds", lambda: {**known, **{k: 1 for k in known if "onboard_field" in k[0]}})
    found = dict(subject.prove(tmp_path).rounds)
    assert found
    assert not all(found.values())
