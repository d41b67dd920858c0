"""The firmware on an emulated Cortex-M7: the flight code there gives the bits of the native FMU here."""

from __future__ import annotations

import numpy as np

from evidence.processor.emulator import Emulator
from evidence.processor.firmware import PROGRAMS, build
from tests.machine import require
from tests.native.driver import Instance

from .test_link import asked, flown

STEPS = 10


def test_the_controller_on_an_emulated_cortex_m7_has_the_bits_of_the_native_fmu(tmp_path):
    require(*PROGRAMS)
    with Instance("controller") as block:
        direct = flown(block, STEPS)
    with (
        Emulator(build("controller", tmp_path).elf) as board,
        asked(board.address, "tcp", time_out=30.0) as block,
    ):
        np.testing.assert_array_equal(flown(block, STEPS), direct)
        assert block.get("link_damaged_frames") == 0
