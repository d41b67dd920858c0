"""What a user does with a result: looks at it in a notebook, hands it to other libraries, compares two."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from orchestration import InputError, run
from orchestration.quantities import parse_unit
from orchestration.results.folder import write

from ..mocks import Mock, model, ramp, real
from ..mocks import run as run_mocks


def spinning(gain=1.0, unit="rad/s", **scenario):
    """A run that records a vector of the unit, [t, 2 t] * gain, and a boolean that is true from 0.5 s on."""

    def evaluate(block):
        for i, element in enumerate(block.model.variables["w"].elements):
            block.values[element] = gain * (i + 1) * block.state
        block["on"] = block.state >= 0.5

    def advance(block, time, step):
        block.state = round(time + step, 9)

    w = real("w", "output", shape=(2,), unit=parse_unit(unit), description="rate")
    kind = model("a", w, real("on", "output", type="boolean"))
    return run_mocks([Mock("a", kind, evaluate, advance)], {"step": 0.1, "duration": 1, **scenario})


EXPECT = [{"name": "slow & <steady>", "signal": "a.w", "always": {"below": 3}}]


def test_a_result_is_shown_in_a_line_and_in_a_small_table():
    result = spinning(expect=EXPECT)
    assert repr(result) == "<Result test: ran 1 s, 2 signals, 11 samples, 1 of 1 expectations met>"
    html = result._repr_html_()
    HTMLParser().feed(html)
    assert "slow &amp; &lt;steady&gt;" in html
    assert "met" in html
    assert len(html) < 2000


def test_a_notebook_completes_the_names_of_signals():
    result = spinning()
    assert result._ipython_key_completions_() == result.signals == ["a.w", "a.on"]


def test_units_stand_on_the_result_in_the_manifest_and_in_every_format_that_has_a_place_for_them(tmp_path, loop):
    result = spinning()
    assert result.units == {"a.w": "rad/s", "a.on": ""}
    ran = run(loop)
    assert ran.manifest["units"] == {"time": "s", **ran.units}
    assert ran.units["motor.speed"] == "rad/s"
    from scipy.io import loadmat

    units = loadmat(write(result, tmp_path / "m", "mat") / "signals.mat", simplify_cells=True)["units"]
    assert units["time"] == "s"
    assert units["a"]["w"] == "rad/s"
    from pyarrow.parquet import read_table

    schema = read_table(write(result, tmp_path / "p", "parquet") / "signals.parquet").schema
    assert schema.field("a.w[2]").metadata[b"unit"] == b"rad/s"
    assert schema.field("time").metadata[b"unit"] == b"s"
    assert not schema.field("a.on").metadata


def test_pandas_has_a_column_for_each_element_with_its_type_and_unit():
    frame = spinning().to_pandas()
    assert list(frame.columns) == ["a.w[1]", "a.w[2]", "a.on"]
    assert frame.index.name == "time"
    assert frame["a.w[2]"].loc[1.0] == 2.0
    assert frame["a.on"].dtype == bool
    assert frame.attrs["units"]["a.w[1]"] == "rad/s"


def test_xarray_has_whole_vectors_with_indices_as_the_fmu_counts():
    data = spinning().to_xarray()
    assert data["a.w"].dims == ("time", "axis_2")
    assert float(data["a.w"].sel({"time": 1.0, "axis_2": 2})) == 2.0
    assert data["a.w"].attrs == {"units": "rad/s", "long_name": "rate"}


def test_vectors_in_xarray_share_an_axis_so_that_arithmetic_pairs_their_elements():
    result = run("scenarios/minimal.yaml", duration="1 s")
    data = result.to_xarray()
    apart = data["plant.omega_B"] - data["plant.b_B"]
    assert apart.dims == ("time", "axis")
    assert apart.values == pytest.approx(result["plant.omega_B"] - result["plant.b_B"])
    rate_N = (data["plant.R_NB"] * data["plant.omega_B"]).sum("axis")
    assert rate_N.values == pytest.approx(np.einsum("nij,nj->ni", result["plant.R_NB"], result["plant.omega_B"]))
    assert data["plant.q_NB"].dims == ("time", "axis_4")


def test_a_signal_is_asked_for_in_a_unit_that_fits():
    result = spinning()
    assert result["a.w", "deg/s"] == pytest.approx(np.degrees(result["a.w"]))
    assert result["a.w[2]", "rpm"] == pytest.approx(result["a.w[2]"] * 60 / (2 * np.pi))
    with pytest.raises(InputError, match=r"a.w: expected a unit of a.w, which is in 'rad/s', found 'N.m'"):
        result["a.w", "N.m"]
    with pytest.raises(InputError, match=r"a.on: expected a unit of a.on"):
        result["a.on", "s"]
    with pytest.raises(KeyError, match="'a.v' was not recorded"):
        result["a.v", "rad/s"]


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_missing_library_is_named_with_the_extra_that_brings_it(package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf"pip install 'attitude-cosim\[{package}\]'"):
        getattr(spinning(), f"to_{package}")()


def test_plot_draws_a_panel_for_each_signal_and_refuses_an_unknown_one():
    figure = spinning().plot("a.w", "a.on")
    assert [axes.get_ylabel() for axes in figure.axes] == ["a.w, rad/s", "a.on"]
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert len(spinning(expect=EXPECT).plot().axes) == 1
    with pytest.raises(KeyError, match="did you mean 'a.w'"):
        spinning().plot("a.v")


def test_two_results_are_compared_in_the_units_of_the_first_at_common_instants():
    first = spinning()
    second = spinning(gain=np.rad2deg(1.5), unit="deg/s", step=0.2)
    found = first.compare(second)
    t = np.arange(0.0, 1.01, 0.2)
    apart = 0.5 * np.outer(t, [1.0, 2.0])
    assert found["a.w"].largest == pytest.approx(1.0)
    assert found["a.w"].rms == pytest.approx(np.sqrt(np.mean(apart**2)))
    assert (found["a.w"].time, found["a.w"].unit) == (1.0, "rad/s")
    assert found["a.on"].largest == 0.0
    assert repr(found).splitlines()[0].split() == ["signal", "largest", "rms", "at,", "s", "unit"]
    assert "<td>a.w</td>" in found._repr_html_()


def test_signals_that_only_one_result_has_are_left_out_and_results_without_a_common_instant_refused():
    first, other = spinning(), run_mocks([ramp("a")], {"step": 0.1, "duration": 1}, start={"a": {"u": 0}})
    assert list(first.compare(other)) == []
    other.time = other.time + 0.05
    with pytest.raises(ValueError, match="no instant in common"):
        first.compare(other)


def test_duration_and_step_are_arguments_of_run(loop):
    result = run(loop, duration="1 s", step=0.05)
    assert (result.time[-1], result.steps) == (1.0, 20)


# ---------------------------------------------------------------- what a process keeps from run to run


def test_a_file_that_changed_between_two_runs_is_seen(loop, tmp_path):
    from .. import fmus

    first = run(loop)
    text = loop.read_text()
    loop.write_text(text.replace("speed0: 2 rad/s", "speed0: 3 rad/s"))
    assert run(loop)["motor.speed"][0] == 1.5 * first["motor.speed"][0]
    loop.write_text(text)
    before = first.manifest["fmus"]["motor"]["sha256"]
    xml = fmus.description("motor")
    changed = xml.replace('name="speed"', 'name="speed" description="another"', 1)
    fmus.write(Path("motor.fmu"), changed, fmus.library())
    again = run(loop)
    assert again.manifest["fmus"]["motor"]["sha256"] != before
    assert again.variable("motor.speed").description == "another"
    Path("motor.fmu").write_bytes(b"no archive")
    with pytest.raises(InputError, match="motor.fmu is no FMU"):
        run(loop)


def test_a_second_run_gives_the_same_bits_and_what_one_run_changes_is_not_in_the_next(loop):
    first = run(loop, {"motor.speed0": 5})
    second, third = run(loop), run(loop, {"motor.speed0": 5})
    assert second["motor.speed"][0] != first["motor.speed"][0]
    assert first.samples.tobytes() == third.samples.tobytes()


def test_a_scenario_that_is_run_again_is_planned_once_and_gives_the_same_in_all_that_does_not_tell_the_time(
    monkeypatch,
):
    from orchestration.session import open as opening

    monkeypatch.setattr("orchestration.fmu.archive._MOMENT", 0)  # an FMU that was built a moment ago may be kept, too
    scenario = Path(__file__).parents[3] / "scenarios" / "minimal.yaml"
    first = run(scenario, duration="10 s")
    first.warnings.append("of the first run")
    first.manifest["notes"].append("of the first run")
    planned = []
    original = opening.plan
    monkeypatch.setattr(opening, "plan", lambda *a: planned.append(1) or original(*a))
    second = run(scenario, duration="10 s")
    assert planned == []
    assert first.samples.tobytes() == second.samples.tobytes()
    assert "of the first run" not in [*second.warnings, *second.manifest["notes"]]
    told = ("wall_time", "steps_per_second", "finished", "notes")
    assert {k: v for k, v in first.manifest.items() if k not in told} == {
        k: v for k, v in second.manifest.items() if k not in told
    }
    assert run(scenario, duration="20 s").reached == 20.0
    assert planned == [1], "another duration is another plan"
