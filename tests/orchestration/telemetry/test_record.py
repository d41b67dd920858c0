"""Records are read with their instants, gaps and missing values, and refused with line and column."""

from datetime import UTC, datetime

import numpy as np
import pytest
from astropy.time import Time

from orchestration.errors import InputError
from orchestration.scenario.telemetry import Telemetry
from orchestration.telemetry.record import Record
from orchestration.telemetry.times import instants

COLUMNS = {"w": {"of": ["x", "y"], "unit": "deg/s"}}


def read(tmp_path, text, name="log.csv", scale="elapsed", **more):
    path = tmp_path / name
    if text is not None:
        path.write_text(text, "utf-8")
    time = {"column": "t", "scale": scale, **more.pop("time", {})}
    record = Record(Telemetry.model_validate({"file": name, "time": time, "columns": COLUMNS, **more}), path, name)
    return record, np.concatenate(list(record.stream()))


def refused(tmp_path, text, **more):
    with pytest.raises(InputError) as error:
        read(tmp_path, text, **more)
    return str(error.value)


def test_rows_keep_their_own_instants_and_values_that_are_missing_are_nan(tmp_path):
    record, table = read(tmp_path, "# a comment\nt,x,y\n0,1,2\n0.7,,4\n5,5,6\n")
    np.testing.assert_array_equal(table, [[0, 1, 2], [0.7, np.nan, 4], [5, 5, 6]])
    assert record.seen.missing == {"w": 1}
    assert record.seen.gap == (4.3, 5)


@pytest.mark.parametrize("name", ["w_valid", "w_sample", "age"])
def test_a_port_with_the_name_of_one_that_a_record_has_already_is_refused(name):
    columns = {name: COLUMNS["w"], **COLUMNS}
    with pytest.raises(ValueError, match=f"found '{name}' twice"):
        Telemetry.model_validate({"file": "log.csv", "time": {"column": "t", "scale": "elapsed"}, "columns": columns})


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_cells_may_be_parted_by_semicolons_or_tabs_and_lines_end_as_on_windows(tmp_path, delimiter):
    text = "\ufeff# made; elsewhere\r\nt,x,y\r\n0,1,2\r\n1,3,4\r\n".replace(",", delimiter)
    np.testing.assert_array_equal(read(tmp_path, text)[1], [[0, 1, 2], [1, 3, 4]])


def test_what_is_beyond_the_largest_number_is_missing(tmp_path):
    record, table = read(tmp_path, "t,x,y\n0,1e999,2\n1,3,-inf\n2,1,1\n")
    assert np.isnan(table[0, 1])
    assert np.isnan(table[1, 2])
    assert record.seen.missing == {"w": 2}


def test_a_quote_in_a_comment_hides_no_row_and_lines_keep_their_numbers(tmp_path):
    text = '#a,"b\nt,x,y\n0,1,2\n# of the second pass,"\n1,3,4\n#,"c"\n2,five,6\n'
    assert "log.csv:7: x: expected a number, found 'five'" in refused(tmp_path, text)
    np.testing.assert_array_equal(read(tmp_path, text.replace("five", "5"))[1], [[0, 1, 2], [1, 3, 4], [2, 5, 6]])


@pytest.mark.parametrize(("name", "shown"), [("log.csv", True), ("passwd", False), ("id.key", False)])
def test_columns_are_listed_of_files_of_data_alone(tmp_path, name, shown):
    told = refused(tmp_path, "root:x:0:0,secret\n1,2\n", name=name)
    assert f"{name}:1: there is no column 'x'" in told
    assert ("secret" in told) == shown


@pytest.mark.parametrize(("text", "line"), [("t,x,y\n0,1,2\n1,\xb0,2\n", 3), ("t,x [\xb0/s],y\n0,1,2\n", 1)])
def test_bytes_that_are_no_utf_8_are_refused_at_their_line(tmp_path, text, line):
    (tmp_path / "log.csv").write_bytes(text.encode("latin-1"))
    assert f"log.csv:{line}: expected text in UTF-8" in refused(tmp_path, None)


def test_a_start_after_the_last_row_is_refused(tmp_path):
    rows = "t,x,y\n0,1,2\n1,3,4\n"
    assert "log.csv:1: start: expected at or before the last row, found 0.5 s after it" in refused(
        tmp_path, rows, start=1.5
    )
    assert read(tmp_path, rows, start=1.0)[1][-1, 0] == 0.0


