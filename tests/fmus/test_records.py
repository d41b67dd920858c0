"""The dataclasses of every Python block are those of its interface; what it gives fits the ports, and so must what it
takes."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from fmus.build import blocks_of
from fmus.interface import load
from tests.blocks import inputs, module, parameters

BLOCKS = blocks_of("python")


@pytest.mark.parametrize("block", BLOCKS)
def test_fields_are_those_of_the_interface(block: str) -> None:
    for record, causality in (("Parameters", "parameter"), ("Inputs", "input"), ("Outputs", "output")):
        names = [f.name for f in fields(getattr(module(block), record))]
        expected = [v.name for v in load(block).of(causality)]
        if load(block).sets:  # what only a set of parts has stands at the end, with a value of its own
            own = [n for n in names if hasattr(getattr(module(block), record), n)]
            assert names[len(names) - len(own) :] == own
            expected = [n for n in expected if n not in own] + own
        assert names == expected


@pytest.mark.parametrize("block", BLOCKS)
def test_outputs_have_the_shapes_of_the_interface(block: str) -> None:
    p, u, python = parameters(block), inputs(block), module(block)
    y = python.outputs(python.start(p, u), u, p)
    for variable in load(block).of("output"):
        value = getattr(y, variable.name)
        assert np.shape(value) == variable.shape
        assert variable.type != "boolean" or np.asarray(value).dtype == np.bool_
        assert isinstance(value, str) or np.isfinite(value).all()


@pytest.mark.parametrize("block", [block for block in BLOCKS if not block.startswith("plant")])
def test_inputs_that_are_not_finite_are_refused_by_name(block: str) -> None:
    """Those of flight software; what the plant is given the FMI shell refuses. An infinite optional input may be one
    that is not connected."""
    p, u, python = parameters(block), inputs(block), module(block)
    x = python.start(p, u)
    for variable in (v for v in load(block).of("input") if v.type == "real"):
        for index in np.ndindex(variable.shape):
            for bad in (math.nan,) if variable.optional else (math.nan, math.inf, -math.inf):
                value = np.array(getattr(u, variable.name))
                value[index] = bad
                given = replace(u, **{variable.name: value if value.shape else float(value)})
                expected = "expected" if variable.optional else f"^{variable.name}.*: expected"
                with pytest.raises(ValueError, match=expected):
                    python.outputs(x, given, p)
                with pytest.raises(ValueError, match=expected):
                    python.start(p, given)
