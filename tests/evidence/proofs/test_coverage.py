"""Which functions lie in a proved program: planted functions that none enters are named.

Shows FC-1.
"""

from __future__ import annotations

import re

import pytest
import yaml

from evidence.proofs import coverage, make
from evidence.proofs.analysis import Alarm, Result
from evidence.proofs.coverage import FLIGHT, defined, rows
from evidence.proofs.make import PAGE, followed_elsewhere, refuse_stale
from evidence.proofs.subjects import REACHED, SUBJECTS
from orchestration import InputError

ESTIMATOR = next(s for s in SUBJECTS if s.name == "estimator")
FILTER = next(s for s in SUBJECTS if s.name == "filter")


def result(*functions):
    return Result((), 1, (1, 1), 1.0, functions)


def test_functions_are_found_by_their_definitions_and_not_by_calls_or_declarations(tmp_path):
    path = tmp_path / "a.c"
    path.write_text(
        "int declared(int x);\nstatic inline Vector of_type(const double v[3],\n    int n)\n{\n    called(n);\n}\n"
        "const char *pointer(void)\n{\n}\n#if X\nint twice(void)\n{\n}\n#else\nint twice(void)\n{\n}\n#endif\n"
    )
    assert defined(path) == {"of_type", "pointer", "twice"}


def test_a_function_is_covered_by_its_own_program_or_by_another_or_it_is_named(tmp_path, monkeypatch):
    path = ESTIMATOR.block.folder / "native" / "filter.c"
    functions = sorted(defined(path))
    monkeypatch.setattr(coverage, "parts", lambda blocks: [("estimator", [path])])
    own, other, left = functions[0], functions[1], functions[2:]
    programs = [(ESTIMATOR, result(f"{own}_3")), (FILTER, result(other, "main"))]
    assert rows(FLIGHT, programs) == [("`estimator`", "1", "1: `filter`", ", ".join(f"`{n}`" for n in left))]


def test_of_two_functions_with_one_name_both_have_to_be_entered(monkeypatch):
    native = ESTIMATOR.block.folder / "native"
    files = [native / "banked.c", native / "measurements.c"]
    monkeypatch.setattr(coverage, "parts", lambda blocks: [("estimator", files)])
    for entered, missed in ((("take",), True), (("take", "take_0"), False)):
        assert ("`take`" in rows(FLIGHT, [(ESTIMATOR, result(*entered))])[0][3]) == missed


def test_each_block_of_the_flight_code_has_a_program():
    assert not set(FLIGHT) - {s.name for s in SUBJECTS if s.span == "any"}


def test_the_page_is_of_the_run_that_was_kept():
    kept = yaml.safe_load(REACHED.read_text("utf-8"))
    rows = re.findall(r"^\| `(\w+)`, (\w+) \| (\d+) of", PAGE.read_text("utf-8"), re.MULTILINE)
    assert {(name if name in kept else f"{name}, {span}"): int(n) for name, span, n in rows} == kept


def test_what_is_traced_to_a_proof_is_the_c_that_was_proved(monkeypatch):
    refuse_stale()
    monkeypatch.setattr(make, "digests", dict)
    with pytest.raises(InputError, match="the C that was proved is another; remedy: make prove"):
        refuse_stale()


def test_a_contract_that_stands_in_for_a_body_is_proved_by_another_program():
    name = ESTIMATOR.by_contract[0]
    followed_elsewhere([(ESTIMATOR, result(name)), (FILTER, result(name))])
    for others in ([], [(FILTER, result("main"))]):
        with pytest.raises(InputError, match=f"estimator, any: no program follows {name}"):
            followed_elsewhere([(ESTIMATOR, result(name)), *others])


def test_only_what_such_a_contract_ensures_is_left_to_the_other_program():
    ensured = Alarm("filter.h", 1, ESTIMATOR.by_contract[0], "postcondition", "initialized")
    assert ESTIMATOR.is_proved_elsewhere(ensured)
    assert not FILTER.is_proved_elsewhere(ensured)
    assert not ESTIMATOR.is_proved_elsewhere(Alarm("filter.h", 1, "estimator_correct", "postcondition", "initialized"))
    called = Alarm("bank.c", 1, ESTIMATOR.by_contract[0], "precondition of estimator_correct_states", "valid")
    assert not ESTIMATOR.is_proved_elsewhere(called)
