"""What a scenario loses by a swap: connections, records, expectations and figures of ports that are not there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..errors import Problems
from ..scenario.load import load
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from .prepared import Prepared


def settle(prepared: Prepared) -> None:
    """Takes out of the scenario what refers to ports that are not there.

    Raises InputError with all that cannot be taken out.
    """
    scenario = prepared.scenario
    with Problems() as problems:
        gone = _left_out(prepared, problems)
        unconnected = _unconnected(prepared)
        gone |= dict.fromkeys(unconnected)
        for number, connection in enumerate(scenario.connections):
            output = connection.source
            if _lacks(prepared, output) and ("connections", number) not in unconnected:
                text = f"{connection}: {output.block} lacks the output {output.variable}"
                remedy = "map it, or take out the connection"
                problems.append(scenario.error(("connections", number), text, remedy=remedy))
        acted_on: list[tuple[Key, Reference, str]] = [
            *((("faults", i, fault.kind), fault.target, "fault") for i, fault in enumerate(scenario.faults)),
            *((("timeline", i, "set", name), name, "entry") for i, e in enumerate(scenario.timeline) for name in e.set),
        ]
        for key, signal, what in acted_on:
            fitted = prepared.fits.get(signal.block)
            if fitted is not None and signal.variable in fitted.without:
                text = f"{signal} is optional and {signal.block} lacks it, so the {what} would change nothing"
                problems.append(scenario.error(key, text, remedy=f"take out the {what}"))
            if fitted is not None and signal.variable in fitted.ignored:
                ignored = f"{signal} is under 'ignore' in the mapping of {signal.block}"
                text, remedy = f"{ignored}, so the {what} would change nothing", f"map it, or take out the {what}"
                problems.append(scenario.error(key, text, remedy=remedy))
    if gone:
        prepared.scenario = load(scenario.source.without(gone))


def _left_out(prepared: Prepared, problems: Problems) -> dict[Key, None]:
    """Returns what of records, expectations, holds and figures refers to outputs that are not there."""
    scenario = prepared.scenario
    gone: dict[Key, None] = {}
    lost: dict[str, None] = {}
    for key, signal, whole in _references(scenario):
        fitted, name = prepared.fits.get(signal.block), signal.variable
        if fitted is None:
            continue
        ours = fitted.ignored.get(name) or fitted.missing.get(name)
        if name not in fitted.without:
            if ours is None or ours.causality != "output":
                continue
            if name in fitted.missing and key[0] in ("record", "expect"):
                text = f"{signal.block} lacks the output {name}, to which this refers"
                remedy = "map it in the mapping, or list it under ignore there, and this is left out"
                problems.append(scenario.error(key, text, remedy=remedy))
        if whole[0] == "expect" and whole not in gone:
            prepared.not_evaluated.append((scenario.expect[int(whole[1])], f"{signal.whole} is not there"))
        gone[whole] = lost[signal.whole] = None
    _empty(scenario, gone)
    if gone and not problems:
        outermost = [key for key in gone if not any(key[:n] in gone for n in range(1, len(key))) and "names" not in key]
        entries = "; ".join(dict.fromkeys(_entry(scenario, key) for key in outermost))
        verb = "are" if len(lost) > 1 else "is"
        prepared.notes.append(f"left out, since {', '.join(lost)} {verb} not there: {entries}")
    return gone


def _empty(scenario: Scenario, gone: dict[Key, None]) -> None:
    """Takes out what is empty without what is gone: a panel, a figure, the list of recorded signals; and the names of
    curves."""
    if (recorded := scenario.record.signals) and all(("record", "signals", i) in gone for i in range(len(recorded))):
        gone[("record", "signals")] = None  # then all outputs are recorded
    for i, figure in enumerate(scenario.figures):
        for j, panel in enumerate(figure.panels):
            place: Key = ("figures", i, "panels", j)
            left = [k for k in range(len(panel.signals)) if (*place, "signals", k) not in gone]
            if not left:
                gone[place] = None
            elif len(left) < len(panel.signals) and panel.names:
                one_each = len(panel.names) == len(panel.signals)
                lost = [(*place, "names", k) for k in range(len(panel.signals)) if k not in left]
                gone.update(dict.fromkeys(lost if one_each else [(*place, "names")]))
        if all(("figures", i, "panels", j) in gone for j in range(len(figure.panels))):
            gone[("figures", i)] = None


def _lacks(prepared: Prepared, output: Reference) -> bool:
    """Returns whether a swapped block does not give this output."""
    fitted, name = prepared.fits.get(output.block), output.variable
    return (
        fitted is not None
        and (name in fitted.ignored or name in fitted.missing)
        and name not in fitted.theirs.variables
    )


def _unconnected(prepared: Prepared) -> list[Key]:
    """Returns what a scenario says of optional inputs that a swapped block lacks, or to which one gives nothing."""
    scenario = prepared.scenario
    keys: list[Key] = []
    dropped: list[str] = []
    free: set[str] = set()

    def without(block: str, name: str) -> bool:
        return block in prepared.fits and name in prepared.fits[block].without

    for number, connection in enumerate(scenario.connections):
        target = connection.target
        variable = (
            prepared.models[target.block].variables.get(target.variable) if target.block in prepared.models else None
        )
        optional = variable is not None and variable.optional
        if without(target.block, target.variable) or (optional and _lacks(prepared, connection.source)):
            keys.append(("connections", number))
            dropped.append(str(connection))
            free.add(target.whole)
    keys += [("delays", number) for number, delayed in enumerate(scenario.delays) if delayed.whole in free]
    for block, entry in scenario.blocks.items():
        for name in entry.start:
            if without(block, name.variable):
                keys.append(("blocks", block, "start", name))
                dropped.append(f"the value of {block}.{name}")
    if dropped:
        prepared.notes.append(
            f"dropped, since an end of it is not there and the input is optional: {'; '.join(dropped)}"
        )
    return keys


def _references(scenario: Scenario) -> Iterator[tuple[Key, Reference, Key]]:
    """Every mention of a signal outside connections: where it stands, what it says, and what goes with it."""
    for i, signal in enumerate(scenario.record.signals or ()):
        if isinstance(signal, Reference):
            yield ("record", "signals", i), signal, ("record", "signals", i)
    for i, expectation in enumerate(scenario.expect):
        for key, reference in _given(("expect", i), expectation, "signal", "when"):
            yield key, reference, ("expect", i)
    if scenario.phases is not None:
        yield ("phases", "signal"), scenario.phases.signal, ("phases",)
    for i, hold in enumerate(scenario.holds):
        for signal in (hold.signal, *hold.keeps):
            yield ("holds", i), signal, ("holds", i)
        for text, flag in hold.limits.items():
            yield ("holds", i, "limits", text), flag, ("holds", i, "limits", text)
    for i, figure in enumerate(scenario.figures):
        for key, reference in _given(("figures", i), figure, "shade", "mark"):
            yield key, reference, key
        for j, panel in enumerate(figure.panels):
            for k, signal in enumerate(panel.signals):
                key = ("figures", i, "panels", j, "signals", k)
                yield key, signal, key
    if (view := scenario.view) is not None:
        yield ("view", "attitude"), view.attitude, ("view",)
        for key, reference in _given(("view",), view, "desired", "position", "sun", "phase"):
            if isinstance(reference, Reference):
                yield key, reference, key
        for i, arrow in enumerate(view.vectors):
            yield ("view", "vectors", i, "signal"), arrow.signal, ("view", "vectors", i)


def _given(key: Key, entry: Any, *fields: str) -> Iterator[tuple[Key, Reference]]:
    return (((*key, name), getattr(entry, name)) for name in fields if getattr(entry, name))


def _entry(scenario: Scenario, key: Key) -> str:
    """An entry of the scenario in words."""
    if key[0] == "expect":
        return f"the expectation '{scenario.expect[int(key[1])].name}'"
    if key[0] == "holds":
        return f"the hold '{scenario.holds[int(key[1])].name}'"
    if key[0] == "figures":
        if "signals" in key:
            return f"a curve of the figure '{scenario.figures[int(key[1])].name}'"
        part = {"shade": "the shading of ", "mark": "the marks of "}.get(str(key[2]) if len(key) > 2 else "", "")
        what = "a panel of " if "panels" in key and not part else ""
        return f"{part}{what}the figure '{scenario.figures[int(key[1])].name}'"
    if key[0] == "phases":
        return "the phases"
    if key[0] == "view":
        return "a part of the view" if len(key) > 1 else "the view"
    return "a recorded signal" if len(key) > 2 else "all signals to be recorded, so all outputs are"
