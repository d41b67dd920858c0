"""Data, assumptions and disturbances of the 3U, against closed forms."""

import math

import numpy as np
import pytest

from design.review import facts as of
from design.review import inputs


def test_the_page_says_first_that_no_sensor_measures_attitude(facts):
    assert inputs.data(facts).notes[0] == "No sensor measures attitude: it is estimated from field, Sun and rates."


def test_perfect_sensors_are_named(four_wheels, tmp_path):
    file = tmp_path / "perfect.yaml"
    file.write_text(
        f"name: perfect\nextends: {four_wheels}\nblocks: {{sensors: {{start: {{attitude_rate_max: 0}}}}}}\n", "utf-8"
    )
    assert "PERFECT" in inputs.data(of.facts(file, None)).notes[0]
    assert inputs.data(of.facts(four_wheels, None)).notes[0] == (
        "Attitude is measured with a noise of 3.2 arcsec across its boresight and 16 arcsec about it, "
        "and an error of 17.32 arcsec that lasts, up to 0.5 deg/s."
    )


def test_sensors_have_the_units_of_their_data_sheets(facts):
    rows = dict(inputs.data(facts).tables[1].rows)
    assert rows["field_bias_B"] == "100, -150, 120 nT"
    assert rows["field_range"] == "800 uT"
    assert rows["sun_sensor"] == "coarse"
    assert rows["angle_random_walk"] == "0.014 deg"
    assert rows["rate_quantum"] == "0.0038 deg/s"
    assert rows["wheel_momentum_noise"] == "0.333 uN.m.s"
    assert rows["position_noise"] == "1.5 m"
    assert inputs.as_in_sheets(np.radians([10.0 / 3600.0]), "rad") == "10 arcsec"
    assert not any(text.endswith((" rad", " rad/s", " T")) for text in rows.values())


def test_assumptions_are_the_lines_of_the_files_that_say_so(facts):
    rows = inputs.assumptions(facts)
    assert any("residual_dipole_B" in text and place.startswith("satellite.yaml:") for place, text in rows)
    assert any(text.startswith("orbit_outage_interval: 1200 s") for _, text in rows)
    for name in ("center_of_mass_B", "f107", "disturbance_torque_B", "wheel_inertia"):  # defaults of new satellite
        assert any(text.startswith(f"{name}: ") for _, text in rows), name
    names = [text.partition(":")[0] for _, text in rows]
    assert "wheel_momentum_noise" in names  # of sensors.yaml, not that of the part that it extends
    assert len(names) == len(set(names))


def test_the_torque_of_the_residual_dipole_is_its_cross_product_with_the_field(facts):
    times, each, attitudes = inputs.torques(facts)
    p = facts.satellite.p
    for i in (0, 100):
        b_B = attitudes[i].T @ p.field.at(float(times[i]))
        assert each["residual dipole"][i] == pytest.approx(np.cross([3e-3, -3e-3, 3e-3], b_B), rel=1e-9)


def test_a_constant_torque_gathers_what_the_turning_body_leaves_of_it(satellite, tmp_path):
    file = tmp_path / "pushed.yaml"
    start = (
        "drag: false, solar_pressure: false, residual_dipole_B: [0, 0, 0], gravity_gradient: false, "
        "disturbance_torque_B: [1e-6, 0, 0]"
    )
    file.write_text(f"name: pushed\nextends: {satellite}\nblocks: {{plant: {{start: {{{start}}}}}}}\n", "utf-8")
    facts = of.facts(file, None)
    table, margins = inputs.disturbances(facts)[0].tables
    rows = {row[0]: row for row in table.rows}
    assert rows["constant"][1:4] == ["1000", "1000", "1000"]
    # In the plane of the orbit its direction turns once: at half of the orbit 2 tau T/(2 pi) has gathered.
    assert float(rows["constant"][5]) == pytest.approx(1e6 * 1e-6 * facts.period / math.pi, rel=0.01)
    assert float(margins.rows[1][3]) == pytest.approx(2e-3 / (1e-6 * facts.period / math.pi), rel=0.02)


def test_the_drawing_has_each_rod_and_wheel(facts, four_wheels):
    svg = inputs.data(of.facts(four_wheels, None)).drawing
    assert all(f">{name}</text>" in svg for name in ("x", "y", "z", "u1", "u2", "u3", "w1", "w4"))
    assert ">w2<" not in inputs.data(facts).drawing
