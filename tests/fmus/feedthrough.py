"""Which inputs each output follows at once: every input is moved after a step, and every output is read."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException
from scipy.spatial.transform import Rotation

from fmus.interface import Interface, load
from tests.blocks import PYRAMID

from .host import Host

ROUNDING = 1e-11
"""Of an output's size at this point, and of all its elements' largest."""
STEPS = {"controller_planned": 80}
FULL = np.array([[2.13, 0.1, 0.2], [0.1, 3.04, 0.3], [0.2, 0.3, 3.09]])
R_N, V_N = np.array([6971000.0, 0.0, 0.0]), np.array([0.0, -1052.3891, 7488.1109])


def settings(block: str) -> Iterator[dict[str, Any]]:
    """Parameters under which different branches of the block's law act."""
    rod_axes = Rotation.from_rotvec([0.3, 0.5, 0.7]).as_matrix()
    choices: dict[str, dict[str, tuple[Any, ...]]] = {
        "controller": {
            "reference": ("lvlh", "inertial", "rate"),
            "J_B": (FULL,),
            "gain_schedule": ("error", "constant"),
            "phi": ("linear", "logarithm", "square_root"),
            "compensate_gravity": (False, True),
        },
        "controller_planned": {
            "reference": ("lvlh", "inertial"),
            "control_period": (0.1,),
            "J_B": (FULL,),
            "L0": (0.02 * FULL,),
            "rod_axes": (rod_axes,),
            "find_failures": (False,),  # a field drawn at random has failed
        },
        "estimator": {
            "rate_source": ("gyro", "dynamics"),
            "gate": (1e12,),
            "field_degree": (2,),
            "epoch": ("2009-02-10T00:00:00Z",),  # the Sun is seen from R_N
            "field_bias_sigma": (1e-6,),
            "rod_field": ((1e-8 * FULL).tolist(),),
            "boresight_B": (rod_axes[0].tolist(),),
        },
        "plant_judge": {"reference": ("lvlh", "inertial", "rate")},
        "plant": {
            "rod_axes": (rod_axes,),
            "h_w0": (0.0, 0.03),
            "rod_gain": ([0.9, 0.8, 0.7],),
            "residual_dipole_B": ([0.1, 0.2, 0.3],),
            "wheel_viscous_friction": (1e-6,),
        },
        "plant_wheels": {
            "wheels": (4,),
            "rod_axes": (rod_axes,),
            "h_w0": ([0.0] * 4, [0.03] * 4),
            "rod_gain": ([0.9, 0.8, 0.7],),
            "residual_dipole_B": ([0.1, 0.2, 0.3],),
            "wheel_viscous_friction": ([1e-6] * 4,),
        },
        "controller_wheels": {"wheels": (4,), "rod_axes": (rod_axes,)},
        "controller_planned_wheels": {
            "reference": ("lvlh", "inertial"),
            "wheels": (4,),
            "wheel_axis": (PYRAMID,),
            "J_B": (FULL,),
            "rod_axes": (rod_axes,),
            "R_d0": (rod_axes,),
            "dipole_max": (1e3,),  # the rods are not at their limits, where they give in proportion
        },
        "plant_sensors": {
            "attitude_noise": (0.0, 0.1),
            "sun_sensor": ("coarse", "fine"),
            "attitude_bias_B": ([0.1, 0.2, 0.3],),
            "attitude_rate_max": (0.5,),
            "attitude_sun_exclusion": (1.5,),
            "attitude_earth_exclusion": (0.2,),
            "rate_scale": ((0.01 * FULL).tolist(),),
            "field_noise": (1e-6,),
            "field_scale": ((0.01 * FULL).tolist(),),
            "field_rod_coupling": ((1e-7 * FULL).tolist(),),
            "sun_sensor_axes": (np.vstack((rod_axes, -rod_axes)).tolist(),),
            "albedo": (0.3,),
            "fine_sun_half_angle": (2.0,),
        },
        "supervisor": {
            "rate_time": (0.0,),
            "rate_acquire": (10.0,),
            "rate_lost": (10.0,),
            "target_yaw": ("steered", "free"),
        },
        "allocator": {"dipole_max": (25.0, 0.5), "rod_axes": (rod_axes,)},
        "allocator_bounded": {"dipole_max": (25.0, 0.5), "rod_axes": (rod_axes,)},
        "allocator_bounded_wheels": {
            "wheels": (4,),
            "dipole_max": (25.0, 0.5),
            "rod_axes": (rod_axes,),
            "wheel_axis": (PYRAMID,),
        },
    }
    choices["estimator_wheels"] = {**choices["estimator"], "wheels": (4,), "wheel_axis": (PYRAMID,)}
    choices["plant_sensors_wheels"] = choices["plant_sensors"]
    names = choices.get(block, {})
    for values in itertools.product(*names.values()):
        yield dict(zip(names, values, strict=True))


