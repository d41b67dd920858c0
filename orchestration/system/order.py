"""In which order blocks are stepped, and how values spread in initialization.

Both come from what the FMUs declare of direct feedthrough. The graph has a node for each output that
feeds something; it depends on the outputs that feed those inputs on which it depends directly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from ..errors import InputError
from ..fmu.model import Element, Model
from ..scenario.scenario import Scenario
from .wiring import Node, Wiring

Graph = dict[Node, dict[Node, bool]]
"""For each output the outputs on which it depends: True where declared, False where only assumed."""

Hook = Callable[[str, Element], frozenset[Element] | None]
"""What to take for the feedthrough of an output of a block whose FMU does not say; None for all inputs."""


@dataclass
class Order:
    blocks: list[str]
    levels: list[list[Node]]
    """Outputs in the order in which initialization has to read them; those of one level need none of the others."""
    warnings: list[str] = field(default_factory=list)


def sort(scenario: Scenario, models: Mapping[str, Model], wiring: Wiring, feedthrough: Hook | None = None) -> Order:
    """The order for these connections. Raises InputError where they close an algebraic loop."""
    sources = wiring.sources()
    warnings: list[str] = []
    graphs: list[Graph] = []
    for what in ("feedthrough", "initial"):
        graph = _graph(models, sources, what, feedthrough)
        _refuse_loops(scenario, graph, sources, "in initialization " if what == "initial" else "")
        warnings += _drop_assumed_loops(graph)
        graphs.append(graph)
    direct, initial = graphs
    blocks, late = _blocks(models, direct, _all_edges(models, sources, feedthrough))
    warnings += late if scenario.exchange == "sequential" else []
    levels: dict[int, list[Node]] = {}
    for node, level in _levels(initial).items():
        levels.setdefault(level, []).append(node)
    return Order(blocks, [levels[level] for level in sorted(levels)], list(dict.fromkeys(warnings)))


def _graph(models: Mapping[str, Model], sources: Mapping[Node, Node], what: str, hook: Hook | None) -> Graph:
    return {node: _needs(models, sources, node, what, hook) for node in dict.fromkeys(sources.values())}


def _needs(
    models: Mapping[str, Model], sources: Mapping[Node, Node], node: Node, what: str, hook: Hook | None
) -> dict[Node, bool]:
    model = models[node.block]
    declared = getattr(model, what).get(node.element)
    inputs: Iterable[Element] | None = declared
    if inputs is None and hook is not None:
        inputs = hook(node.block, node.element)
    if inputs is None:
        inputs = model.inputs
    feeds = (sources.get(Node(node.block, element)) for element in sorted(inputs))
    return dict.fromkeys((source for source in feeds if source is not None), declared is not None)


# ---------------------------------------------------------------- algebraic loops


def _refuse_loops(scenario: Scenario, graph: Graph, sources: Mapping[Node, Node], when: str) -> None:
    declared = {node: [n for n, sure in needs.items() if sure] for node, needs in graph.items()}
    for group in components(declared):
        if len(group) == 1 and group[0] not in declared[group[0]]:
            continue
        loop = cycle(declared, group)
        targets = [_fed(node, loop[i - 1], sources) for i, node in enumerate(loop)]
        chain = [f"{n.block}.{n.element.variable}" for n in loop]
        path = " -> ".join(dict.fromkeys(chain)) + f" -> {chain[0]}"
        remedy = f"'delays: [{targets[0]}]' would break it" if targets[0] else "a delay would break it"
        raise InputError(scenario.error(("connections",), f"algebraic loop {when}through {path}; {remedy}"))


def _fed(node: Node, source: Node, sources: Mapping[Node, Node]) -> str:
    """The input of the node's block through which `source` comes in."""
    names = (f"{t.block}.{t.element.variable}" for t, s in sources.items() if t.block == node.block and s == source)
    return next(names, "")


def cycle(graph: Mapping[Node, list[Node]], group: list[Node]) -> list[Node]:
    """A loop within a strongly connected group, in the direction of the signals; always the same one."""
    node, path = max(group), []
    while node not in path:
        path.append(node)
        node = next(n for n in graph[node] if n in group)
    return list(reversed(path[path.index(node) :]))


