"""The firmware on an emulated Cortex-M7: the flight code there gives the bits of the native FMU here."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

from fmus import link
from fmus.native.toolchain import FREESTANDING
from tests.kept import kept
from tests.native.driver import Instance

from . import devices
from .test_link import asked, flown

GCC, QEMU = "arm-none-eabi-gcc", "qemu-system-arm"
pytestmark = pytest.mark.skipif(
    shutil.which(GCC) is None or shutil.which(QEMU) is None,
    reason=f"needs {GCC} and {QEMU} (Debian: gcc-arm-none-eabi, libnewlib-arm-none-eabi, qemu-system-arm)",
)
OPTIONS = (
    *("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-std=c11", "-O2", "-ffp-contract=off"),
    *("-fno-math-errno", "-Wall", "-Wextra", "-Werror", "-nostartfiles", "-Wl,--gc-sections"),
)
FIRMWARE = ("main.c", "board_uart.c", "startup_cortex_m.c")
STEPS = 10


def firmware(block: str) -> Path:
    """The program of a native block for the board, with our own elementary functions."""
    with tempfile.TemporaryDirectory() as folder:
        sources, includes = devices.laid_out(block, Path(folder))
        sources += [*(link.FIRMWARE / name for name in FIRMWARE), FREESTANDING / "elementary.c"]
        memory = link.FIRMWARE / "cortex_m.ld"
        folders = [f"-I{path}" for path in (FREESTANDING, *includes)]

        def build(path: Path) -> None:
            subprocess.run([GCC, *OPTIONS, *folders, *map(str, sources), "-T", memory, "-o", path], check=True)

        return kept(f"{block}.elf", [GCC, *OPTIONS, *sources, *includes, memory, FREESTANDING], build)


def test_the_controller_on_an_emulated_cortex_m7_has_the_bits_of_the_native_fmu():
    with Instance("controller") as block:
        direct = flown(block, STEPS)
    port = devices.free_port()
    serial = ["-serial", f"tcp:127.0.0.1:{port},server=on,wait=off,nodelay=on"]
    command = [QEMU, "-M", "mps2-an500", "-display", "none", "-monitor", "none", *serial]
    board = subprocess.Popen([*command, "-kernel", firmware("controller")])
    try:
        with asked(f"127.0.0.1:{port}", "tcp", time_out=30.0) as block:
            np.testing.assert_array_equal(flown(block, STEPS), direct)
            assert block.get("link_damaged_frames") == 0
    finally:
        board.kill()
        board.wait()
