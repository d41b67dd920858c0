"""Our native FMUs in other tools: one by one, and the whole loop, beside what `orchestrate` makes of them."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.fmus.link import devices

from . import measure
from .measure import LOOPS, ONES, STEPS, Recipe

pytestmark = pytest.mark.thorough

MODULES = {
    "FMPy": "fmpy",
    "libcosimpy": "libcosimpy",
    "ecospy": "ecospy",
}


def needs(recipe: Recipe) -> None:
    """Skips where the importer cannot be loaded; on CI that is a failure."""
    module = MODULES[recipe.package]
    if recipe.package == "ecospy":  # it loads its library when it is imported, and prints where that fails
        done = subprocess.run([sys.executable, "-c", "import ecospy.lib"], capture_output=True, text=True, check=False)
        reason = done.stderr.strip().rpartition("\n")[2] if done.returncode else ""
    else:
        try:
            importlib.import_module(module)
            reason = ""
        except ImportError as error:
            reason = str(error)
    if reason:
        if os.environ.get("CI"):
            pytest.fail(f"{recipe.tool} cannot be loaded: {reason}")
        pytest.skip(f"{recipe.tool} cannot be loaded: {reason}")


@pytest.mark.parametrize("recipe", ONES, ids=lambda r: r.tool)
def test_the_plant_alone_tumbles_in_every_tool_as_it_does_here(recipe: Recipe, exported: Path) -> None:
    needs(recipe)
    time, rate = measure.play(recipe, exported)
    index = np.rint(time / 0.1).astype(int)
    assert index[-1] == 600
    np.testing.assert_allclose(rate, measure.alone("plant", measure.PLANT, "omega_B[2]")[index], rtol=0, atol=1e-14)


LAWS = {
    "controller": ({"r_N[1]": 7.1e6}, "tau_cmd_B[2]"),
    "allocator": ({"tau_cmd_B[2]": 1e-4}, "dipole_cmd[3]"),
    "allocator_bounded": ({"tau_cmd_B[2]": 1e-4}, "dipole_cmd[3]"),  # its description has optional inputs
}


@pytest.mark.parametrize("block", LAWS)
@pytest.mark.parametrize("recipe", ONES, ids=lambda r: r.tool)
def test_the_laws_alone_give_in_every_tool_what_they_give_here(recipe: Recipe, block: str, exported: Path) -> None:
    needs(recipe)
    start, signal = LAWS[block]
    time, seen = measure.play(recipe, exported, replace=measure.changed(recipe, block, start, signal))
    expected = measure.alone(block, start, signal)[np.rint(time / 0.1).astype(int)]
    assert np.abs(expected).max() > 0
    np.testing.assert_allclose(seen, expected, rtol=1e-13, atol=0)


@pytest.mark.skipif(sys.platform == "win32", reason="the device uses POSIX")
@pytest.mark.parametrize("recipe", ONES, ids=lambda r: r.tool)
def test_a_device_behind_its_link_fmu_gives_in_every_tool_what_the_block_gives_here(
    recipe: Recipe, tmp_path: Path
) -> None:
    needs(recipe)
    shutil.copy(devices.fmu("controller"), tmp_path)
    (start, signal), port = LAWS["controller"], devices.free_port()
    replace = measure.changed(recipe, "controller_link", start, signal)
    ((name, value),) = start.items()
    prefix = "controller_link::" if recipe.tool == "ecos" else ""
    if recipe.tool == "libcosim":
        text = f'execution.string_initial_value(controller_link, references["link_address"], "127.0.0.1:{port}")\n'
        replace["observer = "] = f"{text}observer = "
    else:
        replace[f'"{prefix}{name}": {value}'] = f'"{prefix}{name}": {value}, "{prefix}link_address": "127.0.0.1:{port}"'
    with devices.running("controller", "udp", port):
        time, seen = measure.play(recipe, tmp_path, replace=replace)
    expected = measure.alone("controller", start, signal)[np.rint(time / 0.1).astype(int)]
    assert np.abs(expected).max() > 0
    np.testing.assert_array_equal(seen, expected)


@pytest.mark.parametrize("recipe", LOOPS, ids=lambda r: r.script.removesuffix(".py"))
def test_the_loop_differs_from_ours_by_the_exchange_alone_and_less_as_the_step_shrinks(
    recipe: Recipe, exported: Path
) -> None:
    """With our exchange set to the tool's the difference is rounding; from our default it is of first order in the
    step."""
    needs(recipe)
    found = [measure.difference(recipe, exported, step) for step in STEPS]
    assert max(d.same for d in found) < 1e-13
    if recipe.exchange == "sequential":
        return
    sizes = [d.sequential for d in found]
    assert sizes[0] < 0.02
    assert all(1.8 < coarse / fine < 2.2 for coarse, fine in pairwise(sizes))


def test_fmpy_s_ssp_simulation_runs_without_the_recipe_s_lines_from_the_blocks_own_starts(exported: Path) -> None:
    """Its first inputs are zeros, which the controller takes for no attitude yet; it ignores the parameter set."""
    recipe = LOOPS[0]
    time, error = measure.play(
        recipe,
        exported / "step_0.1",
        replace={", simulation.set_value = instantiate, set_value": ", simulation.set_value = plain, set_value"},
    )
    assert time[-1] == pytest.approx(120.0, abs=0.11)
    assert error[0] == pytest.approx(np.pi)
    assert np.isfinite(error).all()
    assert error[1:].max() < 3.1


REFUSALS = {
    "fmpy_ssp.py": "invalid literal for int\\(\\) with base 10: 'constant'",
    "libcosim_ssp.py": "Internal error",
    "ecos_ssp.py": "Unknown XML node in ssv:Parameter",
}


@pytest.mark.parametrize("recipe", LOOPS, ids=lambda r: r.script.removesuffix(".py"))
def test_an_enumeration_s_item_is_never_ignored_in_silence(recipe: Recipe, tmp_path: Path) -> None:
    """No reader of SSP archives here can set one, and each says so or ends; the container has it."""
    needs(recipe)
    scenario = measure.prepare_item(tmp_path)
    if recipe.script in REFUSALS:
        with pytest.raises(AssertionError, match=REFUSALS[recipe.script]):
            measure.play(recipe, tmp_path)
        return
    _, error = measure.play(recipe, tmp_path)
    np.testing.assert_array_equal(error, measure.loop(scenario, 0.1, recipe.exchange))


@pytest.mark.parametrize("recipe", LOOPS[:3], ids=lambda r: r.script.removesuffix(".py"))
def test_every_reader_has_an_enumeration_that_is_written_as_a_number(recipe: Recipe, tmp_path: Path) -> None:
    needs(recipe)
    scenario = measure.prepare_item(tmp_path, "--numbers")
    time, error = measure.play(recipe, tmp_path)
    ours = measure.loop(scenario, 0.1, recipe.exchange)
    index = np.rint(time / 0.1).astype(int) + recipe.ahead
    np.testing.assert_allclose(error[index < len(ours)], ours[index[index < len(ours)]], rtol=0, atol=1e-9)
    assert abs(ours - measure.loop(measure.SCENARIO, 0.1, recipe.exchange)).max() > 1e-3
