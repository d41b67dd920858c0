"""The listing of docs/use/embedding.md is compiled and flown; the laws compile for a processor without an operating
system."""

from __future__ import annotations

import ctypes
import re
import subprocess
import sys
from ctypes import c_bool, c_double
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import allocator
import controller
from fmus.block import natives
from fmus.interface import load
from fmus.native import lay_out
from fmus.native.toolchain import FLAGS, FREESTANDING
from tests.blocks import folder, inputs, parameters, some

from .driver import ROOT

COMMON = ROOT / "fmus" / "native" / "common"
ZIG = [sys.executable, "-m", "ziglang", "cc"]
FLIGHT = [f for f in FLAGS if not f.startswith("-fvisibility")]


SIZES = """size_t sizes(int which)
{
    return which == 0 ? sizeof(ControllerLaw) + sizeof(ControllerState) : sizeof(AllocatorLaw) + sizeof(AllocatorState);
}
"""


def listing() -> str:
    text = (ROOT / "docs" / "use" / "embedding.md").read_text("utf-8")
    (found,) = re.findall(r"```c\n(.*?)```", text, flags=re.DOTALL)
    return found


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The listing with both laws as a library, and the offsets of what the test reaches into."""
    made = tmp_path_factory.mktemp("flight")
    own = "".join(
        f"bool {name};\n"
        for name in (
            "attitude_control_start(AttitudeControl *, const ControllerParameters *, const AllocatorParameters *, "
            "const Measurements *, Fault *)",
            "attitude_control_step(AttitudeControl *, const Measurements *, double, AllocatorOutputs *, Fault *)",
        )
    )
    source = made / "flight.c"
    text = listing().replace(
        "static AllocatorInputs demand",
        own + "size_t size_of(void), sizes(int which);\nstatic AllocatorInputs demand",
        1,
    )
    source.write_text(text + "\nsize_t size_of(void) { return sizeof(AttitudeControl); }\n" + SIZES)
    library = made / "flight.so"
    objects = []
    generated = made / "generated"
    subprocess.run([sys.executable, "-m", "fmus.native", generated, "controller", "allocator"], cwd=ROOT, check=True)
    includes = [f"-I{folder}" for folder in (ROOT, COMMON, generated)]
    for block in ("controller", "allocator"):
        objects.append(made / f"{block}.o")
        law = ROOT / block / "native" / f"{block}.c"
        subprocess.run([*ZIG, *FLIGHT, *includes, "-c", str(law), "-o", str(objects[-1])], check=True)
    subprocess.run([*ZIG, *FLIGHT, *includes, "-shared", str(source), *map(str, objects), "-o", library], check=True)
    lib = ctypes.CDLL(str(library))
    for name in ("attitude_control_start", "attitude_control_step"):
        getattr(lib, name).restype = c_bool
    return lib


@cache
def _record(block: str, causality: str) -> Any:
    """The C structure of a block's ports, from its interface."""
    fields = []
    for v in load(block).of(causality):
        kind: Any = {"real": c_double, "boolean": c_bool}.get(v.type, ctypes.c_int32)
        fields.append((v.name, kind * len(v.elements) if v.shape else kind))
    return type(f"{block}_{causality}", (ctypes.Structure,), {"_fields_": fields})


def _filled(block: str, causality: str, values: Any) -> Any:
    record = _record(block, causality)()
    for v in load(block).of(causality):
        value = getattr(values, v.name)
        if v.shape:
            getattr(record, v.name)[:] = np.ravel(value).tolist()
        else:
            setattr(record, v.name, v.items.index(value) + 1 if v.type == "enumeration" else value)
    return record


def test_the_listing_flies_as_the_reference_does(flight: ctypes.CDLL) -> None:
    rng = np.random.default_rng(7)
    law, actuators = parameters("controller"), parameters("allocator")
    u = inputs("controller", omega_B=[0.04, -0.0789, 0.04])

    class Measurements(ctypes.Structure):
        _fields_ = (("motion", _record("controller", "input")), ("b_B", c_double * 3), ("h_w", c_double))

    def measured(u: Any, b: np.ndarray, h_w: float) -> Any:
        m = Measurements(_filled("controller", "input", u))
        m.b_B[:] = b.tolist()
        m.h_w = h_w
        return m

    def demand(y: Any, b: np.ndarray, h_w: float) -> Any:
        return inputs("allocator", tau_cmd_B=y.tau_cmd_B, b_B=b, omega_B=u.omega_B, h_w=h_w)

    memory = ctypes.create_string_buffer(flight.size_of())
    fault = ctypes.create_string_buffer(64)
    b, h_w = np.array((2e-5, 1e-5, -3e-5)), 1e-3
    assert flight.attitude_control_start(
        memory,
        ctypes.byref(_filled("controller", "parameter", law)),
        ctypes.byref(_filled("allocator", "parameter", actuators)),
        ctypes.byref(measured(u, b, h_w)),
        fault,
    )
    x = controller.start(law, u)
    z = allocator.start(actuators, demand(controller.outputs(x, u, law), b, h_w))
    commands = _record("allocator", "output")()
    for _ in range(50):
        u = inputs("controller", omega_B=rng.normal(scale=0.002, size=3))
        b, h_w = rng.normal(scale=3e-5, size=3), rng.normal(scale=5e-3)
        assert flight.attitude_control_step(
            memory, ctypes.byref(measured(u, b, h_w)), c_double(0.1), ctypes.byref(commands), fault
        )
        x, y = controller.step(x, u, law, 0.1)
        z, expected = allocator.step(z, demand(y, b, h_w), actuators, 0.1)
        assert list(commands.dipole_cmd) == pytest.approx(expected.dipole_cmd.tolist(), rel=1e-9)
        assert commands.wheel_torque_cmd == pytest.approx(expected.wheel_torque_cmd, rel=1e-9)
        assert commands.holding == expected.holding


