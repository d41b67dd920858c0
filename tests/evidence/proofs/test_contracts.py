"""Contracts that WP proves: each names functions with a contract in its file, and every real output is in the guard.

Shows FC-4.
"""

from __future__ import annotations

import re
import shutil

import pytest

from evidence.proofs.contracts import CONTRACTS, refuse_unproved
from evidence.proofs.coverage import FLIGHT
from fmus.block import Block
from fmus.interface import BLOCKS, load
from fmus.native.generate import members_of
from fmus.native.guard import guard_header
from fmus.places import PACKAGES
from orchestration import InputError


@pytest.mark.parametrize("block", BLOCKS)
def test_every_real_output_of_a_block_is_in_its_guard_and_in_what_it_promises(block):
    interface = load(block)
    (text,) = guard_header(interface).values()
    guard = text[text.index("_guard(const") :]
    promised = text[text.index("_FINITE") : text.index("#endif\n\n/* Notes")]
    for v in interface.of("output"):
        first, n = members_of(interface, v)[0], len(v.elements)
        asked = f"run_finite(&y->{first}, {n})" if "[" in first else f"is_number(y->{first})"
        assert (asked in guard) == (v.type == "real")
        assert bool(re.search(rf"y->{re.escape(first)}[);]", promised)) == (v.type == "real")
        assert (f'"{v.name}"' in text) == (v.type == "real")


@pytest.mark.parametrize("block", FLIGHT)
def test_outputs_and_step_of_each_block_that_flies_promise_what_its_guard_does(block):
    contract = next(c for c in CONTRACTS if c.title == f"guard, {block}")
    text = (PACKAGES / contract.file).read_text("utf-8")
    code = Block.named(block).interface.code
    for call in ("outputs", "step"):
        limits = r"\n    COMMANDS_WITHIN\(&law->p\)" if code == "controller_planned" else ""
        assert re.search(rf"{code.upper()}_FINITE{limits} \*/\nbool {code}_{call}\(", text)
        assert f"{code}_{call}" in contract.functions


@pytest.mark.parametrize(
    ("block", "old", "new", "says"),
    [
        (
            "supervisor",
            "    return outputs_of(law, x, u, y, f) && supervisor_guard(y, f);",
            "    const bool given = outputs_of(law, x, u, y, f) && supervisor_guard(y, f);\n"
            "    done();\n    return given;",
            "supervisor_outputs: done(...) behind the guard",
        ),
        (
            "controller_planned_wheels",
            "bool controller_planned_wheels_outputs(",
            "bool other(int x)\n{\n    return x > 0;\n}\n\nbool controller_planned_wheels_outputs(",
            "other has a contract that is not proved",
        ),
        (
            "controller_planned_wheels",
            "bool controller_planned_wheels_outputs(",
            "bool other(int x);\n\nbool controller_planned_wheels_outputs(",
            "stands before no function's body",
        ),
        (
            "allocator_bounded",
            "bool allocator_bounded_start(",
            "//@ ensures \\result == 0;\nbool allocator_bounded_start(",
            "'ensures \\\\result == 0' stands before no function's body",
        ),
        (
            "supervisor",
            "/*@ requires \\separated(x, y, f);\n    SUPERVISOR_FINITE */\nbool supervisor_step(",
            "/*@ requires \\separated(x, y, f) && h < 0.0 && h > 1.0;\n    SUPERVISOR_FINITE */\nbool supervisor_step(",
            "supervisor_step: expected to require that x, y and f are apart, and no more",
        ),
    ],
)
def test_a_call_behind_the_guard_and_a_contract_that_nobody_proves_are_refused(block, old, new, says):
    contract = next(c for c in CONTRACTS if c.title == f"guard, {block}")
    text = (PACKAGES / contract.file).read_text("utf-8")
    refuse_unproved(text, contract)
    assert text.count(old) == 1
    with pytest.raises(InputError, match=re.escape(says)):
        refuse_unproved(text.replace(old, new), contract)


@pytest.mark.thorough
@pytest.mark.skipif(
    not all(map(shutil.which, ("frama-c", "why3", "z3"))), reason="frama-c, why3 or z3 is not installed"
)
@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda c: c.title)
def test_each_contract_is_proved(contract, tmp_path):
    result = contract.prove(tmp_path)
    assert result.alarms == ()
    assert result.proved >= 5
