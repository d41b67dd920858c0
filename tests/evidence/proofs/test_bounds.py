"""Stack, recursion and heap of the flight code, by the call graphs of a compiler for Arm.

Shows FC-2.
"""

from __future__ import annotations

import shutil

import pytest

from evidence.processor.firmware import deepest
from evidence.proofs.bounds import CALLS, _graph, bounds_of, refuse_heap
from orchestration import InputError

compiled = pytest.mark.skipif(
    shutil.which("arm-none-eabi-gcc") is None, reason="arm-none-eabi-gcc is not installed (Debian: gcc-arm-none-eabi)"
)


@pytest.mark.parametrize("function", ["malloc", "free"])
def test_a_call_of_the_heap_is_refused(function):
    graph = f'edge: {{ sourcename: "allocator_step" targetname: "{function}" label: "a.c:2:2" }}'
    with pytest.raises(InputError, match=f"allocator calls {function}"):
        refuse_heap("allocator", [graph])
    refuse_heap("allocator", [graph.replace(function, f"{function}_none")])


@pytest.mark.thorough
@compiled
def test_the_allocator_has_a_bounded_stack_and_a_step_needs_at_least_that_of_its_outputs():
    bounds = bounds_of("allocator")
    assert set(bounds.stack) == set(CALLS)
    assert 100 < bounds.stack["outputs"] < bounds.stack["step"] < 1000


@pytest.mark.thorough
@compiled
@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("static int (*const g)(int) = h;\nint f(int x);\nint f(int x)\n{\n    return g(x);\n}\n", "__indirect_call"),
        ("int f(int x);\nint f(int x)\n{\n    return x < 2 ? h(x) : f(x - 2);\n}\n", "f calls f"),
    ],
)
def test_what_the_optimiser_hides_is_refused(tmp_path, text, says):
    source = tmp_path / "f.c"
    source.write_text(f"static int h(int x)\n{{\n    return x + 1;\n}}\n{text}")
    assert deepest([_graph(source, [], tmp_path)], "f") >= 0
    with pytest.raises(InputError, match=says):
        deepest([_graph(source, [], tmp_path, "-O0")], "f")
