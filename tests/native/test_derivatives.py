"""Directional and adjoint derivatives of FMUs of FMI 3.0, by FMPy: against differences of the outputs, Euler's theorem
of homogeneous functions, and each other."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Sequence
from ctypes import c_double, c_uint32
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from lxml import etree
from numpy.typing import NDArray

from fmus.interface import BLOCKS, load
from tests.blocks import some
from tests.fmus.carried_data import rows
from tests.native.test_fmi3 import slave, three

Floats = NDArray[np.float64]
WITH = tuple(block for block in BLOCKS if load(block).derivatives)
STENCIL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
"""Of the central difference of order eight."""
ROW = 30
"""Of the reference data; with half of its demands nothing saturates, and no two rods give the same."""
DEMANDS = ("tau_cmd_B", "dipole_ff")


@pytest.fixture(params=some(WITH, "controller", "allocator"))
def flown(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[FMU3Slave]:
    """A block after one step, with the inputs of a row of its reference data."""
    it = slave(three(request.param), tmp_path / "it")
    it.block = load(request.param)
    it.enterInitializationMode()
    given = rows(tmp_path / "it", "inputs.csv", it.block)[ROW]
    it.values = {}
    for variable in it.block.of("input"):
        values = [given[e.name] for e in variable.elements]
        if variable.type == "real" and max(map(abs, values)) < 1e9:
            it.values[variable.name] = np.array(values) * (0.5 if variable.name in DEMANDS else 1.0)
            it.setFloat64([it.at[variable.name]], list(it.values[variable.name]))
    it.exitInitializationMode()
    it.doStep(0.0, 0.1)
    yield it
    it.freeInstance()


def derivative(it: FMU3Slave, unknowns: Sequence[str], knowns: Sequence[str], seed: Floats, adjoint: bool = False):
    call = it.fmi3GetAdjointDerivative if adjoint else it.fmi3GetDirectionalDerivative
    size = sum(len(it.block.variables[name].elements) for name in (knowns if adjoint else unknowns))
    of, by = ((c_uint32 * len(names))(*(it.at[name] for name in names)) for names in (unknowns, knowns))
    found = (c_double * size)()
    call(it.component, of, len(of), by, len(by), (c_double * len(seed))(*seed), len(seed), found, size)
    return np.array(found)


def _outputs(it: FMU3Slave, names: Sequence[str]) -> Floats:
    sizes = [len(it.block.variables[name].elements) for name in names]
    return np.array(it.getFloat64([it.at[name] for name in names], nValues=sum(sizes)))


def _real(it: FMU3Slave) -> list[str]:
    return [v.name for v in it.block.of("output") if v.type == "real"]


def test_the_derivative_along_each_input_is_that_of_the_outputs_to_1e_9(flown: FMU3Slave) -> None:
    """The largest error, relative to the largest element of an output and of its derivative along all elements of
    an input scaled by its size."""
    names, rng = _real(flown), np.random.default_rng(1)
    for known, at in flown.values.items():
        size = np.abs(at).max() or 1e-3
        step = 1e-5 if known.startswith("R_") else 5e-4  # a rotation stays one to the block's tolerance
        seed = size * rng.standard_normal(len(at))
        difference = np.zeros(len(_outputs(flown, names)))
        for k, weight in STENCIL.items():
            for sign in (1, -1):
                flown.setFloat64([flown.at[known]], list(at + sign * k * step * seed))
                difference += sign * weight * _outputs(flown, names) / step
        flown.setFloat64([flown.at[known]], list(at))
        found = derivative(flown, names, [known], seed)
        largest = np.abs(_outputs(flown, names)) + np.abs(found)
        sizes = [len(flown.block.variables[name].elements) for name in names]
        scale = np.concatenate(
            [np.full(n, part.max()) for n, part in zip(sizes, np.split(largest, np.cumsum(sizes)[:-1]), strict=True)]
        )
        assert np.all(np.abs(found - difference) <= 1e-9 * scale + 1e-14), known
        assert known in ("h_w", "v_N", "r_N") or np.abs(found).max() > 0.0, known


def test_the_adjoint_derivative_is_the_transpose(flown: FMU3Slave) -> None:
    names, knowns, rng = _real(flown), list(flown.values), np.random.default_rng(2)
    forward = rng.standard_normal(sum(map(len, flown.values.values())))
    backward = rng.standard_normal(len(_outputs(flown, names)))
    one = backward @ derivative(flown, names, knowns, forward)
    two = derivative(flown, names, knowns, backward, adjoint=True) @ forward
    assert np.isclose(one, two, rtol=1e-11, atol=0.0)


def test_what_holds_between_its_own_instants_depends_on_nothing(tmp_path: Path) -> None:
    it = slave(three("allocator"), tmp_path / "it")
    it.block = load("allocator")
    it.setFloat64([it.at["sample_period"]], [1.0])
    it.enterInitializationMode()
    it.setFloat64([it.at["tau_cmd_B"]], [1e-4, 2e-4, -1e-4])
    it.exitInitializationMode()
    it.doStep(0.0, 0.1)
    assert not derivative(it, ["dipole_cmd"], ["tau_cmd_B"], np.ones(3)).any()
    for k in range(1, 10):
        it.doStep(0.1 * k, 0.1)
    assert derivative(it, ["dipole_cmd"], ["tau_cmd_B"], np.ones(3)).all()
    it.freeInstance()


def test_commands_are_linear_in_the_demand_and_of_degree_minus_one_in_the_field(tmp_path: Path) -> None:
    """Euler: the derivative along the argument itself is the degree times the value. In initialization mode, too."""
    it = slave(three("allocator"), tmp_path / "it")
    it.block = load("allocator")
    it.enterInitializationMode()
    tau, b = np.array([1e-4, 2e-4, -1e-4]), np.array([1e-5, 2e-5, 1.5e-5])
    it.setFloat64([it.at["tau_cmd_B"], it.at["b_B"], it.at["h_w"]], [*tau, *b, 0.0])
    dipole = _outputs(it, ["dipole_cmd"])
    assert np.abs(dipole).min() > 0.1
    np.testing.assert_allclose(derivative(it, ["dipole_cmd"], ["tau_cmd_B"], tau), dipole, rtol=1e-12)
    np.testing.assert_allclose(derivative(it, ["dipole_cmd"], ["b_B"], b), -dipole, rtol=1e-12)
    it.exitInitializationMode()
    it.doStep(0.0, 0.1)
    np.testing.assert_allclose(derivative(it, ["dipole_cmd"], ["tau_cmd_B"], tau), dipole, rtol=1e-12)
    with pytest.raises(FMICallException):
        derivative(it, ["tau_cmd_B"], ["b_B"], b)  # an input is no unknown
    with pytest.raises(FMICallException):
        derivative(it, ["dipole_cmd"], ["tau_residual_B"], b)  # and an output no known
    with pytest.raises(FMICallException):
        derivative(it, ["dipole_cmd"], ["b_B"], b[:2])
    it.freeInstance()


@pytest.mark.parametrize("block", some(BLOCKS, "controller", "plant"))
def test_the_description_promises_derivatives_where_there_are_some_and_nowhere_else(block: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(three(block)) as archive:
        promised = etree.fromstring(archive.read("modelDescription.xml")).find("CoSimulation").attrib
    flags = ("providesDirectionalDerivatives", "providesAdjointDerivatives")
    assert [promised.get(flag) for flag in flags] == [("true" if block in WITH else None)] * 2
    it = slave(three(block), tmp_path / "it")
    it.block = load(block)
    it.enterInitializationMode()
    known = next(v for v in it.block.of("input") if v.type == "real")
    ask = [_real(it)[0]], [known.name], np.ones(len(known.elements))
    if block in WITH:
        derivative(it, *ask)
    else:
        with pytest.raises(FMICallException):
            derivative(it, *ask)
    it.freeInstance()
