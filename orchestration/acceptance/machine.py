"""Reads for which processor a library is built, from its first bytes, and which one a platform's folder asks for.

Tests: tests/orchestration/acceptance/test_machine.py.
"""

from __future__ import annotations

import struct

from ..fmu.platforms import PLATFORM_3

_ELF = {3: "x86", 40: "arm", 62: "x86_64", 183: "aarch64", 243: "riscv64"}
_PE = {0x14C: "x86", 0x1C4: "arm", 0x8664: "x86_64", 0xAA64: "aarch64"}
_MACH_O = {7: "x86", 12: "arm", 0x01000007: "x86_64", 0x0100000C: "aarch64"}
_FOLDERS = {
    "linux32": ("ELF", "x86"),
    "linux64": ("ELF", "x86_64"),
    "win32": ("PE", "x86"),
    "win64": ("PE", "x86_64"),
    "darwin64": ("Mach-O", "x86_64", "aarch64"),
}
_SYSTEMS = {"linux": "ELF", "windows": "PE", "darwin": "Mach-O"}
_WORDS = {"aarch64": "64-bit ARM", "arm": "32-bit ARM", "x86_64": "x86_64", "x86": "32-bit x86", "riscv64": "RISC-V"}


def machines(data: bytes) -> tuple[str, list[str]] | None:
    """Returns the format of a library and its processors, several of a Mach-O; None where it is no library."""
    try:
        if data.startswith(b"\x7fELF"):
            order = "<" if data[5] == 1 else ">"
            number = struct.unpack_from(f"{order}H", data, 18)[0]
            return "ELF", [_ELF.get(number, f"processor {number} of ELF")]
        if data.startswith(b"MZ"):
            number = struct.unpack_from("<H", data, struct.unpack_from("<I", data, 0x3C)[0] + 4)[0]
            return "PE", [_PE.get(number, f"processor {number:#x} of PE")]
        if data.startswith(b"\xca\xfe\xba\xbe"):
            count = min(struct.unpack_from(">I", data, 4)[0], 16)
            found = [struct.unpack_from(">I", data, 8 + 20 * i)[0] for i in range(count)]
        elif data[:4] in (b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe"):
            found = [struct.unpack_from("<I", data, 4)[0]]
        else:
            return None
    except (struct.error, IndexError):
        return None
    return "Mach-O", [_MACH_O.get(number, f"processor {number:#x} of Mach-O") for number in found]


def wrong(platform: str, data: bytes, here: bool = False) -> str:
    """Returns for what a library is built where that is not its folder's platform; empty where it is, or unknown.

    `here`: it is the platform of this machine, whose processor counts whatever the folder's name.
    """
    found = machines(data)
    expected = _FOLDERS.get(platform)
    if expected is None and "-" in platform:  # FMI 3.0 and later: processor-system
        processor, _, system = platform.partition("-")
        expected = (_SYSTEMS.get(system, ""), processor)
    if found is None or expected is None or not expected[0]:
        return ""
    kind, built = found
    if here:
        expected = (expected[0], PLATFORM_3.partition("-")[0])
    if kind == expected[0] and set(built) & set(expected[1:]):
        return ""
    names = " and ".join(_WORDS.get(name, name) for name in built)
    wanted = " or ".join(_WORDS.get(name, name) for name in expected[1:])
    return f"the library is {kind} for {names}, expected {expected[0]} for {wanted}"
