"""Random parameters and inputs of each block, each of its options among them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.blocks import inputs, parameters

from .matrices import inertia, positive_definite, rotation, unit


def controller_case(rng: np.random.Generator, connected: bool = False) -> tuple[Any, Any]:
    angle = rng.choice([0.0, 1e-9, rng.uniform(0.0, math.pi), math.pi - 1e-9, math.pi])
    axis = unit(rng)
    r_N = unit(rng) * rng.uniform(6.6e6, 4e7)
    desired = rotation(rng)
    given = {
        "R_ref": desired * rng.choice([0.0, 1.0], p=[0.2, 0.8]),
        "Omega_ref": rng.normal(scale=0.1, size=3),
        "dOmega_ref": rng.normal(scale=0.01, size=3),
    }
    u = inputs(
        "controller",
        R_NB=(rng.choice([0.0, 1.0], p=[0.1, 0.9]) if connected else 1.0)
        * desired
        @ Rotation.from_rotvec(angle * axis).as_matrix(),
        omega_B=rng.normal(scale=0.1, size=3),
        r_N=r_N,
        v_N=rng.normal(scale=5e3, size=3),
        **(given if connected else {}),
    )
    p = parameters(
        "controller",
        J_B=inertia(rng),
        K0=np.sort(rng.uniform(0.1, 2.0, 3)),
        L0=positive_definite(rng),
        phi=str(rng.choice(["linear", "logarithm", "square_root"])),
        phi_scale=rng.uniform(0.01, 2.0),
        compensate_gravity=bool(rng.integers(2)),
        gain_schedule=str(rng.choice(["error", "constant"])),
        kappa0=rng.uniform(0.01, 1.0),
        lambda0=rng.uniform(0.01, 2.0),
        reference=str(rng.choice(["lvlh", "inertial", "rate"])),
        R_d0=rotation(rng) + rng.uniform(-1e-4, 1e-4, (3, 3)),
        Omega_d0=rng.normal(scale=0.1, size=3),
    )
    return p, u


def controller_with_reference_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Also with no attitude, and no reference, now and then."""
    return controller_case(rng, connected=True)


def allocator_case(rng: np.random.Generator) -> tuple[Any, Any]:
    u = inputs(
        "allocator",
        tau_cmd_B=rng.normal(scale=rng.choice([0.0, 1e-6, 1e-4, 1e-2]), size=3),
        b_B=rng.normal(scale=rng.choice([1e-13, 3e-5]), size=3)
        * rng.choice([[1, 1, 1], [0, 1, 1], [0, 0, 1], [1, 0, 0]]),
        omega_B=rng.normal(scale=rng.choice([0.0, 0.05]), size=3),
        h_w=rng.choice([0.0, rng.normal(scale=0.02)]),
    )
    axes = rng.normal(size=(3, 3))
    p = parameters(
        "allocator",
        rod_axes=axes / np.linalg.norm(axes, axis=1)[:, None],
        dipole_max=rng.uniform(1.0, 50.0),
        wheel_torque_max=rng.uniform(1e-3, 1e-2),
        hold_fraction=rng.uniform(0.3, 1.0),
    )
    return p, u