def test_of_rows_of_one_instant_the_last_counts_and_older_rows_are_dropped(tmp_path):
    text = "t,x,y\n0,1,1\n1,2,2\n1,3,3\n0.5,4,4\n2,5,5\n"
    record, table = read(tmp_path, text)
    np.testing.assert_array_equal(table[:, :2], [[0, 1], [1, 3], [2, 5]])
    assert (record.seen.repeated, record.seen.disordered) == ([4], [5])
    first = read(tmp_path, text, repeated="first", disordered="sorted")[1]
    np.testing.assert_array_equal(first[:, :2], [[0, 1], [0.5, 4], [1, 2], [2, 5]])


@pytest.mark.parametrize("where", [{}, {"y": "2"}])
def test_sorted_rows_begin_at_the_earliest_of_those_that_are_asked_for(tmp_path, where):
    text = "t,x,y\n2000000050,5,2\n2000000000,1,2\n2000000001,3,2\n1999999990,0,1\n"
    record, table = read(tmp_path, text, scale="UTC", disordered="sorted", where=where)
    assert table[:, 0].tolist() == ([0.0, 1.0, 50.0] if where else [0.0, 10.0, 11.0, 60.0])
    assert record.utc == ("2033-05-18T03:33:20Z" if where else "2033-05-18T03:33:10Z")


@pytest.mark.parametrize("disordered", ["dropped", "sorted"])
def test_a_header_without_rows_is_refused(tmp_path, disordered):
    assert refused(tmp_path, "t,x,y\n", disordered=disordered) == "log.csv:1: there are no rows"


def test_rows_of_one_instant_in_two_blocks_are_one_sample(tmp_path, monkeypatch):
    monkeypatch.setattr("orchestration.telemetry.rows.BLOCK", 2)
    _, table = read(tmp_path, "t,x,y\n0,1,1\n1,2,2\n1,3,3\n1,4,4\n0,9,9\n2,5,5\n")
    np.testing.assert_array_equal(table[:, :2], [[0, 1], [1, 4], [2, 5]])


@pytest.mark.parametrize(
    ("text", "more", "message"),
    [
        ("a,x,y\n0,1,2\n", {}, "log.csv:1: there is no column 't'"),
        ("t|x|y\n0|1|2\n", {}, "there is only t|x|y; remedy: cells that commas, semicolons or tabs part"),
        ("t;x;y\n0;1,5;2\n", {}, "log.csv:2: x: expected a number, found '1,5', whose comma has to be a point"),
        ("t,x,y\n0,1_0,2\n", {}, "log.csv:2: x: expected a number, found '1_0'"),
        ("t,x,y\n1_0,1,2\n", {}, "log.csv:2: t: expected a number, found '1_0'"),
        ("t,x,y\n9,1,2\n0,1,2\n1,1,2\n", {}, "log.csv:3: 2 rows are older than one before them, more than the 1"),
        ('t,x,y\n0,"1,2\n' + "1,1,2\n" * 50_000, {}, "this is no CSV file: field larger than field limit"),
        ("t,x,y\n,1,2\n", {}, "log.csv:2: t: expected a number, found ''"),
        ("t,x,y\n0,1,2\n1,one,2\n", {}, "log.csv:3: x: expected a number, found 'one'"),
        ("t,x [T],y\n0,1,2\n", {}, "log.csv:1: x: the unit 'T' of this column does not fit 'deg/s' of w"),
        ("t,x,y\n0,1,2\n0,1,2\n", {"repeated": "refused"}, "log.csv:3: t: this row has the time"),
        ("t,x,y\n0,1,2\n-1,1,2\n", {"disordered": "refused"}, "log.csv:3: t: this row is older"),
        ("t,x,y\n0,1,2\n0,1\n", {}, "log.csv:3: expected at least 3 cells, found 2"),
        ("t,x,y\n2020-01-01T00:00:00Z,1,2\n", {"scale": "GPS"}, "log.csv:2: t: expected a time in GPS, found"),
        ("t,x,y\n", {}, "log.csv:1: there are no rows"),
        ("t,x,y\n0,1,2\n1,1,5,2\n", {}, "log.csv:3: expected at most 3 cells, as in the header, found 4"),
        ("t,x,x,y\n0,1,2,3\n", {}, "log.csv:1: x: several columns are called 'x'"),
        ("t [m],x,y\n0,1,2\n", {}, "log.csv:1: t: 'm' of this column does not fit 's'"),
        ("t (GPS),x,y\n0,1,2\n", {"scale": "UTC"}, "log.csv:1: t: 'GPS' of this column is not the scale 'UTC'"),
        ("t,x,y\n0,1,2\n", {"time": {"epoch": "2020-01-01"}}, "time: epoch: expected none with the scale 'elapsed'"),
    ],
)
def test_what_cannot_be_read_is_refused_at_its_line_and_column(tmp_path, text, more, message):
    assert message in refused(tmp_path, text, **more)


