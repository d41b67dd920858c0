"""The project's own FMUs under the master: what each block sees, and when."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestration import load, run

SCENARIO = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"
LINKS = {
    "controller.omega_B": "plant.omega_B",
    "controller.R_NB": "plant.R_NB",
    "allocator.tau_cmd_B": "controller.tau_cmd_B",
    "allocator.b_B": "plant.b_B",
    "plant.dipole_cmd": "allocator.dipole_cmd",
}


def fly(**changes: Any):
    """A few seconds of the loop, with what the blocks were given recorded beside what they gave."""
    source = load(SCENARIO).source
    data = {**source.data, "duration": 3, "expect": [], "figures": [], **changes}
    data["record"] = {"signals": [*LINKS, *LINKS.values()]}
    return run({key: value for key, value in data.items() if value != []})


def age(result, target: str) -> int:
    """How many steps old the value is that an input was given for the step that ends at a sample."""
    given, source = result[target], result[LINKS[target]]
    return next(n for n in range(5) if np.array_equal(given[5:], source[5 - n : len(source) - n]))


def test_sequential_exchange_delays_only_what_the_plant_holds():
    result = fly()
    assert {target: age(result, target) for target in LINKS} == {
        "controller.omega_B": 0,
        "controller.R_NB": 0,
        "allocator.tau_cmd_B": 0,
        "allocator.b_B": 0,
        "plant.dipole_cmd": 1,  # held over the step that ends at the sample
    }


def test_parallel_exchange_delays_every_connection_by_a_step():
    result = fly(exchange="parallel")
    assert {age(result, target) for target in LINKS} == {1}


def test_initialization_gives_every_block_what_the_others_start_with():
    result = fly()
    for target, source in LINKS.items():
        np.testing.assert_array_equal(result[target][0], result[source][0])


@pytest.mark.parametrize(
    "order", [["judge", "allocator", "controller", "plant"], ["controller", "plant", "allocator", "judge"]]
)
def test_the_order_of_blocks_in_the_file_changes_no_bit(order):
    blocks = load(SCENARIO).source.data["blocks"]
    usual, other = fly(), fly(blocks={name: blocks[name] for name in order})
    assert [name for name in other.manifest["order"] if name != "judge"] == ["plant", "controller", "allocator"]
    for name in usual:
        np.testing.assert_array_equal(other[name], usual[name])


def test_laws_at_a_multiple_of_the_base_step_are_sampled_and_held():
    blocks = load(SCENARIO).source.data["blocks"]
    slow = {name: {**entry, "every": 1 if name == "plant" else 5} for name, entry in blocks.items()}
    result = fly(blocks=slow)
    command = result["controller.tau_cmd_B"]
    for n in range(5, len(command) - 5, 5):
        assert (command[n : n + 5] == command[n]).all()
        assert (command[n] != command[n + 5]).any()
    np.testing.assert_array_equal(result["controller.omega_B"][::5], result["plant.omega_B"][::5])
