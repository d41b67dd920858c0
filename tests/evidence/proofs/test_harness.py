"""The programs that Frama-C reads: every port and parameter is in them."""

from __future__ import annotations

import re

import pytest

from evidence.proofs.harness import TIME_MAX, harness, limits_of
from evidence.proofs.subjects import SUBJECTS
from fmus.interface import load
from fmus.native.generate import shape_in_c

BLOCKS = sorted({s.name for s in SUBJECTS if s.span})


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("span", ["any", "limits"])
def test_every_parameter_and_input_is_any_and_every_output_is_read(block, span):
    interface, text = load(block), harness(load(block), span)
    for causality, letter in (("parameter", "p"), ("input", "u"), ("output", "y")):
        for v in interface.of(causality):
            used = rf"{letter}->{v.name}" + r"\[[ijk]\]" * len(shape_in_c(interface, v))
            written = rf"{used} = (any|Frama_C)" if letter != "y" else rf"seen_\w+ = {used};"
            assert re.search(written, text) or f"Frama_C_make_unknown({letter}->{v.name}," in text, v.name


def test_loops_run_over_the_whole_array_of_each_port():
    text = " ".join(harness(load("allocator"), "any").split())
    outer, inner = (f"//@ loop unroll 3; for (int {i} = 0; {i} < 3; ++{i}) {{" for i in "ij")
    assert f"{outer} {inner} p->rod_axes[i][j] = any_real; }} }}" in text
    assert "u->h_w = any_real;" in text
    assert "seen_real = y->tau_residual_B[i];" in text


def test_with_limits_numbers_are_those_of_the_interface_and_a_flight_has_an_end():
    text = harness(load("allocator"), "limits")
    assert "p->hold_fraction = Frama_C_double_interval(1e-06, 1.0);" in text
    assert f"x->t <= {TIME_MAX!r}" in text
    assert "x->t <=" not in harness(load("allocator"), "any")


def test_an_optional_input_is_also_not_connected_and_below_that_where_it_is():
    variables = load("allocator_bounded").variables
    assert limits_of(variables["wheel_torque_ff"])[1] == 999e6
    text = harness(load("allocator_bounded"), "limits")
    assert "u->wheel_torque_ff[i] = 1e9;" in text