def inputs(interface: Interface, rng: np.random.Generator, kind: int) -> dict[str, Any]:
    """Inputs that a flight may have; of the optional ones all, none or some by `kind`."""
    rate = rng.choice([1e-4, 1e-2, 1e-1])
    sizes: dict[str, Any] = {
        "R_NB": Rotation.random(random_state=rng).as_matrix(),
        "omega_B": rate * rng.normal(size=3),
        "r_N": R_N * rng.uniform(0.98, 1.02) + 1e5 * rng.normal(size=3),
        "v_N": V_N * rng.uniform(0.98, 1.02) + 50.0 * rng.normal(size=3),
        "h_w": 1e-2 * rng.normal(),
        "b_B": 2e-5 * rng.normal(size=3),
        "attitude_sigma_B": [1e-3, 5e-4, 2e-3],
        "rate_health": 1,
        "field_health": 1,
        "u_applied": [*(0.1 * rng.normal(size=3)), 1e-5 * rng.normal()],
        "tau_cmd_B": rng.choice([1e-5, 1e-3]) * rng.normal(size=3),
        "dipole_ff": 3.0 * rng.normal(size=3),
        "wheel_torque_ff": 1e-4 * rng.normal(),
        "rod_gains": [1.1, 0.9, -1.0],
        "wheel_gains": 0.9,
        "wheel_failed": [False] * 4,
        "h_w_failed": [False] * 4,
        "dipole_cmd": 20.0 * rng.normal(size=3),
        "wheel_torque_cmd": 3e-3 * rng.normal(),
        "R_d": Rotation.random(random_state=rng).as_matrix(),
        "Omega_d": 1e-2 * rng.normal(size=3),
        "R_ref": Rotation.random(random_state=rng).as_matrix() * (kind not in (1, 2)),  # without one rates are damped
        "Omega_ref": 1e-2 * rng.normal(size=3),
        "dOmega_ref": 1e-4 * rng.normal(size=3),
        "t_ahead": np.linspace(50.0, 800.0, 16),
        "turn_ahead": np.outer(np.linspace(0.1, 1.0, 16), [0.3, -0.2, 0.1]),
        "Omega_ahead": np.full((16, 3), 1e-3),
        "attitude_valid": True,
        "attitude_bound": 0.1,
        "command": (0, 3, 4, 6, 7)[kind % 5],
        "R_goal": Rotation.random(random_state=rng).as_matrix(),
        "target_latitude": rng.uniform(-1.0, 1.0),
        "target_longitude": rng.uniform(-3.0, 3.0),
        "target_height": rng.uniform(0.0, 1e3),
        "sun_N": [0.6, -0.48, 0.64],
        "sun_B": [0.3, -0.5, 0.8],
        "sunlight": 1.0,
        "dipole_applied": [0.04, -0.1, 0.07],
    }
    needed: dict[str, Any] = {}
    if interface.code == "plant_sensors":  # the parameters of `settings` need these inputs
        needed = {"sun_N": rng.normal(size=3) / 2.0, "dipole": 20.0 * rng.normal(size=3)}
        sizes |= {**needed, "sunlight": rng.choice([0.3, 0.7, 1.0])}
    if interface.name == "controller_planned_wheels" and kind == 0 and rng.uniform() < 0.7:  # it has a plan there
        near = Rotation.from_rotvec(rng.uniform(-0.5, 0.5, size=3)).as_matrix()
        sizes |= {"R_ref": sizes["R_NB"] @ near, "Omega_ref": near.T @ sizes["omega_B"], "h_w": 0.0}
    if interface.code == "estimator":
        sizes |= {f"{name}_measured": sizes[name] for name in ("omega_B", "b_B", "r_N", "v_N", "R_NB")}
        sizes |= {f"{name}_sample": -1 for name in ("rate", "field", "attitude", "orbit", "sun")}
        sizes |= {"sun_B_measured": rng.normal(size=3), "dipole": 3.0 * rng.normal(size=3)}
        sizes |= {"wheel_torque": 1e-4 * rng.normal(), "sun_sensors": np.full(6, 0.5)}
    for variable in interface.of("input"):
        if len(variable.shape) == 1 and np.ndim(sizes.get(variable.name, [])) == 0:  # a set of wheels: each its own
            sizes[variable.name] = sizes[variable.name] * rng.uniform(-1.5, 1.5, size=variable.shape)
    given = {v.name: sizes[v.name] for v in interface.of("input")}
    for bit, name in enumerate(v.name for v in interface.of("input") if v.optional):
        if kind >> bit & 1 and interface.name != "supervisor":  # whose modes need their set-points
            del given[name]
    reference, ahead = ("R_ref", "Omega_ref", "dOmega_ref"), ("t_ahead", "turn_ahead", "Omega_ahead")
    for group, needs in ((("R_d", "Omega_d"),) * 2, (reference,) * 2, (ahead, (*reference, *ahead))):
        if not all(name in given for name in needs):
            given = {name: value for name, value in given.items() if name not in group}
    return given | needed


