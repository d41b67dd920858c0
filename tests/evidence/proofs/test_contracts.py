"""Contracts that WP proves: each names functions with a contract in its file, and every real output is in the guard.

Shows FC-4.
"""

from __future__ import annotations

import re
import shutil

import pytest

from evidence.proofs.contracts import CONTRACTS
from fmus.interface import BLOCKS, load
from fmus.native.generate import table
from fmus.places import PACKAGES


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda c: c.title)
def test_each_function_has_a_contract_in_the_file(contract):
    files = [PACKAGES / contract.file, *(PACKAGES / "fmus" / "native" / "common").glob("*.h")]
    text = "\n".join(path.read_text("utf-8") for path in files)
    for function in contract.functions:
        assert re.search(rf"ensures [^;]*;[^;]*\*/\n(static )?(inline )?bool {function}\(", text), function


@pytest.mark.parametrize("block", BLOCKS)
def test_every_real_output_of_a_block_is_in_a_run_that_the_guard_looks_at(block):
    interface, text = load(block), table(load(block))
    starts = [int(n) for n in re.findall(r"real_outputs\[BLOCK_REAL_OUTPUTS\] = \{([^}]*)\}", text)[0].split(",")]
    rows = [row for row in text.splitlines() if row.startswith("    ROW(")]
    seen = [n for start in starts for n in range(start, start + int(rows[start].split(",")[-1].strip(" )")) + 1)]
    outputs = [r for v in interface.of("output") if v.type == "real" for r in v.value_references]
    assert seen == sorted(outputs)


@pytest.mark.thorough
@pytest.mark.skipif(
    not all(map(shutil.which, ("frama-c", "why3", "z3"))), reason="frama-c, why3 or z3 is not installed"
)
@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda c: c.title)
def test_each_contract_is_proved(contract, tmp_path):
    result = contract.prove(tmp_path)
    assert result.alarms == ()
    assert result.proved >= 5