@pytest.mark.parametrize(
    "wrong",
    [{"gain": [[0, 1], [5, np.nan]]}, {"offset": [0, np.inf]}, {"matrix": [[1, np.nan], [0, 1]]}],
    ids=lambda wrong: next(iter(wrong)),
)
def test_a_correction_that_is_not_finite_is_refused_and_not_taken_for_missing_values(tmp_path, wrong):
    columns = {"w": {**COLUMNS["w"], **wrong}}
    message = f"w: {next(iter(wrong))}: expected finite numbers"
    assert message in refused(tmp_path, "t,x,y\n0,1,2\n", columns=columns)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"offset": [[0, 1, 2], [5, 1]]}, "w: offset: expected 2 numbers, or rows of time and 2 numbers"),
        ({"offset": []}, "w: offset: expected 2 numbers, or rows of time and 2 numbers"),
        ({"offset": [[5, 1, 2], [0, 1, 2]]}, "w: offset: expected rows in the order of their times"),
        ({"gain": [[5, 1], [0, 2]]}, "w: gain: expected rows in the order of their times"),
    ],
)
def test_a_correction_of_another_shape_or_order_is_refused(tmp_path, wrong, message):
    assert message in refused(tmp_path, "t,x,y\n0,1,2\n", columns={"w": {**COLUMNS["w"], **wrong}})


def test_a_unit_in_the_header_is_converted_to_that_of_the_port_and_one_of_the_time_to_seconds(tmp_path):
    text = "t [ms],x [rad/s],y\n500,3.141592653589793,2\n1500,-999,2\n"
    columns = {"w": {**COLUMNS["w"], "missing": [-999]}}
    np.testing.assert_allclose(read(tmp_path, text, columns=columns)[1], [[0.5, 180, 2], [1.5, np.nan, 2]], rtol=1e-14)


def test_nan_is_refused_where_a_value_is_required(tmp_path):
    columns = {"w": {"of": ["x"], "unit": "deg/s", "required": True}}
    with pytest.raises(InputError, match="log.csv:3: x: expected a value, since w is required, found 'nan'"):
        read(tmp_path, "t,x,y\n0,1,2\n1,nan,2\n", columns=columns)


def test_columns_are_corrected_by_offset_matrix_and_gain(tmp_path):
    columns = {"w": {"of": ["x", "y"], "offset": [1, 2], "matrix": [[0, 1], [1, 0]], "gain": [[0, 1], [10, 3]]}}
    _, table = read(tmp_path, "t,x,y\n0,2,5\n5,2,5\n", columns=columns)
    np.testing.assert_allclose(table[:, 1:], [[3, 1], [8, 3]])


def test_an_offset_may_change_with_time(tmp_path):
    columns = {"w": {"of": ["x", "y"], "offset": [[0, 1, 2], [10, 3, 2]]}}
    _, table = read(tmp_path, "t,x,y\n0,2,5\n5,2,5\n20,2,5\n", columns=columns)
    np.testing.assert_allclose(table[:, 1:], [[1, 3], [0, 3], [-1, 3]])


def test_a_port_may_be_a_matrix_by_rows_of_columns_or_by_a_quaternion(tmp_path):
    from scipy.spatial.transform import Rotation

    R = Rotation.from_rotvec([[0.1, -0.7, 0.3], [2.0, 1.0, -2.0]])
    names = [[f"r{i}{k}" for k in "123"] for i in "123"]
    header = ["t", *(name for row in names for name in row), "a", "b", "c", "d"]
    rows = [[t, *m.ravel(), *q] for t, m, q in zip((0, 1), R.as_matrix(), R.as_quat(), strict=True)]
    text = "\n".join([",".join(header), *(",".join(map(repr, map(float, row))) for row in rows), "2" + "," * 13])
    columns = {
        "R_NB": {"of": names},
        "last": {"of": ["a", "b", "c", "d"], "quaternion": "scalar last"},
        "first": {"of": ["d", "a", "b", "c"], "quaternion": "scalar first", "inverse": True},
    }
    record, table = read(tmp_path, text, columns=columns)
    assert [column.shape for column in record.entry.columns.values()] == [(3, 3)] * 3
    for at, wanted in ((1, R), (10, R), (19, R.inv())):
        np.testing.assert_allclose(table[:2, at : at + 9], wanted.as_matrix().reshape(2, 9), atol=1e-15)
    assert np.isnan(table[2, 1:]).all()
    long = text.replace(rows_of := text.splitlines()[2].rsplit(",", 1)[1], repr(2 * float(rows_of)))
    assert "log.csv:3: a: expected a quaternion of length 1" in refused(tmp_path, long, columns=columns)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"of": [["x", "y"], ["x"]]}, "expected rows of one length"),
        ({"of": [["x"], ["y"]], "matrix": [[1, 0]]}, "expected a 'matrix' for the columns of a vector"),
        ({"of": ["x", "y"], "quaternion": "scalar last"}, "a quaternion has 4 columns without unit"),
        ({"of": ["x"] * 4, "quaternion": "scalar last", "gain": [[0, 1]]}, "a quaternion goes without gain"),
        ({"of": ["x"], "inverse": True}, "'inverse' is of a quaternion"),
    ],
)
def test_a_matrix_or_quaternion_of_other_columns_is_refused(tmp_path, wrong, message):
    with pytest.raises(ValueError, match=message):
        read(tmp_path, "t,x,y\n0,1,2\n", columns={"w": wrong})


