"""A planned scenario as tables in C: its wiring, order, rates, start values and faults, for loop.c, live.c and changes.c.

Longer than 250 lines: all tables name places on one bus.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import TYPES, Element, Floats, Model
from ..fmu.types import CODES
from ..instances.calls import Exchange
from ..instances.layout import exchanges
from ..master.bus import Bus, Seat, lay_out
from ..runner.plan import Plan
from ..system.disturbances import Disturbance
from ..system.faults import Faults, Setting
from ..system.starts import Start
from ..system.wiring import Node

_CTYPES = dict(
    zip(
        CODES,
        "double float int8_t uint8_t int16_t uint16_t int32_t uint32_t int64_t uint64_t bool".split(),
        strict=True,
    )
)
_EXCHANGE = "fmi2Status (*)(fmi2Component, const fmi2ValueReference[], size_t, void *)"


@dataclass
class _Tabled:
    """What the master's bus is laid out for, in place of an instance."""

    name: str
    model: Model
    setters: list[Exchange] = field(default_factory=list)
    getters: list[Exchange] = field(default_factory=list)

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        values = np.zeros(len(inputs))
        self.setters = exchanges("Set", self.model, inputs, [0] * len(TYPES), values, str)
        self.getters = exchanges("Get", self.model, outputs, live, into, str)
        return values


@dataclass
class Tables:
    """The C text, and where the page finds what it may change."""

    text: str
    places: dict[Node, int]
    """Where each start value lies in `start_values`."""
    values: list[float]
    """What the scenario has there."""


def tables(
    plan: Plan, code: Mapping[str, str], starts: Mapping[str, Sequence[Start]], faults: Sequence[Faults]
) -> Tables:
    """Of a plan. `code` says whose functions an instance calls; `faults` are what each fault does."""
    return _Writer(plan, code).write(starts, faults)


