"""The closed loop of the blocks' own functions, one case at a time: the witness for the many at once."""

from __future__ import annotations

import math

import numpy as np

import allocator
import controller
import plant


def fly(loop, step, duration):
    """A list of (plant, controller, allocator) outputs at 0 and after each step; sequential exchange.

    The plant's are with the command that has just been given, which it is about to fly.
    """
    p, c, a = loop.plant, loop.controller, loop.allocator
    still = plant.Inputs(np.zeros(3), 0.0)
    x_p = plant.start(p, still)
    y_p = plant.outputs(x_p, still, p)
    u_c = controller.Inputs(y_p.R_NB, y_p.omega_B, y_p.r_N, y_p.v_N)
    x_c = controller.start(c, u_c)
    y_c = controller.outputs(x_c, u_c, c)
    u_a = allocator.Inputs(y_c.tau_cmd_B, y_p.b_B, y_p.omega_B, y_p.h_w)
    x_a = allocator.start(a, u_a)
    y_a = allocator.outputs(x_a, u_a, a)
    seen = [(plant.outputs(x_p, plant.Inputs(y_a.dipole_cmd, y_a.wheel_torque_cmd), p), y_c, y_a)]
    for _ in range(math.ceil(duration / step - 1e-9)):
        x_p, y_p = plant.step(x_p, plant.Inputs(y_a.dipole_cmd, y_a.wheel_torque_cmd), p, step)
        x_c, y_c = controller.step(x_c, controller.Inputs(y_p.R_NB, y_p.omega_B, y_p.r_N, y_p.v_N), c, step)
        x_a, y_a = allocator.step(x_a, allocator.Inputs(y_c.tau_cmd_B, y_p.b_B, y_p.omega_B, y_p.h_w), a, step)
        seen.append((plant.outputs(x_p, plant.Inputs(y_a.dipole_cmd, y_a.wheel_torque_cmd), p), y_c, y_a))
    return seen
