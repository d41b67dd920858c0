"""A planned scenario as tables in C: its wiring, order, rates, start values and faults, for loop.c, live.c and
changes.c.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import TYPES, Element, Floats, Model
from ..fmu.types import CODES
from ..instances.calls import Exchange
from ..instances.layout import exchanges
from ..master.bus import Bus, Seat, lay_out
from ..session.plan import Plan
from ..system.faults import Faults
from ..system.starts import Start
from ..system.wiring import Node
from .c_text import Text, fields, listed, number, quoted
from .fault_tables import write_faults
from .verdicts import OBSERVED, observed

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
    """Stands in the place of an instance where the master's bus is laid out."""

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
    """Returns the tables of a plan. `code` says whose functions an instance calls, `faults` what each fault does."""
    return _Writer(plan, code).write(starts, faults)


class _Writer:
    def __init__(self, plan: Plan, code: Mapping[str, str]) -> None:
        self.plan, self.code = plan, code
        self.c = Text()
        blocks: dict[str, Any] = {name: _Tabled(name, model) for name, model in plan.models.items()}
        self.bus: Bus = lay_out(blocks, plan.circuit, plan.columns, observed(plan))
        self.seats = {seat.block.name: i for i, seat in enumerate(self.bus.seats)}
        self.places = {
            Node(seat.block.name, element): self._first(seat) + i
            for seat in self.bus.seats
            for i, element in enumerate(seat.outputs)
        }

    def _first(self, seat: Seat) -> int:
        """Returns where a seat's outputs begin on the bus."""
        return (seat.view.ctypes.data - self.bus.values.ctypes.data) // self.bus.values.itemsize

    def write(self, starts: Mapping[str, Sequence[Start]], faults: Sequence[Faults]) -> Tables:
        clock, bus = self.plan.clock, self.bus
        self.c.lines += [f"static double bus[{max(1, len(bus.values))}];"]
        self.c.lines += [f"static double inputs_{i}[{max(1, len(s.inputs.values))}];" for i, s in enumerate(bus.seats)]
        places, values = self._starts(starts)
        self._levels()
        write_faults(self.plan, self, faults)
        self.c.define("Seat seats", [self._seat(i, seat) for i, seat in enumerate(bus.seats)])
        self.c.define("const Instance instances", [self._instance(seat.block.name) for seat in bus.seats])
        delay = bus.delay
        loop = {
            "seats": "seats",
            "seat_count": len(bus.seats),
            "parallel": int(self.plan.scenario.exchange == "parallel"),
            "bus": "bus",
            "delayed": self.c.array("int64_t", delay.sources if delay else ()),
            "held": f"bus + {delay.first if delay else 0}",
            "delayed_count": len(delay.sources) if delay else 0,
            "columns": self.c.array("int64_t", bus.columns),
            "column_count": len(bus.columns),
            "interval": clock.interval,
            "observed": self.c.array("int64_t", bus.observed),
            "observed_count": len(bus.observed),
            "observed_rows": self.c.room("double", OBSERVED * max(1, len(bus.observed))),
            "numerator": float(clock.numerator),
            "denominator": float(clock.denominator),
            "disturbances": "disturbances",
            "disturbance_count": sum(len(each.disturbances) for each in faults),
        }
        self.c.lines += [f"Loop loop = {fields(loop)};", f"const int64_t steps = {clock.steps};"]
        self.c.lines += [f"const size_t bus_size = {len(bus.values)};"]
        declared = "".join(f"BLOCK({name})\n" for name in dict.fromkeys(self.code.values()))
        text = f'#include "live.h"\n\n#include <math.h>\n\n{declared}\n' + "\n".join(self.c.lines) + "\n"
        return Tables(text, places, values)

    def _exchange(self, block: str, it: Exchange, values: str, places: NDArray[Any] | None = None) -> str:
        """Returns an exchange on these values; at other places among them than its own where these are given."""
        direct = it.direct and places is None
        buffer = f"{values} + {it.places[0]}" if direct else self.c.room(_CTYPES[it.native.code], len(it.buffer))
        low, beyond = it.native.bounds
        entries = {
            "function": f"{{.two = ({_EXCHANGE}){self.code[block]}_{it.name}}}",
            "references": self.c.array("uint32_t", it.references.tolist()),
            "values": values,
            "places": "NULL" if direct else self.c.array("int64_t", (it.places if places is None else places).tolist()),
            "slots": self.c.array("int64_t", it.slots.tolist()),
            "buffer": buffer,
            "low": low,
            "beyond": beyond,
            "live": listed(it.live),
            "all": listed(it.all),
            "type": CODES.index(it.native.code),
        }
        return fields(entries)

    def moves(self, verb: str, block: str, places: Mapping[Element, int], values: str) -> list[str]:
        """Returns exchanges of these elements of a block with their places among values."""
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
        self.c.define(f"static const Exchange setters_{index}", setters)
        self.c.define(f"static const Exchange getters_{index}", getters)
        factors, offsets = seat.inputs.factors, seat.inputs.offsets
        return fields(
            {
                "do_step": f"{{.two = {self.code[name]}_fmi2DoStep}}",
                "version": 2,
                "every": every,
                "step": every * self.plan.clock.numerator / self.plan.clock.denominator,
                "sources": self.c.array("int64_t", seat.inputs.sources.tolist()),
                "factors": self.c.array("double", () if factors is None else factors.tolist()),
                "offsets": self.c.array("double", () if offsets is None else offsets.tolist()),
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
        return listed([quoted(name), quoted(code), *(f"{code}_fmi2{function}" for function in functions)])

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
            moves += [listed([seat, it]) for it in self.moves("Set", block, numbers, "start_values")] if numbers else []
            if words:
                self.c.lines.append(
                    f"static const fmi2String text_{seat}[] = {listed(quoted(word) for _, word in words)};"
                )
                texts.append(
                    listed([seat, self.c.array("uint32_t", (r for r, _ in words)), len(words), f"text_{seat}"])
                )
        self.c.lines.append(f"double start_values[] = {{{', '.join(map(number, values)) or '0.0'}}};")
        self.c.define("const Move starts", moves)
        self.c.define("const Texts texts", texts)
        self.c.lines += [f"const size_t start_count = {len(moves)};", f"const size_t text_count = {len(texts)};"]
        return places, values

    def _levels(self) -> None:
        fed: dict[Node, list[str]] = {}
        targets: dict[Node, list[Node]] = {}
        for link in self.plan.wiring.links:
            for source, target in () if link.delayed else zip(link.source, link.target, strict=True):
                entry = [self.places[source], self.seats[target.block], self.place_of(target), link.factor, link.offset]
                fed.setdefault(source, []).append(listed(entry))
                targets.setdefault(source, []).append(target)
        levels = []
        for depth, level in enumerate(self.plan.order.levels):
            gets, sets = [], []
            taken: dict[str, dict[Element, int]] = {}
            given: dict[str, dict[Element, int]] = {}
            for node in level:
                if node in self.places:
                    taken.setdefault(node.block, {})[node.element] = self.places[node]
                for target in targets.get(node, ()):
                    given.setdefault(target.block, {})[target.element] = self.place_of(target)
            for block, places in taken.items():
                gets += [listed([self.seats[block], it]) for it in self.moves("Get", block, places, "bus")]
            for block, places in given.items():
                seat = self.seats[block]
                sets += [listed([seat, it]) for it in self.moves("Set", block, places, f"inputs_{seat}")]
            feeds = [feed for node in level for feed in fed.get(node, ())]
            self.c.define(f"static const Move gets_{depth}", gets)
            self.c.define(f"static const Feed feeds_{depth}", feeds)
            self.c.define(f"static const Move sets_{depth}", sets)
            names = f"gets_{depth}", len(gets), f"feeds_{depth}", len(feeds), f"sets_{depth}", len(sets)
            levels.append(listed(names))
        self.c.define("const Level levels", levels)
        self.c.lines.append(f"const size_t level_count = {len(levels)};")

    def place_of(self, node: Node) -> int:
        """Returns where an input lies among those of its seat."""
        return self.bus.seats[self.seats[node.block]].inputs.elements.index(node.element)
