"""The FMUs' own sin to expm1 against numbers of more digits, and against the C library where it differs in nothing."""

from __future__ import annotations

import ctypes
import math
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from fmus.native.toolchain import FLAGS, FREESTANDING, compiler
from tests.once import built

# math's functions are within a unit in the last place; two are allowed here.
ULPS = 2.5


@pytest.fixture(scope="module")
def lib() -> ctypes.CDLL:
    text = (FREESTANDING / "elementary.c").read_text("utf-8")
    names = ("sin", "cos", "log", "log1p", "exp", "expm1")
    wrappers = "".join(f"double own_{n}(double x);\ndouble own_{n}(double x) {{ return {n}(x); }}\n" for n in names)
    wrappers += "double own_atan2(double y, double x);\ndouble own_atan2(double y, double x) { return atan2(y, x); }\n"
    command = [sys.executable, "-m", "ziglang", "cc", *(f for f in FLAGS if not f.startswith("-fvisibility"))]
    command += ["-ffreestanding", f"-I{FREESTANDING}", "-shared"]

    def make(path: Path) -> None:
        source = path.with_suffix(".c")
        source.write_text(text + wrappers, "utf-8")
        subprocess.run([*command, str(source), str(FREESTANDING / "memory.c"), "-o", str(path)], check=True)

    path = built("elementary.so", [compiler(), *command, text + wrappers, FREESTANDING], make)
    library = ctypes.CDLL(str(path))
    for name in (*names, "atan2"):
        getattr(library, f"own_{name}").restype = ctypes.c_double
        getattr(library, f"own_{name}").argtypes = [ctypes.c_double] * (2 if name == "atan2" else 1)
    return library


def _points(*ranges: tuple[float, float]) -> list[float]:
    rng = np.random.default_rng(0)
    return [float(x) for low, high in ranges for x in rng.uniform(low, high, 4000)]


def _check(own: object, reference: object, points: list[float]) -> None:
    for x in points:
        expected = reference(x)
        assert abs(own(x) - expected) <= ULPS * math.ulp(expected), x


def test_the_largest_numbers_have_logarithms_and_the_least_normal_ones_are_exponentials(lib: ctypes.CDLL) -> None:
    for name in ("log", "log1p"):
        _check(getattr(lib, f"own_{name}"), getattr(math, name), [1.27e308, 1.28e308, 1.5e308, sys.float_info.max])
    _check(lib.own_exp, math.exp, [-708.39, -708.2, -708.06, -708.04, -700.0])


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine(lib: ctypes.CDLL, name: str) -> None:
    points = _points((-1, 1), (-7, 7), (-1e3, 1e3), (-1.6e6, 1.6e6))
    points += [0.0, -0.0, 1e-300, 1e-9, math.pi, math.pi / 2, 1e5 * math.pi, *(k * math.pi / 4 for k in range(-50, 50))]
    _check(getattr(lib, f"own_{name}"), getattr(math, name), points)
    assert math.isnan(getattr(lib, f"own_{name}")(math.inf))
    assert math.isnan(getattr(lib, f"own_{name}")(math.nan))


def test_arc_tangent_in_all_quadrants(lib: ctypes.CDLL) -> None:
    rng = np.random.default_rng(1)
    for y, x in rng.normal(size=(5000, 2)) * 10.0 ** rng.uniform(-9, 9, (5000, 2)):
        expected = math.atan2(y, x)
        assert abs(lib.own_atan2(y, x) - expected) <= ULPS * math.ulp(expected), (y, x)
    special = (0.0, -0.0, 1.0, -1.0, math.inf, -math.inf)
    for y in special:
        for x in special:
            if math.isinf(x) and math.isinf(y) and x < 0:
                continue  # 3 pi/4 to rounding, below
            found, expected = lib.own_atan2(y, x), math.atan2(y, x)
            assert abs(found - expected) <= ULPS * math.ulp(expected)
            assert math.copysign(1.0, found) == math.copysign(1.0, expected), (y, x)
    assert abs(lib.own_atan2(math.inf, -math.inf) - 0.75 * math.pi) < 1e-15


@pytest.mark.parametrize(
    ("name", "ranges", "special"),
    [
        (
            "log",
            ((1e-300, 1e-3), (0.5, 2.0), (0.999, 1.001), (1.0, 1e300)),
            (1.0, 2.0, 0.5, 1e-307, 1.7e308, math.sqrt(2.0)),
        ),
        (
            "log1p",
            ((-0.999999, 0.0), (-1e-6, 1e-6), (0.0, 3.0), (1.0, 1e16), (1.0, 1e300)),
            (0.0, -1.0 + 1e-15, 1e-300, 1.7e308),
        ),
        ("exp", ((-1.0, 1.0), (-50.0, 50.0), (-708.0, 709.7)), (0.0, -1e-300, 1.0, 709.78)),
        ("expm1", ((-1e-6, 1e-6), (-1.0, 1.0), (-50.0, 50.0), (0.0, 709.7)), (0.0, 1e-300, -1e-300, -100.0)),
    ],
)
def test_logarithm_and_exponential(
    lib: ctypes.CDLL, name: str, ranges: tuple[tuple[float, float], ...], special: tuple[float, ...]
) -> None:
    _check(getattr(lib, f"own_{name}"), getattr(math, name), [*_points(*ranges), *special])


def test_edges(lib: ctypes.CDLL) -> None:
    assert lib.own_exp(1000.0) == math.inf
    assert lib.own_exp(-1000.0) == 0.0
    assert lib.own_expm1(-1000.0) == -1.0
    assert lib.own_expm1(1000.0) == math.inf
    assert lib.own_log(0.0) == -math.inf
    assert lib.own_log1p(-1.0) == -math.inf
    assert lib.own_log(math.inf) == lib.own_log1p(math.inf) == math.inf
    for name in ("log", "log1p", "exp", "expm1"):
        assert math.isnan(getattr(lib, f"own_{name}")(math.nan))
    assert math.isnan(lib.own_log(-1.0))
    assert math.isnan(lib.own_log1p(-2.0))


def test_pi_over_two_is_split_exactly() -> None:
    text = (FREESTANDING / "elementary.c").read_text("utf-8")
    parts = [Fraction(float(text.split(f"part{k} = ")[1].split(";")[0])) for k in (1, 2, 3)]
    half_pi = Fraction("3.14159265358979323846264338327950288419716939937510582097494459") / 2
    assert abs(sum(parts) - half_pi) < Fraction(1, 10**36)