def allocator_bounded_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """From demands that are met to those many times too large, with and without feed-forward, in special fields too."""
    absent = {"dipole_ff": np.full(3, 1e9), "wheel_torque_ff": 1e9, "rod_gains": np.full(3, 1e9)}
    connected = {
        "dipole_ff": rng.normal(scale=15.0, size=3),
        "wheel_torque_ff": rng.normal(scale=1e-3),
        "rod_gains": rng.choice([0.0, -1.0, 0.9, 1.1], 3),
    }
    u = inputs(
        "allocator_bounded",
        tau_cmd_B=rng.normal(scale=rng.choice([0.0, 1e-6, 1e-4, 1e-3, 1e-2]), size=3),
        b_B=rng.normal(scale=rng.choice([1e-13, 3e-5], p=[0.1, 0.9]), size=3)
        * rng.choice([[1, 1, 1], [1, 1, 1], [0, 1, 1], [0, 0, 1], [1, 0, 0]]),
        omega_B=rng.normal(scale=rng.choice([0.0, 0.05]), size=3),
        h_w=rng.choice([0.0, rng.normal(scale=0.02), 0.03, -0.03, 0.05]),
        **{name: connected[name] if rng.integers(2) else absent[name] for name in absent},
    )
    axes = rng.normal(size=(3, 3))
    p = parameters(
        "allocator_bounded",
        rod_axes=axes / np.linalg.norm(axes, axis=1)[:, None],
        dipole_max=rng.uniform(1.0, 50.0),
        rod_limits=rng.choice([1.0, rng.uniform(0.01, 1.0)], 3),
        wheel_torque_max=rng.uniform(1e-3, 1e-2),
        command_period=rng.choice([0.1, 2.0, 20.0]),
        desaturation_time=rng.uniform(1.0, 300.0),
        rod_weight=10.0 ** rng.uniform(-7.0, -5.0),
        wheel_weight=rng.choice([0.0, 0.02, 0.3]),
        wheel_weight_ff=rng.uniform(0.0, 0.2),
    )
    return p, u


def allocator_bounded_wheels_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Up to three rods and none to four wheels, each with its own axis and limits, some beside their wanted momenta."""
    one, demand = allocator_bounded_case(rng)
    axes = rng.normal(size=(4, 3))
    own = {
        "J_B": inertia(np.random.default_rng(1)),
        "wheels": int(rng.integers(5)),
        "rods": int(rng.integers(4)),
        "wheel_axis": axes / np.linalg.norm(axes, axis=1, keepdims=True),
        "wheel_torque_max": rng.uniform(1e-3, 1e-2, 4),
        "wheel_momentum_max": rng.uniform(0.02, 0.05, 4),
        "wheel_momentum_target": rng.uniform(-0.02, 0.02, 4),
        "null_space_momentum": rng.choice([0.0, 5e-3, 1e-2]),
        "wheel_weight": rng.choice([1e-3, 0.02, 0.3]),
        "wheel_weight_ff": rng.uniform(1e-3, 0.2),
    }
    of_wheels = {
        "h_w": rng.choice([0.0, 1.0], 4) * rng.normal(scale=0.02, size=4),
        "wheel_torque_ff": rng.normal(scale=1e-3, size=4) if rng.integers(2) else np.full(4, 1e9),
        "wheel_gains": rng.choice([0.0, -1.0, 0.9, 1.0], 4) if rng.integers(2) else np.full(4, 1e9),
    }
    block = "allocator_bounded_wheels"
    return parameters(block, **{**vars(one), **own}), inputs(block, **{**vars(demand), **of_wheels})


def plant_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Full inertia, offsets, every option of the plant."""
    u = inputs("plant", dipole_cmd=rng.normal(scale=20.0, size=3), wheel_torque_cmd=rng.normal(scale=2e-3))
    axes = np.eye(3) + rng.normal(scale=0.3, size=(3, 3))
    J = inertia(rng) * rng.choice([1.0, 0.02])
    towards, along = Rotation.random(random_state=rng).as_matrix()[:2]
    q = rng.normal(size=4)
    model, year = [("igrf14", rng.integers(1900, 2030)), ("wmm2010", rng.integers(2010, 2015)), ("wmm2025", 2026)][
        rng.integers(3)
    ]
    month, day, hour, second = rng.integers(1, 13), rng.integers(1, 29), rng.integers(24), rng.uniform(0.0, 59.0)
    p = parameters(
        "plant",
        J_B=J,
        J_error_B=0.02 * J,
        wheel_inertia=1.47e-5,
        wheel_momentum_max=rng.choice([0.03, 1e-3]),
        wheel_viscous_friction=rng.choice([0.0, 1e-7, 2e-5]),  # the last decays in 0.7 s
        wheel_coulomb_friction=rng.choice([0.0, 1e-4]),
        rod_axes=axes / np.linalg.norm(axes, axis=1)[:, None],
        rod_limits=rng.choice([1.0, rng.uniform(0.01, 1.0)], 3),
        rod_gain=rng.uniform(0.0, 2.0, 3),
        rod_period=rng.choice([0.0, 0.07, 0.13, 0.2]),
        rod_duty=rng.choice([0.0, rng.uniform(), 0.5, 1.0]),
        residual_dipole_B=rng.normal(scale=0.05, size=3),
        disturbance_torque_B=rng.normal(scale=1e-6, size=3),
        orbit_start=str(rng.choice(["circular", "position_velocity"])),
        orbit_radius=rng.uniform(6.7e6, 7.8e6),
        inclination=rng.uniform(0.0, math.pi),
        node_longitude=rng.uniform(-6.0, 6.0),
        argument_of_latitude=rng.uniform(-6.0, 6.0),
        r_N0=towards * 7.2e6,
        v_N0=along * 7.44e3 * rng.uniform(0.99, 1.01) + towards * rng.uniform(-50.0, 50.0),
        j2_node_drift=bool(rng.integers(2)),
        epoch=f"{year:04d}-{month:02d}-{day:02d}T{hour:02d}:59:{second:09.6f}Z",
        gravity_gradient=bool(rng.integers(4)),
        drag=bool(rng.integers(4)),
        solar_pressure=bool(rng.integers(2)),
        solar_specular=rng.uniform(0.0, 0.5),
        solar_diffuse=rng.uniform(0.0, 0.5),
        drag_factor=rng.uniform(0.0, 5.0),
        body_axis=str(rng.choice(["x", "y", "z"])),
        center_of_mass_B=rng.uniform(-0.1, 0.1, 3),
        f107=rng.uniform(65.0, 250.0),
        f107_average=rng.uniform(65.0, 250.0),
        ap=rng.uniform(0.0, 200.0),
        field_model=model,
        field_degree=int(rng.integers(1, 14)),
        field_extrapolate=model != "igrf14",
        initial_attitude=str(rng.choice(["Q0", "q_NB0"])),
        Q0=rotation(rng) + rng.uniform(-1e-4, 1e-4, (3, 3)),
        q_NB0=q / np.linalg.norm(q),
        omega_B0=rng.normal(scale=0.05, size=3),
        h_w0=rng.uniform(-1e-3, 1e-3),
        integrator_order=int(rng.choice([2, 4, 6])),
        step_max=rng.choice([0.1, 0.03]),
    )
    return p, u


