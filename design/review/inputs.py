"""The first sections of a review: the satellite's data with every assumption, and what disturbs it over an orbit.

Tests: tests/design/review/test_inputs.py.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from fmus.interface import load as interface
from orchestration.quantities import convert, parse_unit
from plant.orbit import lvlh
from plant.so3 import Array

from ..plausible import findings
from ..sheet import prefixed
from . import studies
from .content import Curves, Section, Table, number
from .drawing import drawing
from .facts import Facts

SAMPLES, ROUNDING = 241, 1e-9
"""Of an orbit; share of the largest torque that is rounding."""
SHEET = {
    "rad": (("deg", 0.0099), ("arcsec", 0.0)),
    "rad/s": (("deg/s", 0.00099), ("deg/h", 0.0)),
    "T": (("uT", 99.0), ("nT", 0.0)),
    "T/(A.m2)": (("nT/(A.m2)", 0.0),),
    "N.m.s": (("mN.m.s", 0.099), ("uN.m.s", 0.0)),
}
"""Units of data sheets in the place of SI units: the first in which the largest value is so large."""
MODELS = [
    "Body: rigid; its surfaces are an octagonal cylinder. Flexible parts, fuel and moving panels are not modelled.",
    "Orbit: two bodies; air by NRLMSISE-00 at a constant flux of the Sun; field by the model that is named.",
    "Rods and wheels follow their commands without delay, within their limits.",
    "Errors keep the size that the file states. Directions of constant vectors, signs of matrices and the seed of the "
    "noise are drawn for each flight.",
]


def data(facts: Facts) -> Section:
    """Returns the satellite's data, what is assumed, and a drawing."""
    p, s = facts.satellite.p, facts.satellite
    shown = [
        ("scenario", str(facts.file)),
        ("mass", f"{s.mass:g} kg" if s.mass else "not stated: data: {mass: 4 kg} in the file, or --mass"),
        ("principal moments of inertia", _listed(np.asarray(np.linalg.eigvalsh(s.J)), "kg.m2")),
        ("moments of inertia about x, y, z", _listed(np.diag(s.J), "kg.m2")),
        ("elements xy, xz, yz of J_B", _listed(s.J[[0, 0, 1], [1, 2, 2]], "kg.m2")),
        ("error of the inertia that the flight software believes", f"{_share(p.J_error_B, p.J_B):.3g} % of it"),
        ("body", f"{1e3 * p.body_width:g} mm wide, {1e3 * p.body_length:g} mm long along {p.body_axis}"),
        ("centre of mass from the middle", _listed(1e3 * p.center_of_mass_B, "mm")),
        ("rods", f"{_listed(p.dipole_limit, 'A.m2')} at most"),
        *((f"rod {i} along", _listed(axis)) for i, axis in enumerate(p.rods_to_body.T, start=1)),
        ("orbit", f"{(p.orbit.semi_major_axis - 6378137.0) / 1e3:.1f} km high, inclined by "
                  f"{math.degrees(p.orbit.inclination):.2f} deg, period {facts.period:.1f} s"),
        ("epoch", p.epoch),
        ("field", p.field_model),
        ("air", f"drag coefficient {p.drag_coefficient:g}, F10.7 {p.f107:g}" if p.drag else "none: no drag"),
        ("sunlight", f"{p.solar_specular:g} mirrored, {p.solar_diffuse:g} diffuse" if p.solar_pressure else "none"),
        ("residual dipole", _listed(p.residual_dipole_B, "A.m2")),
        ("constant torque", _listed(p.disturbance_torque_B, "N.m")),
        ("goal of the hold", f"{math.degrees(facts.goal):g} deg"),
        ("flight software", ", ".join(k for k in facts.blocks if not k.startswith(("plant", "estimate_")))),
    ]  # fmt: skip
    for i, (wheel, axis) in enumerate(zip(p.wheel_list, p.wheel_axes, strict=True), start=1):
        if wheel.momentum_max > 1e-8:
            told = f"{prefixed(wheel.momentum_max, 'N.m.s')}, {prefixed(wheel.torque_max, 'N.m')}"
            shown.append((f"wheel {i}", f"{told}, along {_listed(axis)}"))
    sensors = [
        [name, _item(name, values) or as_in_sheets(values, _unit(name))]
        for name, values in sorted(facts.starts.get("plant_sensors", {}).items())
        if values.any() and (studies.aboard(facts, "star tracker") or not name.startswith("attitude_"))
    ]
    tables = [
        Table("Data of the satellite", ["", "value"], [list(row) for row in shown]),
        Table("Sensors", ["", "value"], sensors, "What is not zero of them, in units of data sheets."),
        Table("Assumptions", ["where", "what"], assumptions(facts), "Lines of the files that say 'assumed'."),
        Table(
            "Plausibility",
            ["finding", "expected", "remedy"],
            [[one.what, one.bound, one.remedy] for one in findings(facts.scenario, s.mass)],
        ),
    ]
    notes = list(MODELS)
    if not facts.starts.get("plant_sensors"):
        notes.insert(0, "THERE ARE NO SENSORS: the flight software is given the truth.")
    elif facts.size("plant_sensors", "attitude_noise") and "star tracker" in studies.contributors(facts):
        notes.insert(0, _measured(facts))
    else:
        notes.insert(0, "No sensor measures attitude: it is estimated from field, Sun and rates.")
    return Section("Satellite", tables, notes=notes, drawing=drawing(p))