def _drop_assumed_loops(graph: Graph) -> list[str]:
    """Leaves out assumed dependencies where only they close a loop; returns warnings."""
    warnings = []
    for group in components({node: list(needs) for node, needs in graph.items()}):
        members = set(group)
        for node in group:
            for other in [n for n, sure in graph[node].items() if not sure and n in members]:
                del graph[node][other]
                name = f"{node.block}.{node.element.variable}"
                warnings.append(
                    f"{node.block}: its FMU does not say on which inputs {name} depends directly; since a "
                    "dependence on "
                    f"{other.block}.{other.element.variable} would close a loop, it is taken to have none"
                )
    return warnings


def components(graph: Mapping[Node, list[Node]]) -> list[list[Node]]:
    """Strongly connected components, each after those on which it depends (Tarjan)."""
    index: dict[Node, int] = {}
    low: dict[Node, int] = {}
    stack: list[Node] = []
    groups: list[list[Node]] = []
    for root in graph:
        if root in index:
            continue
        work = [(root, iter(graph[root]))]
        index[root] = low[root] = len(index)
        stack.append(root)
        while work:
            node, successors = work[-1]
            for successor in successors:
                if successor not in index:
                    index[successor] = low[successor] = len(index)
                    stack.append(successor)
                    work.append((successor, iter(graph.get(successor, ()))))
                    break
                if successor in low:
                    low[node] = min(low[node], index[successor])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    at = stack.index(node)
                    groups.append(stack[at:])
                    for member in stack[at:]:
                        del low[member]
                    del stack[at:]
    return groups


# ---------------------------------------------------------------- order


def _levels(graph: Graph) -> dict[Node, int]:
    """The longest chain of dependencies below each node of a graph without loops."""
    levels: dict[Node, int] = {}
    for (node,) in components({node: list(needs) for node, needs in graph.items()}):
        levels[node] = max((levels[n] + 1 for n in graph.get(node, ())), default=0)
    return levels


def _all_edges(models: Mapping[str, Model], sources: Mapping[Node, Node], hook: Hook | None) -> set[tuple[str, str]]:
    """(before, after) by every output, also those that feed nothing."""
    edges = set()
    for block, model in models.items():
        for variable in model.of("output"):
            for element in variable.elements:
                for node in _needs(models, sources, Node(block, element), "feedthrough", hook):
                    edges.add((node.block, block))
    return edges


def _blocks(models: Mapping[str, Model], graph: Graph, soft: set[tuple[str, str]]) -> tuple[list[str], list[str]]:
    """Blocks in the order of the scenario, but each after those that feed its outputs.

    Outputs that feed something come first in this; then, as far as it goes, those that are only looked at.
    """
    hard = {(n.block, node.block) for node, needs in graph.items() for n in needs if n.block != node.block}
    levels = _levels(graph)
    rank = {block: min((lv for n, lv in levels.items() if n.block == block), default=len(levels)) for block in models}
    left, order, warnings = list(models), [], []
    while left:
        candidates = _ready(left, hard | soft)[:1] or sorted(_ready(left, hard), key=rank.__getitem__)
        if not candidates:
            candidates = sorted(left, key=rank.__getitem__)
            late = sorted({a for a, b in hard if b == candidates[0] and a in left})
            needed = {n for node, needs in graph.items() if node.block == candidates[0] for n in needs}
            values = sorted({f"{n.block}.{n.element.variable}" for n in needed if n.block in late})
            warnings.append(
                f"{candidates[0]} depends directly on {' and '.join(late)}, which is stepped after it: "
                f"{', '.join(values)} {'come' if len(values) > 1 else 'comes'} one step late"
            )
        order.append(candidates[0])
        left.remove(candidates[0])
    return order, warnings


def _ready(blocks: list[str], edges: set[tuple[str, str]]) -> list[str]:
    """Those that wait for none of the others."""
    return [b for b in blocks if not any(before in blocks and before != b for before, after in edges if after == b)]
