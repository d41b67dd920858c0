"""The FMUs' own memcpy, memset and memcmp, as they are for processors of 64 and of 32 bits, against bytes of Python."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fmus.native.toolchain import FREESTANDING, compiler
from tests.once import built

PROTOTYPES = """\
#include <stddef.h>
void *own_memcpy(void *restrict to, const void *restrict from, size_t n);
void *own_memset(void *to, int byte, size_t n);
int own_memcmp(const void *left, const void *right, size_t n);
"""
SIZES = (*range(70), 96, 104, 127, 128, 129, 160, 300)
ROOM = 512


@pytest.fixture(scope="module", params=[8, 4], ids=["64 bits", "32 bits"])
def lib(request: pytest.FixtureRequest) -> ctypes.CDLL:
    text = PROTOTYPES + (FREESTANDING / "memory.c").read_text("utf-8")
    for written, own in (("(memcpy)", "own_memcpy"), ("(memset)", "own_memset"), ("int memcmp", "int own_memcmp")):
        assert written in text
        text = text.replace(written, own)
    text = text.replace("__SIZEOF_POINTER__ == 8", f"{request.param} == 8")
    command = [sys.executable, "-m", "ziglang", "cc", "-std=c11", "-O2", "-fno-builtin", "-ffreestanding", "-shared"]
    command += [f"-I{FREESTANDING}", "-fPIC"]

    def make(path: Path) -> None:
        source = path.with_suffix(".c")
        source.write_text(text, "utf-8")
        subprocess.run([*command, str(source), "-o", str(path)], check=True)

    library = ctypes.CDLL(str(built(f"memory_{request.param}.so", [compiler(), *command, text, FREESTANDING], make)))
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    library.own_memcpy.argtypes, library.own_memset.argtypes = [pointer, pointer, size], [pointer, ctypes.c_int, size]
    library.own_memcmp.argtypes = [pointer, pointer, size]
    return library


def place(array: np.ndarray, offset: int) -> int:
    return int(array.ctypes.data) + offset


@pytest.mark.parametrize("to", range(5))
@pytest.mark.parametrize("start", [0, 1, 4])
def test_a_copy_has_its_bytes_and_touches_no_other(lib: ctypes.CDLL, to: int, start: int) -> None:
    source = np.random.default_rng(to).integers(0, 256, ROOM, np.uint8)
    for n in SIZES:
        target = np.full(ROOM, 7, np.uint8)
        expected = target.copy()
        expected[to : to + n] = source[start : start + n]
        lib.own_memcpy(place(target, to), place(source, start), n)
        assert target.tobytes() == expected.tobytes(), n


@pytest.mark.parametrize("byte", [0, 1, 0x5A, 255, 256 + 3, -1])
def test_a_fill_has_the_byte_and_touches_no_other(lib: ctypes.CDLL, byte: int) -> None:
    for n in SIZES:
        target = np.full(ROOM, 7, np.uint8)
        expected = target.copy()
        expected[3 : 3 + n] = byte & 255
        lib.own_memset(place(target, 3), byte, n)
        assert target.tobytes() == expected.tobytes(), n


def test_a_comparison_has_the_sign_of_the_first_byte_that_differs(lib: ctypes.CDLL) -> None:
    left = np.random.default_rng(1).integers(0, 256, ROOM, np.uint8)
    for n in SIZES:
        right = np.roll(left, 2)
        assert lib.own_memcmp(place(left, 1), place(right, 3), n) == 0
        for at in {0, n // 2, n - 1} if n else ():
            for byte in (0, 128, 255):
                right[3 + at :] = 255 - right[3 + at :]  # what comes after the first difference has no say
                right[3 + at] = byte
                difference = int(left[1 + at]) - byte
                assert (
                    np.sign(lib.own_memcmp(place(left, 1), place(right, 3), n)) == np.sign(difference) or not difference
                )
                right = np.roll(left, 2)
