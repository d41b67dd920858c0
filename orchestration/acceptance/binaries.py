"""What the binaries of an FMU export and need, read from their tables without running them.

ELF (Linux) and PE (Windows) are read here, by the layouts of their formats; of Mach-O (macOS) only that
it is there is known. loader.py looks for the libraries that they need.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

from ..fmu.model import Model
from ..fmu.types import NATIVES

_NAMES = {
    "fmi2": (
        "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode "
        "ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean "
        "SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate "
        "GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus "
        "GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus"
    ),
    "fmi3": (
        "GetVersion SetDebugLogging InstantiateCoSimulation FreeInstance EnterInitializationMode ExitInitializationMode "
        "EnterEventMode EnterStepMode Terminate Reset EnterConfigurationMode ExitConfigurationMode "
        "GetNumberOfVariableDependencies GetVariableDependencies GetFMUState SetFMUState FreeFMUState "
        "SerializedFMUStateSize SerializeFMUState DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative "
        "GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction "
        "SetShiftDecimal SetShiftFraction EvaluateDiscreteStates UpdateDiscreteStates GetOutputDerivatives DoStep "
    )
    + " ".join(f"{verb}{native.function}" for native in NATIVES[3].values() for verb in ("Get", "Set"))
    + " GetBinary SetBinary GetClock SetClock",
}
FUNCTIONS = {prefix: tuple(dict.fromkeys(prefix + name for name in names.split())) for prefix, names in _NAMES.items()}
"""All functions that a version of FMI demands of a co-simulation FMU."""
_CALLED = {
    "fmi2": (
        "GetTypesPlatform GetVersion Instantiate FreeInstance SetupExperiment EnterInitializationMode "
        "ExitInitializationMode Terminate GetReal GetInteger GetBoolean SetReal SetInteger SetBoolean SetString DoStep"
    ),
    "fmi3": ("InstantiateCoSimulation FreeInstance EnterInitializationMode ExitInitializationMode Terminate DoStep"),
}


def called(model: Model) -> set[str]:
    """The functions without which an FMU does not run here: of FMI 3.0, those of the types that it has."""
    names = set(_CALLED[model.prefix].split())
    if model.prefix == "fmi3":
        ports = model.of("input", "output", "parameter")
        names |= {("Get" if v.causality == "output" else "Set") + v.native.function for v in ports if v.native}
    return {model.prefix + name for name in names}


class Unreadable(ValueError):
    """The file is no library of a kind that is understood; the message says what it is."""


@dataclass
class Library:
    """The dynamic tables of a shared library."""

    kind: str
    machine: str
    exported: set[str] = field(default_factory=set)
    undefined: set[str] = field(default_factory=set)
    """Symbols that it must find elsewhere."""
    needed: list[str] = field(default_factory=list)
    """Libraries that it asks for by name."""
    search: list[str] = field(default_factory=list)
    """Folders in which it asks for them to be looked for."""
    versions: set[str] = field(default_factory=set)
    """Versions of symbols that it needs, such as GLIBC_2.17."""


def read(data: bytes) -> Library:
    """The tables of a library. Raises Unreadable."""
    try:
        if data[:4] == b"\x7fELF":
            return _elf(data)
        if data[:2] == b"MZ":
            return _pe(data)
    except (struct.error, IndexError, ValueError) as error:
        if isinstance(error, Unreadable):
            raise
        raise Unreadable("its tables are damaged") from None
    if data[:4] in (b"\xca\xfe\xba\xbe", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe"):
        return Library("Mach-O", "")
    raise Unreadable("it is no shared library")


def _text(data: bytes, start: int) -> str:
    return data[start : data.index(b"\0", start)].decode("utf-8", "replace")


# ---------------------------------------------------------------- ELF

_MACHINES = {62: "x86_64", 183: "aarch64", 3: "x86", 40: "arm", 243: "riscv64"}
_DYNSYM, _DYNAMIC, _VERNEED = 11, 6, 0x6FFFFFFE
_NEEDED, _RPATH, _RUNPATH = 1, 15, 29
_ENTRIES_MAX = 1000
"""Libraries of which versions are asked for."""


def _elf(data: bytes) -> Library:
    if data[4] != 2 or data[5] != 1:
        raise Unreadable("it is an ELF library of 32 bits or of the other byte order")
    kind, machine = struct.unpack_from("<HH", data, 16)
    if kind != 3:
        raise Unreadable("it is an ELF file, but no shared library")
    (offset,) = struct.unpack_from("<Q", data, 40)
    size, count = struct.unpack_from("<HH", data, 58)
    # name, type, flags, addr, offset, size, link, info, align, entsize
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, offset + i * size) for i in range(count)]
    library = Library("ELF", _MACHINES.get(machine, str(machine)))
    for section in sections:
        strings = sections[section[6]][4] if section[6] < len(sections) else 0
        if section[1] == _DYNSYM:
            _elf_symbols(data, section, strings, library)
        elif section[1] == _DYNAMIC:
            _elf_dynamic(data, section, strings, library)
        elif section[1] == _VERNEED:
            _elf_versions(data, section, strings, library)
    return library


def _elf_symbols(data: bytes, section: tuple[int, ...], strings: int, library: Library) -> None:
    for start in range(section[4] + 24, section[4] + section[5], 24):
        name, info, other, index, _, _ = struct.unpack_from("<IBBHQQ", data, start)
        text = _text(data, strings + name)
        weak = info >> 4 == 2
        if index == 0:
            if not weak and text:
                library.undefined.add(text)
        elif other & 3 in (0, 3):  # default or protected visibility
            library.exported.add(text)


def _elf_dynamic(data: bytes, section: tuple[int, ...], strings: int, library: Library) -> None:
    for start in range(section[4], section[4] + section[5], 16):
        tag, value = struct.unpack_from("<QQ", data, start)
        if tag == _NEEDED:
            library.needed.append(_text(data, strings + value))
        elif tag in (_RPATH, _RUNPATH):
            library.search += _text(data, strings + value).split(":")


def _elf_versions(data: bytes, section: tuple[int, ...], strings: int, library: Library) -> None:
    at = section[4]
    for _ in range(min(section[7], _ENTRIES_MAX)):
        _, count, _, first, following = struct.unpack_from("<HHIII", data, at)
        entry = at + first
        for _ in range(count):
            _, _, _, name, after = struct.unpack_from("<IHHII", data, entry)
            library.versions.add(_text(data, strings + name))
            entry += after
            if after == 0:
                break
        at += following
        if following == 0:
            break


# ---------------------------------------------------------------- PE


_SECTIONS_MAX = 96
"""What Windows loads."""


def _pe(data: bytes) -> Library:
    (header,) = struct.unpack_from("<I", data, 60)
    if data[header : header + 4] != b"PE\0\0":
        raise Unreadable("it is no Windows library")
    machine, count = struct.unpack_from("<HH", data, header + 4)
    if count > _SECTIONS_MAX:
        raise Unreadable("its tables are damaged")
    optional, magic = header + 24, struct.unpack_from("<H", data, header + 24)[0]
    directories = optional + (112 if magic == 0x20B else 96)
    sections = optional + struct.unpack_from("<H", data, header + 20)[0]
    spans = [struct.unpack_from("<IIII", data, sections + 40 * i + 8) for i in range(count)]

    def place(address: int) -> int:
        for size, start, raw_size, raw in spans:
            if start <= address < start + max(size, raw_size):
                return address - start + raw
        raise Unreadable("its tables are damaged")

    library = Library("PE", {0x8664: "x86_64", 0xAA64: "aarch64", 0x14C: "x86"}.get(machine, hex(machine)))
    exports, imports = (struct.unpack_from("<I", data, directories + 8 * i)[0] for i in range(2))
    if exports:
        table = place(exports)
        number, names = struct.unpack_from("<I", data, table + 24)[0], struct.unpack_from("<I", data, table + 32)[0]
        if number > len(data) // 4:
            raise Unreadable("its tables are damaged")
        for i in range(number):
            (name,) = struct.unpack_from("<I", data, place(names) + 4 * i)
            library.exported.add(_text(data, place(name)))
    if imports:
        at = place(imports)
        while name := struct.unpack_from("<I", data, at + 12)[0]:
            library.needed.append(_text(data, place(name)))
            at += 20
    return library
