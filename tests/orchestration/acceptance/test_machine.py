"""For which processor a library is built: headers as the formats' specifications number the processors."""

from __future__ import annotations

import struct

import pytest

from orchestration.acceptance.check import check
from orchestration.acceptance.machine import machines, wrong
from tests.orchestration import fmus


def elf(number: int, big: bool = False) -> bytes:
    order = ">" if big else "<"
    ident = b"\x7fELF" + bytes([2, 2 if big else 1, 1]) + bytes(9)
    return ident + struct.pack(f"{order}HH", 3, number) + bytes(44)


def pe(number: int) -> bytes:
    return b"MZ" + bytes(58) + struct.pack("<I", 0x80) + bytes(64) + b"PE\0\0" + struct.pack("<H", number) + bytes(20)


def fat(*numbers: int) -> bytes:
    parts = b"".join(struct.pack(">5I", number, 0, 0, 0, 0) for number in numbers)
    return b"\xca\xfe\xba\xbe" + struct.pack(">I", len(numbers)) + parts


@pytest.mark.parametrize(
    ("platform", "data", "fits"),
    [
        ("linux64", elf(62), True),  # EM_X86_64
        ("linux64", elf(183), False),  # EM_AARCH64
        ("linux64", elf(40), False),  # EM_ARM
        ("linux64", pe(0x8664), False),
        ("aarch64-linux", elf(183), True),
        ("x86_64-linux", elf(183), False),
        ("win64", pe(0x8664), True),  # IMAGE_FILE_MACHINE_AMD64
        ("win64", pe(0xAA64), False),
        ("darwin64", fat(0x01000007, 0x0100000C), True),  # CPU_TYPE_X86_64 and CPU_TYPE_ARM64
        ("darwin64", elf(62), False),
        ("c-code", elf(62), True),
    ],
)
def test_a_library_of_another_processor_or_system_than_its_folder_is_told(platform, data, fits):
    assert (wrong(platform, data) == "") == fits


def test_a_header_that_ends_early_is_no_library():
    assert machines(b"MZ") is None
    assert machines(b"\x7fELF") is None
    assert machines(elf(62, big=True)) == ("ELF", ["x86_64"])


def test_an_arm_library_under_linux64_is_an_error_of_the_check_that_names_it(tmp_path):
    fmu = fmus.write(tmp_path / "motor.fmu", fmus.description("motor"), elf(183), folder="linux64")
    findings, _ = check(fmu, str(fmus.write(tmp_path / "ours.fmu", fmus.description("motor"), fmus.library())))
    told = [f for f in findings if "64-bit ARM" in f.text]
    assert told
    assert told[0].text == "linux64: the library is ELF for 64-bit ARM, expected ELF for x86_64"
    assert told[0].level in ("error", "warning")
