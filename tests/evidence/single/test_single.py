"""The flight code in single precision: what is translated, and that its flights and bits are those of the page."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

from evidence.paper import ROOT
from evidence.single.build import INNER, WARNINGS, fmu, lay_out
from evidence.single.make import BLOCKS, Pair, Pointing, clock, flown, pair
from evidence.single.translate import APART, translated, write
from fmus.block import Block
from fmus.native.toolchain import FLAGS, run, zig
from orchestration import run as fly
from tests.native.driver import Instance, opened


def test_numbers_become_single_and_texts_and_comments_stay() -> None:
    text = 'const double x = 1.0 / 3e4; /* double 2.5 */ fault(f, "at most 1e-06", n[10], 0x1.8p-3, 1e-300, DBL_MAX);'
    assert translated(text) == (
        'const float x = 1.0f / 3e4f; /* double 2.5 */ fault(f, "at most 1e-06", n[10], 0x1.8p-3f, '
        "1.17549435e-38f, FLT_MAX);"
    )


@pytest.mark.parametrize("name", ["controller", "estimator", "controller_planned_wheels"])
def test_no_double_is_left_in_a_block_but_in_the_date(name: str, tmp_path: Path) -> None:
    sources, folders = write(Block.named(name), tmp_path)
    files = {path for folder in folders for path in folder.rglob("*.[ch]")}
    code = {
        path.name: re.sub(r'"(?:\\.|[^"\\])*"|/\*.*?\*/|//[^\n]*', "", path.read_text(), flags=re.DOTALL)
        for path in files
    }
    assert len(sources) > 1
    assert {name for name, text in code.items() if re.search(r"\bdouble\b|DBL_", text)} <= set(APART)


@pytest.mark.parametrize("name", ["sin", "cos", "log", "log1p", "exp", "expm1"])
def test_an_elementary_function_is_within_two_units_in_the_last_place(name: str, tmp_path: Path) -> None:
    sources, headers = lay_out(Block.named("controller"), tmp_path)
    elementary = next(path for path in sources if path.name == "elementary.c")
    wrapper = tmp_path / "wrapper.c"
    wrapper.write_text(f"#include <math.h>\nfloat own(float x);\nfloat own(float x) {{ return {name}(x); }}\n")
    flags = [flag for flag in FLAGS if not flag.startswith("-fvisibility")]
    command = [str(zig()), "cc", *flags, *WARNINGS, "-ffreestanding", *(f"-I{h}" for h in headers), "-shared"]
    run([*command, str(elementary), str(wrapper), "-o", str(tmp_path / "own.so")], wrapper)
    own = ctypes.CDLL(str(tmp_path / "own.so")).own
    own.restype, own.argtypes = ctypes.c_float, [ctypes.c_float]
    ranges = {"sin": (-700.0, 700.0), "cos": (-700.0, 700.0), "log": (1e-30, 1e3), "log1p": (-0.9, 1e3)}
    low, high = ranges.get(name, (-15.0, 80.0))
    rng = np.random.default_rng(0)
    points = np.concatenate((rng.uniform(low, high, 4000), rng.uniform(-0.3, 0.3, 1000)))
    for x in points.astype(np.float32):
        if name == "log" and x <= 0.0:
            continue
        expected = getattr(math, name)(float(x))
        assert abs(own(x) - expected) <= 2.5 * float(np.spacing(np.float32(abs(expected)))), x


def test_the_papers_flight_holds_as_in_double_precision(tmp_path: Path) -> None:
    name, places = "paper_no_singularity", {"controller": "controller", "allocator": "allocator"}
    fmus = {block: fmu(block, tmp_path / block) for block in places.values()}
    found = pair(name, places, fly(ROOT / "scenarios" / f"{name}.yaml"), flown(name, places, fmus))
    assert found.fits
    assert 0.0 < found.apart < 1e-5  # not the same flight, and next to it


def test_a_hold_that_is_worse_or_later_fails_the_requirement() -> None:
    good = Pointing(1000.0, 0.01, 0.02)
    for bad in (Pointing(1030.0, 0.01, 0.02), Pointing(1000.0, 0.012, 0.02), Pointing(math.nan, math.nan, math.nan)):
        assert not Pair("", (), good, bad, 0.0).fits
    assert Pair("", (), good, Pointing(1010.0, 0.0105, 0.03), 0.0).fits


def test_a_time_in_tenths_of_a_second_stands_still_where_half_its_last_place_is_more() -> None:
    wrong, still = clock(0.1)
    assert wrong < still < math.inf
    assert clock(0.5)[0] >= 2.0**23 - 1.0 or clock(0.5)[0] == math.inf
    t = np.float32(2.0**21)
    assert t + np.float32(0.1) == t


@pytest.mark.parametrize("name", BLOCKS)
def test_each_block_has_its_time_where_the_adapter_writes_it(name: str, tmp_path: Path) -> None:
    _, headers = lay_out(Block.named(name), tmp_path)
    flags = [*FLAGS, *WARNINGS, "-ffreestanding", *(f"-I{h}" for h in headers)]
    run([str(zig()), "cc", *flags, "-c", str(INNER), "-o", str(tmp_path / "inner.o")], INNER)


def test_after_two_hours_of_tenths_of_a_second_the_time_is_right(tmp_path: Path) -> None:
    """Seen by a reference that turns: with steps that are added in single precision it is 4.7 s, 0.05 rad, off."""
    with zipfile.ZipFile(fmu("controller", tmp_path)) as archive:
        guid = archive.read("modelDescription.xml").decode().partition('guid="')[2].partition('"')[0]
        library = archive.extract(next(n for n in archive.namelist() if n.endswith("controller.so")), tmp_path)
    h, n, rate = 0.1, 72_000, 0.01
    with Instance("controller", opened(Path(library)), guid=guid) as it:
        it.set("reference", "rate")
        it.set("Omega_d0", [0.0, 0.0, rate])
        it.initialize()
        for i in range(n):
            it.step(i * h, h)
        found = it.get("attitude_error")
    turned = rate * n * h
    assert found == pytest.approx(abs(math.remainder(turned, 2.0 * math.pi)), abs=1e-4)


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("qemu-system-arm") is None, reason="QEMU is not installed")
def test_a_processor_without_double_precision_gives_the_same_bits(tmp_path: Path) -> None:
    from evidence.single.make import on_board

    flight = on_board("paper_no_singularity", "allocator", "allocator", {"allocator": fmu("allocator", tmp_path)})
    assert not flight.differing
    assert flight.samples == 601
    assert not flight.firmware.doubles