def plant_wheels_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """None to four wheels, each with its own axis, limits, frictions and drive."""
    body, commands = plant_case(rng)
    axes = rng.normal(size=(4, 3))
    limits = rng.choice([0.03, 1e-3], 4)
    own = {
        "wheels": int(rng.integers(5)),
        "wheel_axis": axes / np.linalg.norm(axes, axis=1, keepdims=True),
        "wheel_inertia": rng.uniform(1e-5, 1e-4, 4),
        "wheel_momentum_max": limits,
        "wheel_torque_max": rng.uniform(1e-3, 5e-3, 4),
        "wheel_viscous_friction": rng.choice([0.0, 1e-7, 2e-5], 4),
        "wheel_coulomb_friction": rng.choice([0.0, 1e-4], 4),
        "wheel_breakaway_friction": rng.choice([0.0, 3e-4, 1e-3], 4),
        "wheel_gain": rng.choice([1.0, 0.0, -1.0, 0.7], 4),
        "h_w0": rng.choice([0.0, 1.0], 4) * rng.uniform(-1e-3, 1e-3, 4),
        "wheel_static_imbalance": rng.choice([0.0, 1e-6], 4),
        "wheel_dynamic_imbalance": rng.choice([0.0, 1e-7], 4),
        "wheel_position_B": rng.uniform(-0.3, 0.3, (4, 3)),
    }
    p = parameters("plant_wheels", **{**vars(body), **own})
    return p, inputs("plant_wheels", dipole_cmd=commands.dipole_cmd, wheel_torque_cmd=rng.normal(scale=2e-3, size=4))