def test_parquet_gives_what_csv_gives(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as parquet

    when = [datetime(2024, 1, 1, tzinfo=UTC), datetime(2024, 1, 1, 0, 0, 1, 500_000, tzinfo=UTC)]
    parquet.write_table(pa.table({"t": when, "x": [1.0, None], "y": [2.0, 3.0]}), tmp_path / "log.parquet")
    _, table = read(tmp_path, None, name="log.parquet", scale="UTC")
    np.testing.assert_array_equal(table, [[0, 1, 2], [1.5, np.nan, 3]])


@pytest.mark.parametrize("scale", ["UTC", "GPS", "TAI"])
def test_seconds_between_two_dates_are_those_of_astropy_in_each_scale(scale):
    dates = ["2016-12-31T23:59:00", "2017-01-01T00:01:00", "1998-06-01T00:00:00", "2024-05-05T05:05:05.5"]
    times, bad, _ = instants(dates, 1.0, 0.0, scale)
    assert bad is None
    shift = 19.0 if scale == "GPS" else 0.0  # GPS is a count, which astropy has no calendar for
    wanted = Time(dates, scale="tai" if scale == "GPS" else scale.lower()).tai
    np.testing.assert_allclose(times - times[0], (wanted - wanted[0]).sec, atol=2e-6)
    assert times[0] - shift == pytest.approx((wanted[0] - Time("1970-01-01", scale="tai")).sec, abs=1e-5)


def test_seconds_across_a_leap_second_are_those_of_astropy_and_its_row_has_its_own_instant(tmp_path):
    dates = ["2016-12-31T23:59:59Z", "2016-12-31T23:59:60Z", "2016-12-31T23:59:60.500Z", "2017-01-01T00:00:00Z"]
    record, table = read(tmp_path, "t,x,y\n" + "".join(f"{date},1,2\n" for date in dates), scale="UTC")
    utc = Time([date[:-1] for date in dates], scale="utc")
    np.testing.assert_allclose(table[:, 0], (utc - utc[0]).sec, atol=1e-6)
    np.testing.assert_array_equal(table[:, 0], [0.0, 1.0, 1.5, 2.0])
    later, _ = read(tmp_path, "t,x,y\n2016-12-31T23:59:60Z,1,2\n", scale="UTC")
    assert (record.utc, later.utc) == (dates[0], dates[1])
    assert later.seen.first == pytest.approx((utc[1] - Time("1970-01-01", scale="tai")).sec, abs=1e-5)


@pytest.mark.parametrize(
    ("scale", "date"),
    [("UTC", "2019-12-31T23:59:60Z"), ("UTC", "2017-01-01T12:30:60"), ("GPS", "2016-12-31T23:59:60")],
)
def test_a_leap_second_that_there_was_not_is_refused(tmp_path, scale, date):
    assert "log.csv:2: t: expected a" in refused(tmp_path, f"t,x,y\n{date},1,2\n", scale=scale)


@pytest.mark.parametrize(("scale", "form"), [("UTC", "unix"), ("GPS", "gps"), ("TAI", "unix_tai")])
def test_numbers_of_each_scale_are_the_instants_of_astropy(scale, form):
    wanted = Time(["1999-01-01T00:00:10", "2016-12-31T23:59:58", "2017-01-01T00:00:03", "2024-05-05"], scale="utc")
    numbers = getattr(wanted, form)
    epoch = 315964800.0 if scale == "GPS" else 0.0  # 1980-01-06
    times, bad, _ = instants([repr(float(number)) for number in numbers], 1.0, epoch, scale)
    assert bad is None
    np.testing.assert_allclose(times, (wanted.tai - Time("1970-01-01", scale="tai")).sec, atol=1e-5)


def test_the_run_starts_at_a_date_whatever_the_scale_of_the_rows(tmp_path):
    text = "t,x,y\n1378209616,1,2\n"  # 2023-09-09 12:00:00 TAI - 19 s of GPS
    gps = Time(1378209616, format="gps").utc.isot
    _, table = read(tmp_path, text, scale="GPS", start=gps)
    assert table[0, 0] == pytest.approx(0.0, abs=2e-3)
