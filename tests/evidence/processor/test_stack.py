"""The deepest stack from the compiler's call graphs: sums by hand, and refusals of what has no bound."""

from __future__ import annotations

import pytest

from evidence.processor.firmware import deepest
from orchestration import InputError


def graph(frames: dict[str, str], *calls: tuple[str, str]) -> str:
    """A call graph as `-fcallgraph-info=su` writes it."""
    nodes = [
        f'node: {{ title: "{f}" label: "{f}\\na.c:1:1\\n{size}\\n0 dynamic objects" }}' for f, size in frames.items()
    ]
    edges = [f'edge: {{ sourcename: "{a}" targetname: "{b}" label: "a.c:2:2" }}' for a, b in calls]
    return "\n".join(['graph: { title: "a.c"', *nodes, *edges, "}"])


def test_the_deepest_chain_counts_across_files_and_not_the_widest_function():
    one = graph(
        {"top": "16 bytes (static)", "wide": "100 bytes (static)", "a.c:step": "40 bytes (static)"},
        ("top", "wide"),
        ("top", "a.c:step"),
    )
    other = graph({"deep": "80 bytes (static)"})
    assert deepest([one, other], "top") == 116
    assert deepest([one + graph({}, ("a.c:step", "deep")), other], "top") == 16 + 40 + 80


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (graph({"top": "16 bytes (static)"}, ("top", "top")), "top calls top"),
        (graph({"top": "16 bytes (static)"}, ("top", "__indirect_call")), "top calls __indirect_call"),
        (graph({"top": "16 bytes (dynamic)"}), "top: its frame on the stack has no fixed size"),
    ],
)
def test_a_stack_without_a_bound_is_refused(text, message):
    with pytest.raises(InputError, match=message):
        deepest([text], "top")
