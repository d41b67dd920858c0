"""Looks at the libraries of an FMU and at what it asks of its host, without running them.

Tests: tests/orchestration/acceptance/test_check.py, test_binaries.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..fmu.archive import libraries
from ..fmu.co_simulation import CoSimulation
from ..fmu.model import Model
from ..swap.findings import Finding
from . import binaries
from .loader import Unresolved, unresolved
from .machine import wrong


def files(folder: Path) -> dict[str, Path]:
    """Returns the files under binaries/ of an unpacked FMU, by their names in it."""
    found = (path for path in sorted(folder.glob("binaries/**/*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path for path in found}


def look(description: Any, model: Model, files: Mapping[str, Path], findings: list[Finding]) -> None:
    """Adds findings on its libraries and what it asks of its host; `files` are those of its binaries."""
    kind = CoSimulation.of(description, {name.split("/")[1] for name in files if name.count("/") > 1})
    offered: dict[str, str] = {}
    for name in sorted(files):
        platform, _, file = name.removeprefix("binaries/").partition("/")
        if file.rpartition(".")[0] == kind.identifier:
            offered[platform] = name
    here, wanted = kind.platform, kind.library
    if wanted in files:
        others = ", ".join(name for name in offered if name != here)
        text = f"{here}, this platform" + (f"; also {others}" if others else "; no other")
        findings.append(Finding("ok", "binary", text))
    else:
        text = f"none for this platform: expected {wanted}, found {libraries(files, here)}"
        findings.append(Finding("error", "binary", text, f"build it for {here}, or run on one of its platforms"))
    try:
        for platform, name in offered.items():
            _library(platform, platform == here, model, files[name].read_bytes(), files, findings)
    except binaries.ReaderMissing:
        text = (
            "whether the libraries have FMI's functions, and what they need, is not looked at without the package lief"
        )
        findings.append(Finding("warning", "functions", text, "pip install 'attitude-cosim[check]'"))
    if kind.needs_tool:
        text = "it needs the tool or the interpreter that made it where it runs (needsExecutionTool)"
        findings.append(Finding("warning", "host", text, "install that tool on every machine that runs it"))
    if kind.alone:
        findings.append(Finding("note", "host", "one instance in a process only; in a process of its own it is alone"))
    if kind.steps_inside or not kind.variable_step:
        try:
            step = kind.sample_time()
        except InputError as error:
            findings += [Finding("error", "step", wrong.text, wrong.remedy) for wrong in error.problems]
            return
        if step is not None:
            what = "steps inside by" if kind.steps_inside else "cannot vary its step of"
            text = f"it {what} {float(step):.10g} s; a scenario's step has to divide it or be a multiple of it"
            findings.append(Finding("note", "step", text))
        else:
            text = "it cannot vary its step, and does not say which it is; the scenario's is taken"
            findings.append(Finding("warning", "step", text, "declare DefaultExperiment.stepSize in the FMU"))


def _library(
    platform: str, here: bool, model: Model, data: bytes, files: Mapping[str, Path], findings: list[Finding]
) -> None:
    if built := wrong(platform, data, here):
        text, level = f"{platform}: {built}", "error" if here else "warning"
        findings.append(Finding(level, "binary", text, f"build it for {platform}"))  # type: ignore[arg-type]
        return
    try:
        library = binaries.read(data)
    except binaries.Unreadable as error:
        level, remedy = (
            ("error", "build it anew for this platform")
            if here
            else ("warning", "build it anew, if that platform is used")
        )
        findings.append(Finding(level, "binary", f"{platform}: {error}", remedy))  # type: ignore[arg-type]
        return
    missing = [name for name in binaries.FUNCTIONS[model.prefix] if name not in library.exported]
    needed = [name for name in missing if name in binaries.called(model)]
    if needed:
        text = f"{platform}: the library lacks {_some(needed)}"
        remedy = f"export every function of FMI {model.fmi}, by its plain name"
        findings.append(Finding("error" if here else "warning", "functions", text, remedy))
    elif missing:
        text = f"{platform}: the library lacks {_some(missing)}, which are not called here, but which FMI demands"
        findings.append(Finding("warning", "functions", text, "export them; they may return an error"))
    else:
        findings.append(Finding("ok", "functions", f"{platform}: all of FMI {model.fmi} are there"))
    if here:
        beside = {n.rpartition("/")[2]: d for n, d in files.items() if n.startswith(f"binaries/{platform}/")}
        _loader(platform, unresolved(library, beside), findings)


def _loader(platform: str, left: Unresolved, findings: list[Finding]) -> None:
    if left.libraries:
        text = f"{platform}: needs libraries that this machine has not: {', '.join(left.libraries)}"
        findings.append(
            Finding(
                "error",
                "symbols",
                text,
                "link them statically, or put them beside the library with an rpath of $ORIGIN",
            )
        )
    if left.symbols:
        text = f"{platform}: needs symbols that no library gives it: {_some(left.symbols)}"
        findings.append(Finding("error", "symbols", text, "link the library that defines them, or add the source"))
    if left.versions:
        text = f"{platform}: needs a newer C library than this machine has: {', '.join(left.versions)}"
        findings.append(Finding("error", "symbols", text, "build it on an older system, or link statically"))
    if left.host:
        text = f"{platform}: takes {len(left.host)} functions of Python from the process that loads it"
        findings.append(Finding("warning", "symbols", text, "run it in a process that holds Python, as is done here"))
    if not (left.libraries or left.symbols or left.versions or left.host):
        findings.append(Finding("ok", "symbols", f"{platform}: all that it needs is there"))


def _some(names: list[str]) -> str:
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