def _measured(facts: Facts) -> str:
    """Says how well the attitude is measured: noise across the boresight and about it, what lasts, and the rate."""
    across, about, lasting, rate = (
        facts.size("plant_sensors", f"attitude_{name}") for name in ("noise", "noise_about", "bias_B", "rate_max")
    )
    told = f"with a noise of {_angle(across)}"
    told += f" across its boresight and {_angle(about)} about it" if about else ""
    told += f", and an error of {_angle(lasting)} that lasts" if lasting else ""
    limit = "at any rate: no star tracker does this; these are PERFECT sensors"
    return f"Attitude is measured {told}, {f'up to {math.degrees(rate):.3g} deg/s' if rate else limit}."


def _angle(size: float) -> str:
    return as_in_sheets(np.array([size]), "rad")


def assumptions(facts: Facts) -> list[list[str]]:
    """Returns places and texts of the lines that say what is assumed, in the files that the scenario is made of, but
    for those in whose place another file or an option has a value."""
    source = facts.scenario.source
    files = sorted({source.file or "", *source.files.values()} - {""})
    stated = {
        (source.files.get(key, source.file), line) for key, line in source.lines.items() if key not in source.options
    }
    rows = []
    for file in files:
        for i, line in enumerate(Path(file).read_text("utf-8").splitlines(), start=1):
            value, _, comment = line.partition("#")
            if "assumed" in comment and (file, i) in stated:
                rows.append([f"{Path(file).name}:{i}", f"{' '.join(value.split())}: {comment.strip()}"])
    return rows


def torques(facts: Facts) -> tuple[Array, dict[str, Array], Array]:
    """Returns times (n,) s over an orbit, by cause torques (n, 3) N m in the body at the held attitude, and the
    attitudes (n, 3, 3), N from B.
    """
    p = facts.satellite.p
    times = np.linspace(0.0, facts.period, SAMPLES)
    around = p.environment
    found: dict[str, list[Array]] = {name: [] for name in ("gravity gradient", "drag", "sunlight", "residual dipole")}
    attitudes = []
    for t in times.tolist():
        R = lvlh(*around.orbit.position_velocity(t)) @ facts.R_d0
        at = around.at(R, t)
        attitudes.append(R)
        found["gravity gradient"].append(at.tau_gg_B)
        found["drag"].append(at.tau_drag_B)
        found["sunlight"].append(np.zeros(3) if at.tau_solar_B is None else at.tau_solar_B)
        found["residual dipole"].append(np.cross(p.residual_dipole_B, at.b_B))
    arrays = {name: np.array(values) for name, values in found.items()}
    arrays["constant"] = np.tile(p.disturbance_torque_B, (SAMPLES, 1))
    return times, {name: values for name, values in arrays.items() if values.any()}, np.array(attitudes)


