"""The power of rods and wheels in the hold, from the data that are given. Tests: tests/design/review/test_review.py."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .content import Section, Table
from .facts import Facts
from .flights import Flown
from .options import Options


def commands(facts: Facts) -> list[str]:
    """Returns the signal that commands the rods, and the wheels' torque and speed."""
    fed = {str(c.target).partition("[")[0]: str(c.source).partition("[")[0] for c in facts.scenario.connections}
    rods = fed.get(f"{facts.plant}.dipole_cmd")
    return [*([rods] if rods else []), f"{facts.plant}.wheel_torque", f"{facts.plant}.wheel_speed"]


def power(facts: Facts, options: Options, flown: Mapping[str, Flown]) -> Section:
    """Returns the mean and largest power of rods and wheels in the hold, from the data that are given."""
    given = options.power
    if "rod" not in given and "wheel" not in given:
        text = "No data of power are given: state 'power: {rod: 0.2 W, wheel: 0.3 W}' in the file of --requirements."
        return Section("Power", notes=[text])
    one, p = flown["failure-none"], facts.satellite.p
    signals = commands(facts)
    rows = []
    if "rod" in given and len(signals) == 3:
        duty = p.rod_duty if p.rod_period > 0.0 else 1.0
        dipoles = np.clip(one[signals[0]], -p.dipole_limit, p.dipole_limit) * p.rod_gain
        watts = duty * given["rod"] * ((dipoles / p.dipole_max) ** 2).sum(axis=1)
        rows.append(["rods", f"{watts.mean():.3g}", f"{watts.max():.3g}", f"{given['rod']:g} W of each at dipole_max"])
    if "wheel" in given and facts.wheels:
        torque, speed = (np.reshape(one[name], (len(one.time), -1))[:, facts.wheels] for name in signals[-2:])
        motor = np.abs(torque * speed).sum(axis=1) / given.get("efficiency", 1.0)
        turning = given["wheel"] * len(facts.wheels)
        data = f"{given['wheel']:g} W of each, and torque times speed over {given.get('efficiency', 1.0):g}"
        rows.append(["wheels", f"{turning + motor.mean():.3g}", f"{turning + motor.max():.3g}", data])
    note = "In the hold without failure. Braking gives nothing back. Rods: heat, by the square of the dipole."
    return Section("Power", [Table("Power of actuators", ["", "mean, W", "largest, W", "data"], rows, note)])
