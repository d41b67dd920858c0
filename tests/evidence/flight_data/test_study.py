"""The study finds in a made record what was put into it: attitude, the error of the Sun sensors, and the shadow's
borders."""

import csv
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from evidence.flight_data.goals import goals
from evidence.flight_data.records import records
from evidence.flight_data.study import Edge, Shown, Sky, edges, pair, sky
from evidence.flight_data.synthetic import spinning
from inflight.attitude import Attitudes
from inflight.magnetometer import calibrate
from orchestration.errors import InputError
from tests.inflight.test_orbit import TLE


@pytest.fixture(scope="module")
def flown():
    """A record that enters the shadow, and its true attitudes as if a filter had found them."""
    flight, R, _, omega = spinning(3, 700, offset=700.0)
    n = len(R)
    found = Attitudes(R, np.tile(omega, (n, 1)), np.zeros(n), np.zeros(n), np.zeros(3), np.zeros(3), np.eye(6), 0.0)
    return flight, found


def test_true_attitudes_agree_with_the_sun_sensors_within_their_noise(flown):
    flight, found = flown
    seen = [s for s in (sky(flight, found)[0], pair(flight, found)) if s is not None]
    assert seen
    assert max(s.rms for s in seen) < 3.0


def test_a_turned_attitude_is_as_far_off_as_it_was_turned(flown):
    flight, found = flown
    c, s = np.cos(0.2), np.sin(0.2)
    turned = replace(found, R=found.R @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]))
    seen = [s for s in (sky(flight, turned)[0], pair(flight, turned)) if s is not None]
    assert max(s.rms for s in seen) > 5.0


def test_the_border_of_the_shadow_is_found_where_it_was_put(flown):
    flight, found = flown
    (edge,) = edges(flight, found)
    assert edge.entry
    assert abs(edge.late) < 0.5
    assert edge.late_air > 4.0  # air that the record does not have


def test_a_folder_of_records_is_read_whatever_their_names(tmp_path):
    (tmp_path / "elements.txt").write_text(TLE)
    header = "sheet,sat_index,unix_s,gyro_x,gyro_y,gyro_z,mag_x,mag_y,mag_z,sun2,sun3,sun4".split(",")
    with (tmp_path / "some.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for sheet in ("a", "b"):
            writer.writerows([sheet, i, 1693838903 + i, 1, 2, 3, 4, 5, 6, 7, 8, 9] for i in range(20))
    flights, short = records(tmp_path, 600.0)
    assert not flights
    assert [motion.name for motion in short] == ["a", "b"]
    np.testing.assert_allclose(np.degrees(short[0].omega[0]), [1, 2, 3])


RENAMED = """
time: {column: when, scale: UTC}
columns:
  omega_B_measured: {of: [wx, wy, wz], unit: rad/s}
  b_B_measured: {of: [bx, by, bz], unit: uT}
record: pass
"""


def test_parquet_with_other_columns_units_and_no_sun_sensors_is_read_by_columns_yaml(tmp_path):
    (tmp_path / "elements.txt").write_text(TLE)
    (tmp_path / "columns.yaml").write_text(RENAMED)
    n = 700
    rows = {name: np.sin(np.arange(n) + k) for k, name in enumerate(("wx", "wy", "wz", "bx", "by", "bz"))}
    table = pa.table({"pass": ["one"] * n, "when": np.arange(n) + 1693838903.0} | rows)
    parquet.write_table(table, tmp_path / "kept.parquet")
    (flight,), short = records(tmp_path, 600.0)
    assert (flight.name, flight.currents.shape) == ("one", (n, 0))
    assert not short
    np.testing.assert_allclose(flight.omega[:, 0], rows["wx"])
    np.testing.assert_allclose(flight.m[:, 2], 1e-6 * rows["bz"])


def test_a_layout_of_two_rates_is_refused_with_its_line(tmp_path):
    (tmp_path / "elements.txt").write_text(TLE)
    (tmp_path / "some.csv").write_text("t\n1\n")
    (tmp_path / "columns.yaml").write_text(RENAMED.replace("[wx, wy, wz]", "[wx, wy]"))
    with pytest.raises(InputError, match=r"columns.yaml:\d+: columns: expected omega_B_measured of 3 columns"):
        records(tmp_path, 600.0)


def test_goals_are_those_of_the_worst_record_and_of_attitudes_that_are_trusted(flown):
    flight, found = flown
    own = replace(calibrate(flight.t, flight.m, np.linalg.norm(flight.orbit.field_N(), axis=1)), rms=3e-7)
    bad = Sky(20.0, 20.0, 9, np.nan)
    met = Shown(flight, 0.0, own, 0.0, {}, found, 0.0, replace(bad, rms=3.0), None, [Edge(True, 0.0, 9.0, -1.9)])
    wrong = replace(met, sky=bad)
    doubted = replace(wrong, attitude=replace(found, strain=9.0))
    assert [line.rpartition(": ")[2] for line in goals([met, doubted], [None, None], None)] == [
        *("met", "met", "met", "these records do not show it", "met")
    ]
    missed = goals([met, wrong], [None, None], None)
    assert missed[1] == "goal: withheld sun sensors, deg rms: 20, at most 4: NOT MET"
    assert missed[4] == "goal: false convergences not reported: 1, at most 0: NOT MET"


def test_a_folder_without_records_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected .csv or .parquet files and a .txt file of element sets"):
        records(tmp_path, 600.0)