def moves(name: str, value: float) -> tuple[float, ...]:
    """What an element of an input is moved to: a little, and, where the block takes it, far."""
    if name in ("R_NB", "R_d", "R_ref", "R_NB_measured"):
        return (value + 3e-5, value - 3e-5)
    return (value * 1.01 + 1e-9, -value, 5.0 * value, 50.0 * value)


def _outputs(it: Host, names: list[str]) -> np.ndarray:
    return np.concatenate([np.ravel(it.get(name)).astype(float) for name in names])


def real_pairs(
    path: Path, block: str, points: int, seed: int = 1, parameters: Iterable[dict[str, Any]] = ()
) -> set[tuple[str, str]]:
    """(output element, input element) wherever an output was seen to follow an input after a step, with Get after Set.

    At so many points, under these parameters in turn, by default those of `settings`.
    """
    with Host(path) as host:
        return _real_pairs(host, block, points, seed, list(parameters) or list(settings(block)))


def _real_pairs(it: Host, block: str, points: int, seed: int, parameters: list[dict[str, Any]]) -> set[tuple[str, str]]:
    interface = load(block)
    names = [v.name for v in interface.of("output")]
    elements = [e.name for v in interface.of("output") for e in v.elements]
    sizes = [len(v.elements) for v in interface.of("output")]
    optional = sum(v.optional for v in interface.of("input"))
    rng = np.random.default_rng(seed)
    seen: set[tuple[str, str]] = set()
    for number, setting in zip(range(points), itertools.cycle(parameters), strict=False):
        given = inputs(interface, rng, number % (1 << optional))
        it.fmu.reset()
        it.started(**{name: _as_set(interface, name, value) for name, value in (setting | given).items()})
        it.step(0, count=STEPS.get(block, 3))
        base = _outputs(it, names)
        largest = np.repeat([np.abs(p).max() for p in np.split(base, np.cumsum(sizes)[:-1])], sizes)
        limit = ROUNDING * np.maximum(largest, 1e-12)
        for v in interface.of("input"):
            flat = np.ravel(given.get(v.name, [])).astype(float)
            if v.type != "real":  # looked at in doStep alone, or by test_no_attitude.py
                continue
            for i, moved in ((i, m) for i, value in enumerate(flat) for m in moves(v.name, value)):
                values = flat.copy()
                values[i] = moved
                try:
                    it.set(v.name, values.astype(int) if v.type == "integer" else values)
                    now = _outputs(it, names)
                except FMICallException:  # no rotation, say
                    continue
                seen |= {(elements[j], v.elements[i].name) for j in np.flatnonzero(np.abs(now - base) > limit)}
            if v.name in given:
                it.set(v.name, flat.astype(int) if v.type == "integer" else flat)
    return seen


def _as_set(interface: Interface, name: str, value: Any) -> Any:
    variable = interface.variables[name]
    return variable.items.index(value) + 1 if variable.type == "enumeration" else value


def declared_pairs(block: str) -> set[tuple[str, str]]:
    interface = load(block)
    return {
        (e.name, d.name)
        for v in interface.of("output")
        for i, e in enumerate(v.elements)
        for d in interface.feedthrough(v, i)
    }