class _Writer:
    def __init__(self, plan: Plan, code: Mapping[str, str]) -> None:
        self.plan, self.code = plan, code
        self.lines: list[str] = []
        self._known: dict[str, str] = {}
        blocks: dict[str, Any] = {name: _Tabled(name, model) for name, model in plan.models.items()}
        self.bus: Bus = lay_out(blocks, plan.wiring, plan.order, plan.columns)
        self.seats = {seat.block.name: i for i, seat in enumerate(self.bus.seats)}
        self.places = {
            Node(seat.block.name, element): self._first(seat) + i
            for seat in self.bus.seats
            for i, element in enumerate(seat.outputs)
        }

    def _first(self, seat: Seat) -> int:
        """Where a seat's outputs begin on the bus."""
        return (seat.view.ctypes.data - self.bus.values.ctypes.data) // self.bus.values.itemsize

    def write(self, starts: Mapping[str, Sequence[Start]], faults: Sequence[Faults]) -> Tables:
        clock, bus = self.plan.clock, self.bus
        self.lines += [f"static double bus[{max(1, len(bus.values))}];"]
        self.lines += [f"static double inputs_{i}[{max(1, len(s.inputs.values))}];" for i, s in enumerate(bus.seats)]
        places, values = self._starts(starts)
        self._levels()
        self._faults(faults)
        self._define("Seat seats", [self._seat(i, seat) for i, seat in enumerate(bus.seats)])
        self._define("const Instance instances", [self._instance(seat.block.name) for seat in bus.seats])
        delay = bus.delay
        loop = {
            "seats": "seats",
            "seat_count": len(bus.seats),
            "parallel": int(self.plan.scenario.exchange == "parallel"),
            "bus": "bus",
            "delayed": self._array("int64_t", delay.sources if delay else ()),
            "held": f"bus + {delay.first if delay else 0}",
            "delayed_count": len(delay.sources) if delay else 0,
            "columns": self._array("int64_t", bus.columns),
            "column_count": len(bus.columns),
            "interval": clock.interval,
            "numerator": float(clock.numerator),
            "denominator": float(clock.denominator),
            "disturbances": "disturbances",
            "disturbance_count": sum(len(each.disturbances) for each in faults),
        }
        self.lines += [f"Loop loop = {_fields(loop)};", f"const int64_t steps = {clock.steps};"]
        self.lines += [f"const size_t bus_size = {len(bus.values)};"]
        declared = "".join(f"BLOCK({name})\n" for name in dict.fromkeys(self.code.values()))
        text = f'#include "live.h"\n\n#include <math.h>\n\n{declared}\n' + "\n".join(self.lines) + "\n"
        return Tables(text, places, values)

    # ------------------------------------------------------------ pieces of C

    def _define(self, what: str, items: Sequence[str]) -> None:
        self.lines.append(f"{what}[] = {{{', '.join(items) or '{0}'}}};")

    def _array(self, ctype: str, values: Iterable[Any]) -> str:
        """The name of a constant array with these values; NULL where there are none."""
        text = ", ".join(_number(value) for value in values)
        if not text:
            return "NULL"
        line = f"{ctype} NAME[] = {{{text}}};"
        if line not in self._known:
            self._known[line] = f"array_{len(self._known)}"
            self.lines.append("static const " + line.replace("NAME", self._known[line]))
        return self._known[line]

    def _room(self, ctype: str, count: int) -> str:
        """The name of an array to write to."""
        name = f"room_{len(self.lines)}"
        self.lines.append(f"static {ctype} {name}[{count}];")
        return name

    def _exchange(self, block: str, it: Exchange, values: str, places: NDArray[Any] | None = None) -> str:
        """An exchange on these values; at other places among them than its own where these are given."""
        direct = it.direct and places is None
        buffer = f"{values} + {it.places[0]}" if direct else self._room(_CTYPES[it.native.code], len(it.buffer))
        low, beyond = it.native.bounds
        entries = {
            "function": f"{{.two = ({_EXCHANGE}){self.code[block]}_{it.name}}}",
            "references": self._array("uint32_t", it.references.tolist()),
            "values": values,
            "places": "NULL" if direct else self._array("int64_t", (it.places if places is None else places).tolist()),
            "slots": self._array("int64_t", it.slots.tolist()),
            "buffer": buffer,
            "low": low,
            "beyond": beyond,
            "live": _list(it.live),
            "all": _list(it.all),
            "type": CODES.index(it.native.code),
        }
        return _fields(entries)

    def _moves(self, verb: str, block: str, places: Mapping[Element, int], values: str) -> list[str]:
        """Exchanges of these elements of a block with their places among values."""
        model = self.plan.models[block]
        elements = sorted(places, key=lambda e: (TYPES.index(model.variables[e.variable].type), places[e]))
        where = np.array([places[element] for element in elements], np.int64)
        made = exchanges(verb, model, elements, [0] * len(TYPES), np.zeros(len(elements)), str)
        return [self._exchange(block, it, values, where[it.places]) for it in made]

    def _seat(self, index: int, seat: Seat) -> str:
        block, name = seat.block, seat.block.name
        assert isinstance(block, _Tabled)
        every = self.plan.scenario.blocks[name].every
        inputs, outputs = f"inputs_{index}", f"bus + {self._first(seat)}"
        setters = [self._exchange(name, it, inputs) for it in block.setters]
        getters = [self._exchange(name, it, f"({outputs})") for it in block.getters]
        self._define(f"static const Exchange setters_{index}", setters)
        self._define(f"static const Exchange getters_{index}", getters)
        factors, offsets = seat.inputs.factors, seat.inputs.offsets
        return _fields(
            {
                "do_step": f"{{.two = {self.code[name]}_fmi2DoStep}}",
                "version": 2,
                "every": every,
                "step": every * self.plan.clock.numerator / self.plan.clock.denominator,
                "sources": self._array("int64_t", seat.inputs.sources.tolist()),
                "factors": self._array("double", () if factors is None else factors.tolist()),
                "offsets": self._array("double", () if offsets is None else offsets.tolist()),
                "inputs": inputs,
                "input_count": len(seat.inputs.sources),
                "setters": f"setters_{index}",
                "setter_count": len(setters),
                "getters": f"getters_{index}",
                "getter_count": len(getters),
                "outputs": outputs,
                "output_count": len(seat.view),
            }
        )

    def _instance(self, name: str) -> str:
        code = self.code[name]
        functions = "Instantiate SetupExperiment EnterInitializationMode ExitInitializationMode SetString".split()
        return _list([_text(name), _text(code), *(f"{code}_fmi2{function}" for function in functions)])

    # ------------------------------------------------------------ initialization

    def _starts(self, starts: Mapping[str, Sequence[Start]]) -> tuple[dict[Node, int], list[float]]:
        places: dict[Node, int] = {}
        values: list[float] = []
        moves: list[str] = []
        texts: list[str] = []
        for block, given in starts.items():
            numbers: dict[Element, int] = {}
            words: list[tuple[int, str]] = []
            for start in given:
                variable = self.plan.models[block].variables[start.element.variable]
                if variable.type == "string":
                    words.append((variable.references[start.element.position], str(start.value)))
                    continue
                numbers[start.element] = places[Node(block, start.element)] = len(values)
                values.append(float(start.value))
            seat = self.seats[block]
            moves += [_list([seat, it]) for it in self._moves("Set", block, numbers, "start_values")] if numbers else []
            if words:
                self.lines.append(f"static const fmi2String text_{seat}[] = {_list(_text(word) for _, word in words)};")
                texts.append(_list([seat, self._array("uint32_t", (r for r, _ in words)), len(words), f"text_{seat}"]))
        self.lines.append(f"double start_values[] = {{{', '.join(map(_number, values)) or '0.0'}}};")
        self._define("const Move starts", moves)
        self._define("const Texts texts", texts)
        self.lines += [f"const size_t start_count = {len(moves)};", f"const size_t text_count = {len(texts)};"]
        return places, values

    def _levels(self) -> None:
        fed: dict[Node, list[str]] = {}
        targets: dict[Node, list[Node]] = {}
        for link in self.plan.wiring.links:
            for source, target in () if link.delayed else zip(link.source, link.target, strict=True):
                entry = [self.places[source], self.seats[target.block], self._input(target), link.factor, link.offset]
                fed.setdefault(source, []).append(_list(entry))
                targets.setdefault(source, []).append(target)
        levels = []
        for number, level in enumerate(self.plan.order.levels):
            gets, sets = [], []
            taken: dict[str, dict[Element, int]] = {}
            given: dict[str, dict[Element, int]] = {}
            for node in level:
                if node in self.places:
                    taken.setdefault(node.block, {})[node.element] = self.places[node]
                for target in targets.get(node, ()):
                    given.setdefault(target.block, {})[target.element] = self._input(target)
            for block, places in taken.items():
                gets += [_list([self.seats[block], it]) for it in self._moves("Get", block, places, "bus")]
            for block, places in given.items():
                seat = self.seats[block]
                sets += [_list([seat, it]) for it in self._moves("Set", block, places, f"inputs_{seat}")]
            feeds = [feed for node in level for feed in fed.get(node, ())]
            self._define(f"static const Move gets_{number}", gets)
            self._define(f"static const Feed feeds_{number}", feeds)
            self._define(f"static const Move sets_{number}", sets)
            names = f"gets_{number}", len(gets), f"feeds_{number}", len(feeds), f"sets_{number}", len(sets)
            levels.append(_list(names))
        self._define("const Level levels", levels)
        self.lines.append(f"const size_t level_count = {len(levels)};")

    def _input(self, node: Node) -> int:
        """Where an input lies among those of its seat."""
        return self.bus.seats[self.seats[node.block]].inputs.elements.index(node.element)

    # ------------------------------------------------------------ faults

    def _faults(self, faults: Sequence[Faults]) -> None:
        disturbances = [(i, d) for i, each in enumerate(faults) for d in each.disturbances]
        self._define("static Disturbance disturbances", [self._disturbance(d) for _, d in disturbances])
        self._define("const size_t fault_of", [str(i) for i, _ in disturbances] or ["0"])
        self._changes([(i, setting) for i, each in enumerate(faults) for setting in each.settings])
        self.lines.append(f"int32_t acting[{max(1, len(faults))}];")

    def _disturbance(self, fault: Disturbance) -> str:
        first, last = fault.span
        entries = {
            "first": first,
            "last": "INT64_MAX" if last == math.inf else int(last),
            "behind": fault.behind(self.plan.scenario.exchange == "parallel", self.seats),
            "value": float(fault.value),
            "seat": self.seats[fault.target.block],
            "place": self._input(fault.target),
            "kind": f"FAULT_{fault.kind.upper()}",
        }
        return _fields(entries)

    def _changes(self, settings: Sequence[tuple[int, Setting]]) -> None:
        """The begins and ends of settings in the order of time, and the elements that they set; each with its fault's number."""
        nodes = dict.fromkeys(Node(s.block, element) for _, s in settings for element, _ in s.values)
        numbers = {node: number for number, node in enumerate(nodes)}
        for name in ("before", "sound", "given"):
            self.lines.append(f"double element_{name}[{max(1, len(numbers))}];")
        moments = []
        shared = []
        for place, (fault, setting) in enumerate(settings):
            block = setting.block
            every = self.plan.scenario.blocks[block].every
            begin, end = setting.span
            moments.append((math.ceil(begin / every) * every, place, False))
            if end < math.inf:
                moments.append((math.ceil(end / every) * every, place, True))
            mine = {element: numbers[Node(block, element)] for element, _ in setting.values}
            shared.append(
                {
                    "fault": fault,
                    "seat": self.seats[block],
                    "elements": self._array("size_t", mine.values()),
                    "values": self._array("double", (float(value) for _, value in setting.values)),
                    "count": len(mine),
                    **self._listed("get", self._moves("Get", block, mine, "element_before")),
                    **self._listed("set", self._moves("Set", block, mine, "element_given")),
                }
            )
        moments.sort(key=lambda moment: moment[0])
        ends = {place: number for number, (_, place, is_end) in enumerate(moments) if is_end}
        changes = [
            {"due": due, "end": 0 if is_end else ends.get(place, len(moments)), **shared[place]}
            for due, place, is_end in moments
        ]
        self._define("const Change changes", [_fields(change) for change in changes])
        self.lines.append(f"const size_t change_count = {len(changes)};")

    def _listed(self, kind: str, made: Sequence[str]) -> dict[str, Any]:
        """The entries for an array of exchanges: its name, and how many there are."""
        name = f"exchanges_{len(self.lines)}"
        self._define(f"static const Exchange {name}", made)
        return {f"{kind}s": name, f"{kind}_count": len(made)}


def _number(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return repr(float(value)).replace("inf", "INFINITY")
    return str(value)


def _text(text: str) -> str:
    shown = (chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode())
    return f'"{"".join(shown)}"'


def _list(items: Iterable[Any]) -> str:
    return f"{{{', '.join(map(_number, items))}}}"


def _fields(entries: Mapping[str, Any]) -> str:
    return f"{{{', '.join(f'.{name} = {_number(value)}' for name, value in entries.items())}}}"