def plant_sensors_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Each error of each sensor off or on, in the light, the shadow and between them."""
    u = inputs(
        "plant_sensors",
        R_NB=rotation(rng),
        omega_B=rng.normal(scale=0.1, size=3),
        r_N=unit(rng) * 7e6,
        v_N=rng.normal(scale=5e3, size=3),
        b_B=rng.normal(scale=3e-5, size=3),
        h_w=rng.normal(scale=0.02),
        sun_N=unit(rng),
        sunlight=rng.choice([0.0, 0.4, 0.7, 1.0, 1e9]),
        dipole=rng.normal(scale=10.0, size=3),
    )
    scale = rng.choice([0.0, 1.0])

    def some(x: Any, off: Any = 0.0) -> Any:
        return x if rng.integers(2) else off

    rows = np.array([unit(rng) if i else some(unit(rng), np.zeros(3)) for i in range(6)])
    few = {
        name: some(rng.choice([0.03, 0.1, 0.25])) for name in ("attitude", "rate", "field", "orbit", "sun", "telemetry")
    }
    p = parameters(
        "plant_sensors",
        attitude_noise=scale * rng.choice([1e-9, 1e-4, 1.0]),
        attitude_bias_B=rng.normal(scale=rng.choice([0.0, 1e-9, 1e-3, 1.0]), size=3),
        rate_noise=scale * 1e-5,
        rate_bias_B=rng.normal(scale=1e-5, size=3),
        field_noise=scale * 5e-8,
        field_bias_B=rng.normal(scale=1e-7, size=3),
        wheel_momentum_noise=scale * 1e-5,
        position_noise=scale * 10.0,
        velocity_noise=scale * 0.01,
        sensor_period=rng.choice([0.0, 0.03, 0.1, 0.2, 0.25]),
        seed=int(rng.integers(2**31)),
        attitude_noise_about=some(1e-3),
        attitude_boresight_B=unit(rng),
        attitude_rate_max=some(0.15),
        attitude_sun_exclusion=some(rng.uniform(0.0, 2.0)),
        attitude_earth_exclusion=some(rng.uniform(0.0, 1.0)),
        attitude_outage_interval=some(0.3),
        attitude_outage_duration=rng.choice([0.1, 2.0]),
        angle_random_walk=some(1e-5),
        rate_random_walk=some(1e-5),
        rate_instability=some(1e-5),
        rate_instability_time=rng.choice([0.3, 100.0]),
        rate_scale=some(rng.normal(scale=0.01, size=(3, 3)), np.zeros((3, 3))),
        rate_range=some(0.1),
        rate_quantum=some(1e-4),
        field_scale=some(rng.normal(scale=0.01, size=(3, 3)), np.zeros((3, 3))),
        field_rod_coupling=some(rng.normal(scale=1e-7, size=(3, 3)), np.zeros((3, 3))),
        field_range=some(2e-5),
        field_quantum=some(1e-8),
        sun_sensor=str(rng.choice(["coarse", "fine"])),
        sun_sensor_axes=some(rows, np.vstack((np.eye(3), -np.eye(3)))),
        sun_sensor_half_angle=rng.uniform(0.5, 0.5 * math.pi),
        sun_sensor_noise=some(0.01),
        albedo=some(0.3),
        sun_threshold=0.2,
        fine_sun_axis_B=unit(rng),
        fine_sun_half_angle=rng.uniform(0.5, math.pi),
        fine_sun_noise=some(0.01),
        orbit_outage_interval=some(0.3),
        orbit_outage_duration=rng.choice([0.1, 2.0]),
        dipole_noise=some(0.01),
        **{f"{name}_period": value for name, value in few.items()},
    )
    return p, u


def plant_judge_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """To each reference; and, in a third of the cases, to one that is given by the inputs."""
    angle = rng.choice([0.0, 1e-9, rng.uniform(0.0, math.pi), math.pi - 1e-9, math.pi])
    desired = rotation(rng)
    given = {"R_d": desired, "Omega_d": rng.normal(scale=0.1, size=3)} if rng.integers(3) == 0 else {}
    u = inputs(
        "plant_judge",
        R_NB=desired @ Rotation.from_rotvec(angle * unit(rng)).as_matrix(),
        omega_B=rng.normal(scale=0.1, size=3),
        r_N=unit(rng) * rng.uniform(6.6e6, 4e7),
        v_N=rng.normal(scale=5e3, size=3),
        **given,
    )
    p = parameters(
        "plant_judge",
        reference=str(rng.choice(["lvlh", "inertial", "rate"])),
        R_d0=rotation(rng) + rng.uniform(-1e-4, 1e-4, (3, 3)),
        Omega_d0=rng.normal(scale=0.1, size=3),
    )
    return p, u


def estimator_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Directions of one attitude or of another, with and without each measurement, each option of the rate."""
    truth, other = Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix(), rotation(rng)
    R = other if rng.integers(4) == 0 else truth
    absent = {"dipole": np.full(3, 1e9), "h_w": 1e9, "wheel_torque": 1e9, "R_NB_measured": np.full((3, 3), 1e9)}
    connected = {
        "dipole": rng.normal(scale=5.0, size=3),
        "h_w": rng.normal(scale=0.01),
        "wheel_torque": rng.normal(scale=1e-3),
        "R_NB_measured": R @ Rotation.from_rotvec(rng.normal(scale=1e-4, size=3)).as_matrix(),
    }
    counts = {f"{name}_sample": int(rng.integers(-1, 3)) for name in ("rate", "field", "attitude", "orbit", "sun")}
    u = inputs(
        "estimator",
        omega_B_measured=rng.normal(scale=0.05, size=3),
        b_B_measured=R.T @ [2e-5, -1e-5, 3e-5] + rng.normal(scale=1e-7, size=3),
        r_N_measured=unit(rng) * 7e6 * rng.integers(2),
        v_N_measured=rng.normal(scale=5e3, size=3),
        sun_B_measured=R.T @ [-0.76, 0.6, 0.26] * rng.integers(2),
        sun_sensors=np.where(rng.integers(2, size=6), rng.uniform(size=6), 1e9),
        **{name: connected[name] if rng.integers(2) else absent[name] for name in absent},
        **counts,
    )
    boresight = unit(rng)
    source = str(rng.choice(["gyro", "dynamics"]))
    bank = source == "gyro" and bool(rng.integers(2))
    p = parameters(
        "estimator",
        rate_source=source,
        bank=bank,
        sun_sensor_axes=np.vstack((rotation(rng), rotation(rng) * rng.integers(2))),
        rate_bias_sigma=rng.uniform(1e-4, 1e-2),
        J_B=inertia(rng),
        rod_axes=rotation(rng),
        wheel_axis=unit(rng),
        field_noise=rng.choice([1e-7, 1e-5]),
        field_bias_sigma=rng.choice([0.0, 1e-6]),
        field_random_walk=rng.choice([0.0, 1e-9]),
        rod_field=rng.normal(scale=1e-7, size=(3, 3)),
        dipole_limit=rng.choice([5.0, 1e6]),
        sun_noise=rng.choice([1e-3, 0.1]),
        boresight_B=boresight,
        # A bank that takes every measurement of these has gyro scales of 28, with which rounding grows.
        gate=rng.choice([25.0, 1e3 if bank else 1e12]),
        orbit_time=rng.choice([0.0, 30.0]),
        j2=bool(rng.integers(2)),
        epoch="2013-06-21T06:30:00Z",
        field_model=str(rng.choice(["igrf14", "wmm2010"])),
        field_degree=int(rng.integers(1, 14)),
        field_error=rng.normal(scale=1e-7, size=3),
    )
    return p, u


