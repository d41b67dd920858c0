"""Reads what the libraries of an FMU export and need from their tables, without running them.

The package lief reads the tables of ELF (Linux), PE (Windows) and Mach-O (macOS).
loader.py looks for the libraries that they need."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

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
        "GetVersion SetDebugLogging InstantiateCoSimulation FreeInstance EnterInitializationMode "
        "ExitInitializationMode EnterEventMode EnterStepMode Terminate Reset EnterConfigurationMode "
        "ExitConfigurationMode GetNumberOfVariableDependencies GetVariableDependencies GetFMUState SetFMUState "
        "FreeFMUState SerializedFMUStateSize SerializeFMUState DeserializeFMUState GetDirectionalDerivative "
        "GetAdjointDerivative GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction "
        "SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction EvaluateDiscreteStates "
        "UpdateDiscreteStates GetOutputDerivatives DoStep "
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
    """Returns the functions without which an FMU does not run here: of FMI 3.0, those of the types that it has."""
    names = set(_CALLED[model.prefix].split())
    if model.prefix == "fmi3":
        ports = model.of("input", "output", "parameter")
        names |= {("Get" if v.causality == "output" else "Set") + v.native.function for v in ports if v.native}
    return {model.prefix + name for name in names}


class Unreadable(ValueError):
    """The file is no library of a kind that is understood; the message says what it is."""


class ReaderMissing(Exception):
    """The package that reads the tables is not installed."""


@dataclass
class Library:
    """The dynamic tables of a shared library."""

    kind: str
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
    """Returns the tables of a library, of several in one file those of the first.

    Raises Unreadable, and ReaderMissing where lief is not installed.
    """
    kind = next((kind for magic, kind in _MAGIC.items() if data.startswith(magic)), None)
    if kind is None:
        raise Unreadable("it is no shared library")
    try:
        import lief  # here, since it takes long and few commands look at libraries  # noqa: PLC0415
    except ModuleNotFoundError:
        raise ReaderMissing from None
    lief.logging.disable()
    getattr(lief, "disable_leak_warning", lambda: None)()  # which it would print at the end
    library = _library(kind, lief.parse, data)
    if isinstance(library, str):
        raise Unreadable(library)
    return library


_MAGIC = {b"\x7fELF": "ELF", b"MZ": "PE"}
_MAGIC |= dict.fromkeys((b"\xca\xfe\xba\xbe", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe"), "Mach-O")


def _is_whole(parsed: Any, size: int) -> bool:
    """Returns whether a file of this size holds all sections that it names. Of Mach-O lief looks itself."""
    sections = [s for s in parsed.sections if getattr(s, "type", None) is None or s.type.name != "NOBITS"]
    told = getattr(parsed.header, "numberof_sections", len(parsed.sections))
    some = bool(told or getattr(parsed, "segments", ()))
    return some and len(parsed.sections) == told and all(s.offset + s.size <= size for s in sections)


def _library(kind: str, parse: Callable[[bytes], Any], data: bytes) -> Library | str:
    """Returns the tables, or why there are none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of numbers that the formats do not know
        parsed = parse(data)
        if parsed is None or (kind != "Mach-O" and not _is_whole(parsed, len(data))):
            return "its tables are damaged"
        if kind == "ELF" and parsed.header.file_type.name != "DYN":
            return "it is an ELF file, but no shared library"
        return {"ELF": _elf, "PE": _pe, "Mach-O": _mach_o}[kind](parsed)


def _elf(parsed: Any) -> Library:
    library = Library("ELF", needed=list(parsed.libraries))
    for symbol in parsed.dynamic_symbols:
        if symbol.shndx == 0:
            if symbol.name and symbol.binding.name != "WEAK":
                library.undefined.add(symbol.name)
        elif symbol.visibility.name not in ("HIDDEN", "INTERNAL"):
            library.exported.add(symbol.name)
    for entry in parsed.dynamic_entries:
        library.search += getattr(entry, "paths", [])  # of an rpath or a runpath
    for requirement in parsed.symbols_version_requirement:
        library.versions |= {version.name for version in requirement.get_auxiliary_symbols()}
    return library


def _pe(parsed: Any) -> Library:
    exported = {function.name for function in parsed.exported_functions}
    return Library("PE", exported, needed=[i.name for i in parsed.imports])


def _mach_o(parsed: Any) -> Library:
    exported = {symbol.name.removeprefix("_") for symbol in parsed.exported_symbols}
    return Library("Mach-O", exported, needed=[library.name for library in parsed.libraries])
