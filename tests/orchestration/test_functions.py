"""The functions that a user imports: what they return is what their commands print."""

from __future__ import annotations

import inspect
import subprocess
import sys
import typing
from importlib.metadata import version

import numpy as np
import pytest

import orchestration
from fmus.build import ensure
from orchestration import InputError, check_fmu, check_polarity, compare_fmu, export_loop, run_campaign, sweep

MINIMAL = "scenarios/minimal.yaml"
FUNCTIONS = [name for name in orchestration.__all__ if name.islower() and not name.startswith("_")]


def test_completion_shows_what_a_user_calls_and_nothing_else():
    assert dir(orchestration) == sorted(orchestration.__all__)
    assert {"run", "load", "Result"} < set(dir(orchestration))
    assert "annotations" not in dir(orchestration)
    assert orchestration.__version__ == version("attitude-cosim")


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_has_a_docstring_and_returns_a_type_of_its_own(name):
    function = getattr(orchestration, name)
    assert function.__doc__
    returned = inspect.signature(function).return_annotation
    assert returned not in (inspect.Signature.empty, "Any", typing.Any)


def test_a_plain_installation_has_all_functions_and_says_what_a_campaign_needs():
    program = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"scipy", "pyarrow", "pandas", "xarray", "matplotlib"}:
            raise ModuleNotFoundError(name, name=name)
sys.meta_path.insert(0, Absent())
import orchestration
for name in orchestration.__all__:
    getattr(orchestration, name)
try:
    orchestration.run_campaign("any.yaml")
except orchestration.InputError as error:
    print(error)
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said == "run_campaign needs the package 'scipy'; remedy: pip install 'attitude-cosim[campaign]'\n"


def test_a_sweep_flies_every_combination_of_values():
    points = sweep(MINIMAL, {"plant.h_w0": [0.0, "1 mN.m.s"], "step": [0.1, 0.05]}, duration="1 s")
    assert [tuple(p.values.values()) for p in points] == [
        (0.0, 0.1),
        (0.0, 0.05),
        ("1 mN.m.s", 0.1),
        ("1 mN.m.s", 0.05),
    ]
    assert [p.result["plant.h_w", "mN.m.s"][0] for p in points] == pytest.approx([0.0, 0.0, 1.0, 1.0])
    assert [p.result.steps for p in points] == [10, 20, 10, 20]
    with pytest.raises(InputError, match=r"values: expected a start value with the values to sweep, found none"):
        sweep(MINIMAL, {})


def test_a_campaign_returns_its_verdicts(tmp_path):
    finished = run_campaign("scenarios/campaigns/paper_settling.yaml", tmp_path / "out", runs=2, workers=0)
    assert (finished.state, finished.flown, finished.failed) == ("completed", 2, 0)
    assert {v.name for v in finished.verdicts}
    assert (tmp_path / "out" / "campaign.json").exists()


def test_our_own_block_fits_in_its_place_and_is_equal_to_itself():
    ours = ensure("plant", "native")
    assert not [f for f in check_fmu(ours, "plant", play=False) if f.level == "error"]
    comparison = compare_fmu(orchestration.load(MINIMAL, {"duration": "20 s"}), "plant", ours)
    assert comparison.ours.time[-1] == 20.0
    assert comparison.passed
    assert {d.largest for d in comparison.differences} == {0.0}


def test_a_wrong_sign_is_a_row_of_the_polarity_of_a_port():
    trials = check_polarity("scenarios/paper_no_singularity.yaml", ["allocator.h_w"], workers=1)
    assert trials.nominal is None
    assert {row.wrong: row.found is not None for row in trials.rows}["opposite sign"]


@pytest.mark.parametrize("suffix", [".ssp"])
def test_a_loop_is_exported_by_the_suffix_of_its_path(tmp_path, suffix):
    path = export_loop(MINIMAL, tmp_path / f"loop{suffix}")
    flown, ours = orchestration.run(path, duration="1 s"), orchestration.run(MINIMAL, duration="1 s")
    assert np.array_equal(flown["plant.omega_B"], ours["plant.omega_B"])
    with pytest.raises(InputError, match=r"path: expected a name that ends in .ssp or .fmu, found loop.zip"):
        export_loop(MINIMAL, "loop.zip")


def test_the_package_is_imported_without_what_its_functions_need():
    code = "import sys, orchestration; print([m for m in ('numpy', 'pydantic', 'fmpy') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"
