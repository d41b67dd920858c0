"""The closed loop in C and in Python: the same to 1e-9 in every port over the whole run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus.build import FLAVOURS, ensure
from fmus.interface import load
from orchestration import load as load_scenario
from orchestration import run
from tests.blocks import inputs, module, parameters, some

from .drawn import plant_case
from .driver import ROOT, Instance
from .matrices import inertia

RELATIVE = 1e-9
WIRES = {
    "plant": {"dipole_cmd": "allocator", "wheel_torque_cmd": "allocator"},
    "controller": dict.fromkeys(("R_NB", "omega_B", "r_N", "v_N"), "plant"),
    "allocator": {"tau_cmd_B": "controller", "b_B": "plant", "omega_B": "plant", "h_w": "plant"},
}
ORDER = ("plant", "controller", "allocator")
LOOPS = {
    "the paper's blocks": {role: role for role in ORDER},
    "the bounded allocator": {role: role for role in ORDER} | {"allocator": "allocator_bounded"},
}
"""Which block stands in each place."""
SIZED_BY = {("allocator", "tau_residual_B"): ("controller", "tau_cmd_B")}
"""The residual is the demand less what is given: rounding of the demand where all of it is given."""


def scenario(rng: np.random.Generator, blocks: dict[str, str]) -> dict[str, Any]:
    """Parameters of a random satellite, its law and its allocation, per unit of mass so that the rods suffice."""
    J = 0.02 * inertia(rng)
    plant, _ = plant_case(rng)
    known = load("plant").variables  # a set of wheels has more
    plant = parameters(
        "plant",
        **{name: value for name, value in vars(plant).items() if name in known}
        | {"J_B": J, "J_error_B": 0.01 * J, "drag_factor": 0.02 * plant.drag_factor},
    )
    L0 = 0.02 * np.diag(rng.uniform(0.8, 1.0, 3))
    controller = parameters(
        "controller",
        J_B=J,
        K0=0.013 * np.array((0.9, 1.0, 1.1)),
        L0=L0,
        phi=str(rng.choice(["linear", "logarithm", "square_root"])),
        phi_scale=0.01,
        gain_schedule=str(rng.choice(["error", "constant"])),
        reference=str(rng.choice(["lvlh", "inertial", "rate"])),
        Omega_d0=rng.normal(scale=2e-3, size=3),
        compensate_gravity=bool(rng.integers(2)),
    )
    own = {"hold_fraction": rng.uniform(0.5, 1.0)} if blocks["allocator"] == "allocator" else {}
    allocator = parameters(blocks["allocator"], rod_axes=plant.rod_axes, **own)
    return {"plant": plant, "controller": controller, "allocator": allocator}


def python_run(blocks: dict[str, str], chosen: dict[str, Any], steps: int, h: float) -> list[dict[str, Any]]:
    """Every block's outputs at every step: the plant first, then the laws with what it gave."""
    states, given = {}, {}
    for role, block in blocks.items():
        u = _inputs(role, block, given) if role != "plant" else inputs("plant")
        states[role] = module(block).start(chosen[role], u)
        given[role] = module(block).outputs(states[role], u, chosen[role])
    record = [dict(given)]
    for _ in range(steps):
        for role, block in blocks.items():
            u = _inputs(role, block, given)
            states[role], given[role] = module(block).step(states[role], u, chosen[role], h)
        record.append(dict(given))
    return record


def _inputs(role: str, block: str, given: dict[str, Any]) -> Any:
    return inputs(block, **{name: getattr(given[source], name) for name, source in WIRES[role].items()})


def native_run(blocks: dict[str, str], chosen: dict[str, Any], steps: int, h: float) -> list[dict[str, dict[str, Any]]]:
    """The same with the libraries' C interface."""
    instances = {role: Instance(block) for role, block in blocks.items()}
    given: dict[str, dict[str, Any]] = {}
    for role, it in instances.items():
        it.set_all(chosen[role])
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        for name, source in WIRES[role].items() if role != "plant" else ():
            it.set(name, given[source][name])
        given[role] = it.outputs()
    for it in instances.values():
        it.call("ExitInitializationMode")
    record = [dict(given)]
    for i in range(steps):
        for role, it in instances.items():
            for name, source in WIRES[role].items():
                it.set(name, given[source][name])
            it.step(i * h, h)
            given[role] = it.outputs()
        record.append(dict(given))
    for it in instances.values():
        it.free()
    return record


@pytest.mark.parametrize("seed", some(range(20), *range(5)))
@pytest.mark.parametrize("blocks", LOOPS.values(), ids=LOOPS)
def test_twenty_random_loops_agree_in_every_port(blocks: dict[str, str], seed: int) -> None:
    """Over 30 s: the options and wires of twenty satellites. How rounding grows over thousands of steps is told
    below."""
    chosen = scenario(np.random.default_rng(1000 + seed), blocks)
    steps, h = 150, 0.2
    python, c = python_run(blocks, chosen, steps, h), native_run(blocks, chosen, steps, h)
    for role, block in blocks.items():
        for variable in load(block).of("output"):
            expected = np.array([np.ravel(getattr(y[role], variable.name)) for y in python], dtype=float)
            found = np.array([np.ravel(y[role][variable.name]) for y in c], dtype=float)
            # Relative to the port's size over the run: an output may pass through zero.
            source, name = SIZED_BY.get((role, variable.name), (role, variable.name))
            size = max(np.linalg.norm(getattr(y[source], name)) for y in python)
            assert np.abs(found - expected).max() <= RELATIVE * size, f"{block}.{variable.name}"


@pytest.fixture(scope="module")
def fmus() -> dict[str, dict[str, Path]]:
    return {flavour: {block: ensure(block, flavour) for block in ORDER} for flavour in FLAVOURS}


@pytest.mark.parametrize("name", some(["paper_no_singularity", "paper_singularity"], "paper_singularity"))
@pytest.mark.thorough
def test_the_papers_manoeuvres_agree_in_every_port(name: str, fmus: dict[str, dict[str, Path]]) -> None:
    source = load_scenario(ROOT / "scenarios" / f"{name}.yaml").source
    results = {}
    for flavour in ("python", "native"):
        for block in ORDER:
            source = source.with_entry(("blocks", block, "fmu"), str(fmus[flavour][block]))
        results[flavour] = run(load_scenario(source))
    python, c = results["python"], results["native"]
    assert np.array_equal(python.time, c.time)
    for block in ORDER:
        for variable in load(block).of("output"):
            signal = f"{block}.{variable.name}"
            expected, found = np.asarray(python[signal], float), np.asarray(c[signal], float)
            sizing = np.asarray(python[".".join(SIZED_BY.get((block, variable.name), (block, variable.name)))], float)
            size = np.sqrt((sizing.reshape(len(sizing), -1) ** 2).sum(axis=1)).max()
            assert np.abs(found - expected).max() <= RELATIVE * size, signal
    assert np.abs(np.asarray(c["plant.R_NB"]) - np.asarray(python["plant.R_NB"])).max() <= 1e-9