FLOWN = ("controller", "allocator", "allocator_bounded", "controller_planned", "estimator")


def test_the_page_states_the_memory_of_both_laws(flight: ctypes.CDLL) -> None:
    flight.sizes.restype = ctypes.c_size_t
    stated = f"One controller takes {flight.sizes(0)} bytes and one allocator {flight.sizes(1)} bytes"
    assert stated in (ROOT / "docs" / "use" / "embedding.md").read_text("utf-8")


@pytest.mark.parametrize("block", some(FLOWN, "controller", "allocator"))
def test_the_laws_compile_for_a_processor_without_an_operating_system(block: str, tmp_path: Path) -> None:
    folders = natives(folder(block))
    lay_out(load(block), folder(block), "{}", tmp_path)  # the tables that the build writes
    for law in folders[0].rglob("*.c"):
        command = [*ZIG, "-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7", *FLIGHT, "-ffreestanding"]
        command += [
            *(f"-I{path}" for path in (FREESTANDING, COMMON, tmp_path, *folders)),
            "-c",
            str(law),
            "-o",
            str(tmp_path / "law.o"),
        ]
        subprocess.run(command, check=True)


@pytest.mark.parametrize("block", FLOWN)
def test_the_laws_know_no_fmi_no_memory_and_no_globals(block: str) -> None:
    for law in (folder(block) / "native").rglob("*.c"):
        text = law.read_text("utf-8")
        assert not re.search(r"fmi|malloc|stdio|stdlib|\bgoto\b", text)
        for line in text.splitlines():
            if line.startswith("static") and "(" not in line.split("=")[0]:
                assert line.startswith("static const"), line


def test_a_host_that_never_asks_for_the_bank_compiles_the_estimator_without_its_memory(tmp_path: Path) -> None:
    def text(value: Any) -> str:
        if isinstance(value, str):
            return f'"{value}"'
        return "{" + ", ".join(map(repr, np.ravel(value).tolist())) + "}" if np.ndim(value) else str(value).lower()

    p = replace(parameters("estimator"), bank=True)
    variables = {v.name: (v, getattr(p, v.name)) for v in load("estimator").of("parameter")}
    values = (
        f".{n} = {v.items.index(x) + 1 if v.type == 'enumeration' else text(x)}" for n, (v, x) in variables.items()
    )
    (tmp_path / "size.c").write_text(
        '#include <stdio.h>\n#include "state.h"\n#include "estimator.h"\nint main(void)\n{\n    Fault f = {0};\n'
        f"    const EstimatorParameters p = {{{', '.join(values)}}};\n    const bool taken = estimator_check(&p, &f);\n"
        '    printf("%zu %d %s", sizeof(EstimatorState), taken, taken ? "" : f.name);\n    return 0;\n}\n'
    )
    (tmp_path / "made").mkdir()
    sources, includes = lay_out(load("estimator"), folder("estimator"), "", tmp_path / "made")
    law = [path for path in sources if path.parent == folder("estimator") / "native"]
    told = []
    for more in ([], ["-DESTIMATOR_WITHOUT_BANK"]):
        line = [
            *ZIG,
            *FLAGS,
            "-O0",
            "-Wno-missing-braces",
            *more,
            *(f"-I{include}" for include in (*includes, tmp_path)),
        ]
        files = [str(path) for path in (*law, tmp_path / "size.c")]
        subprocess.run([*line, *files, "-lm", "-o", str(tmp_path / "size")], check=True)
        told.append(subprocess.run([tmp_path / "size"], check=True, capture_output=True, text=True).stdout.split())
    (whole, taken), (small, refused, name) = told
    assert (taken, refused, name) == ("1", "0", "bank")
    assert (int(whole), int(small)) == (60056, 10504)  # as in the page
