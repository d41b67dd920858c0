"""What tests of a block behind our interface share: fits of models, and mocks behind an adapter."""

from __future__ import annotations

import numpy as np

from orchestration.fmu.interfaces import Interface
from orchestration.fmu.model import Element, Model
from orchestration.quantities import parse_unit
from orchestration.scenario.mapping import Mapping
from orchestration.swap.adapter import Adapter
from orchestration.swap.as_ours import model
from orchestration.swap.fit import fit

from ..mocks import Mock


def reference(kind: Model, starts=None) -> Interface:
    return Interface(kind.name, kind, starts or {e: 0.0 for v in kind.of("input", "parameter") for e in v.elements})


def fitted(ours: Model, theirs: Model, **mapping):
    return fit(reference(ours), theirs, Mapping.model_validate(mapping))


def echo(name: str, kind: Model, pairs: dict[str, str]) -> Mock:
    """A block whose outputs are its inputs, by name."""

    def evaluate(block: Mock) -> None:
        for output, given in pairs.items():
            for position in range(kind.variables[output].size):
                block.values[Element(output, position)] = block.values[Element(given, position)]

    return Mock(name, kind, evaluate)


def through(found, theirs: Mock, **inputs):
    """What ours are given comes back: sets inputs by name before the first step, and in it."""
    assert not found.errors, [str(f) for f in found.errors]
    adapter = Adapter(theirs, found)
    adapter.enter(1.0)
    kind = model(found)
    fed = [e for name in inputs for e in kind.variables[name].elements]
    given = [e for v in kind.of("output") for e in v.elements]
    values = [x for value in inputs.values() for x in np.ravel(value).tolist()]
    adapter.set(zip(fed, values, strict=True))
    first = adapter.get(given)
    into = np.zeros(len(given))
    buffer = adapter.wire(fed, given, [len(given), 0, 0, 0], into)
    adapter.leave()
    buffer[:] = values
    adapter.set_inputs()
    adapter.do_step(0.0, 0.1)
    adapter.get_live()
    np.testing.assert_allclose(into, first, rtol=1e-14, atol=1e-300)
    return dict(zip((f"{e.variable}[{e.position}]" for e in given), into, strict=True))


def unit(name: str):
    return parse_unit(name)