def plant_sensors_wheels_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Each wheel with a momentum and a bias of its own."""
    one, truth = plant_sensors_case(rng)
    block, bias = "plant_sensors_wheels", rng.normal(scale=1e-4, size=4)
    p = parameters(block, **{**vars(one), "wheel_momentum_bias": bias})
    return p, inputs(block, **{**vars(truth), "h_w": rng.normal(scale=0.02, size=4)})


def estimator_wheels_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """None to four wheels, each with its own axis; their momenta and torques given or not."""
    one, measured = estimator_case(rng)
    block, axes = "estimator_wheels", rng.normal(size=(4, 3))
    own = {"wheels": int(rng.integers(5)), "wheel_axis": axes / np.linalg.norm(axes, axis=1, keepdims=True)}
    of_wheels = {
        "h_w": rng.normal(scale=0.01, size=4) if rng.integers(2) else np.full(4, 1e9),
        "wheel_torque": rng.normal(scale=1e-3, size=4) if rng.integers(2) else np.full(4, 1e9),
    }
    return parameters(block, **{**vars(one), **own}), inputs(block, **{**vars(measured), **of_wheels})


def supervisor_case(rng: np.random.Generator) -> tuple[Any, Any]:
    """Few parameters of time, so that five steps of 0.1 s see several modes."""
    goals = np.random.default_rng(rng.integers(2))  # one of two, so that it stays now and then
    attitude, goal = rotation(rng), rotation(goals)
    given = {
        "target_latitude": goals.uniform(-1.0, 1.0),
        "target_longitude": 1.0,
        "target_height": 500.0,
        "R_goal": goal,
        "sun_N": unit(rng),
        "sunlight": float(rng.integers(2)),
        "b_B": rng.normal(scale=2e-5, size=3) * rng.choice([0.0, 1.0], p=[0.2, 0.8]),
        "sun_B": rng.normal(size=3) * rng.choice([0.0, 1.0], p=[0.2, 0.8]),
    }
    u = inputs(
        "supervisor",
        R_NB=attitude * rng.choice([0.0, 1.0], p=[0.1, 0.9]),
        omega_B=rng.normal(scale=rng.choice([1e-4, 1e-2, 1e-1], p=[0.6, 0.3, 0.1]), size=3),
        r_N=unit(rng) * rng.uniform(6.6e6, 8e6),
        v_N=rng.normal(scale=5e3, size=3),
        attitude_valid=bool(rng.integers(8)),
        command=int(rng.choice([-1, 0, 1, 3, 4, 6, 7], p=[0.1, 0.1, 0.05, 0.2, 0.2, 0.2, 0.15])),
        **given,
    )
    p = parameters(
        "supervisor",
        J_B=inertia(rng),
        slew_rate_max=rng.choice([1e-3, 10.0]),
        slew_torque_max=rng.choice([1e-5, 1e3]),
        first_mode=str(rng.choice(["nadir", "inertial", "target", "sun"])),
        rate_time=rng.choice([0.0, 0.15]),
        settled_angle=rng.choice([1e-3, 4.0]),
        settled_rate=rng.choice([1e-3, 4.0]),
        settled_time=rng.choice([0.0, 0.15]),
        angle_lost=rng.choice([0.1, 4.0]),
        angle_time=rng.choice([0.0, 0.15]),
        attitude_time=rng.choice([0.0, 0.25]),
        target_yaw=str(rng.choice(["steered", "free"])),
        target_yaw_angle=rng.uniform(-3.0, 3.0),
        sun_axis_B=unit(rng),
        safe_pointing=str(rng.choice(["none", "field", "sun"])),
        safe_axis_B=unit(rng),
        safe_time=rng.choice([1.0, 100.0]),
        ahead_horizon=rng.choice([0.0, 100.0, 1500.0]),
    )
    return p, u


CASES = {
    "supervisor": supervisor_case,
    "controller": controller_case,
    "controller, given reference": controller_with_reference_case,
    "allocator": allocator_case,
    "allocator_bounded": allocator_bounded_case,
    "allocator_bounded_wheels": allocator_bounded_wheels_case,
    "plant": plant_case,
    "plant_wheels": plant_wheels_case,
    "plant_sensors": plant_sensors_case,
    "plant_judge": plant_judge_case,
    "estimator": estimator_case,
    "plant_sensors_wheels": plant_sensors_wheels_case,
    "estimator_wheels": estimator_wheels_case,
}