def disturbances(facts: Facts) -> tuple[Section, dict[str, float]]:
    """Returns torques by cause over an orbit, the momentum that gathers, and the margins of rods and wheels; also the
    least margins by metric, of which there are none where nothing disturbs."""
    p, s = facts.satellite.p, facts.satellite
    times, each, attitudes = torques(facts)
    step = float(times[1] - times[0])
    together = np.sum([*each.values(), np.zeros((SAMPLES, 3))], axis=0)
    bounds = s.disturbances()
    rows, gathered = [], {}
    largest = float(np.linalg.norm(together, axis=1).max())
    flat = [name for name, tau in each.items() if np.abs(tau).max() < ROUNDING * largest]
    for name, tau in {**each, "all together": together}.items():
        size = np.linalg.norm(tau, axis=1)
        if name in flat:
            size[:] = 0.0
        H = np.cumsum(np.einsum("nij,nj->ni", attitudes, tau), axis=0) * step
        gathered[name] = float(np.linalg.norm(H, axis=1).max())
        bound = bounds.get(name, sum(bounds.values()) if name == "all together" else 0.0)
        rows.append([name, *(number(1e9 * v) for v in (size.min(), size.mean(), size.max(), bound)),
                     number(0.0 if name in flat else 1e6 * gathered[name])])  # fmt: skip
    rods = s.rods * _share_on(facts)
    margins = [["rods, weakest field", prefixed(rods, "N.m"), prefixed(largest, "N.m"), _ratio(rods, largest)]]
    least = {"torque_margin": [(rods, largest)], "momentum_margin": list[tuple[float, float]]()}
    for i, wheel in enumerate(p.wheel_list, start=1):
        if wheel.momentum_max > 1e-8:
            least["momentum_margin"].append((wheel.momentum_max, gathered["all together"]))
            for what, gives, needed, unit in (
                ("momentum of an orbit", wheel.momentum_max, gathered["all together"], "N.m.s"),
                ("torque", wheel.torque_max, largest, "N.m"),
            ):
                told = [prefixed(value, unit) for value in (gives, needed)]
                margins.append([f"wheel {i}, {what}", *told, _ratio(gives, needed)])
    columns = ["cause", "least, nN.m", "mean, nN.m", "largest, nN.m", "bound at any attitude, nN.m", "gathered, uN.m.s"]
    note = (
        "At the attitude that is held. Gathered: the largest size of the integral in inertial axes, without unloading."
    )
    curves = {name: (1e9 * np.linalg.norm(tau, axis=1)).tolist() for name, tau in each.items() if name not in flat}
    section = Section(
        "Disturbances",
        [
            Table("Disturbance torques over an orbit", columns, rows, note),
            Table("Margins of rods and wheels", ["actuator", "gives", "needed", "factor"], margins),
        ],
        [Curves("Disturbance torques", (times / 60.0).tolist(), "time, min", "torque, nN.m", curves, log=True)],
    )
    factors = {name: [gives / needed for gives, needed in pairs if needed > 0.0] for name, pairs in least.items()}
    return section, {name: min(values) for name, values in factors.items() if values}


def _share_on(facts: Facts) -> float:
    """Returns what the flight software takes the rods to give, of what they give while they are on."""
    limit = np.array([facts.satellite.p.dipole_max])
    told = [
        facts.start(kind, "dipole_max", limit) for kind in facts.blocks if kind.startswith(("allocator", "controller"))
    ]
    return min(1.0, *(float(v.max() / limit[0]) for v in told)) if told and limit[0] > 0.0 else 1.0


def _unit(name: str) -> str:
    """Returns the unit of a parameter of the sensors; "" for none."""
    variable = interface("plant_sensors").variables.get(name)
    return "" if variable is None or variable.unit in (None, "1") else str(variable.unit)


def _item(name: str, values: Array) -> str:
    """Returns the item of an enumeration; "" of another parameter of the sensors."""
    variable = interface("plant_sensors").variables.get(name)
    return "" if variable is None or not variable.items else str(variable.items[int(values.flat[0]) - 1])


def as_in_sheets(values: Array, unit: str) -> str:
    """Returns values in SI units as a data sheet has them."""
    own = parse_unit(unit or "1")
    for name, least in SHEET.get(unit, ()):
        shown = np.array([convert(v, own, parse_unit(name)) for v in np.ravel(values).tolist()])
        if np.abs(shown).max() >= least:
            return _listed(shown, name)
    return _listed(values, unit)


def _ratio(gives: float, needed: float) -> str:
    return number(gives / needed) if needed > 0.0 else "–"


def _share(error: Array, whole: Array) -> float:
    return 100.0 * float(np.linalg.norm(error) / np.linalg.norm(whole))


def _listed(values: Array, unit: str = "") -> str:
    return f"{', '.join(f'{v:.4g}' for v in np.ravel(values))} {unit}".rstrip()
