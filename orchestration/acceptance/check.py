"""Whether an FMU can take a block's place, before anything of it runs.

Everything comes from its files: modelDescription.xml, and the tables of its libraries. What is said of
ports is what a swap goes by, see `fit`.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from ..errors import InputError
from ..fmu.archive import entries, fmi_version, optional_inputs, refuse_entities, shown
from ..fmu.interfaces import Reference, reference, starts_of
from ..fmu.model import Element, Model, describe
from ..scenario import mapping
from ..swap import rotation
from ..swap.fit import Finding, Fit, Link, fit, model
from ..swap.prepare import sample_time
from ..system import order
from . import binaries


def check(path: Path, as_: str, map_: Path | None = None) -> tuple[list[Finding], Fit | None]:
    """All findings, and how its ports fit where they could be looked at.

    Raises InputError where the FMU, the interface or the mapping cannot be read at all.
    """
    interface = reference(as_, Path.cwd())
    told = mapping.load(map_)[0] if map_ is not None else None
    if not path.exists() or path.is_dir():
        from ..fmu.archive import open_fmu

        open_fmu(path)  # says what is wrong
    names = entries(path)
    with zipfile.ZipFile(path) as archive:
        try:
            files = {
                name: archive.read(name) for name in names if name.startswith("binaries/") and not name.endswith("/")
            }
            xml = archive.read("modelDescription.xml")
        except Exception as error:
            raise InputError(f"{shown(path)} is a damaged zip archive: {error}") from None
    refuse_entities(path, xml)
    findings: list[Finding] = []
    description = _description(path, xml, findings)
    if description is None:
        return findings, None
    _kind(description, files, findings)
    theirs = describe(description, optional_inputs(xml))
    found = fit(interface, theirs, told)
    findings += found.findings
    _start_values(found, starts_of(description, theirs), findings)
    _feedthrough(found, findings)
    _validator(path, findings)
    return findings, found


# ---------------------------------------------------------------- the file


def _description(path: Path, xml: bytes, findings: list[Finding]) -> Any:
    from fmpy.model_description import ValidationError, read_model_description

    if (version := fmi_version(xml) or "unknown") != "2.0":
        findings.append(
            Finding("fault", "FMI", f"version {version}; expected 2.0", "export it for FMI 2.0, co-simulation")
        )
        return None
    try:
        description = read_model_description(str(path))
    except ValidationError as error:
        for problem in error.problems[:10]:
            findings.append(
                Finding("fault", "FMI", f"modelDescription.xml: {problem}", "correct it in the exporting tool")
            )
        try:
            description = read_model_description(str(path), validate=False)
        except Exception:
            return None
    except Exception as error:  # FMPy and lxml raise what they please
        text = f"modelDescription.xml cannot be read: {' '.join(str(error).split())}"
        findings.append(Finding("fault", "FMI", text, "export it anew"))
        return None
    if description.coSimulation is None:
        findings.append(Finding("fault", "FMI", "version 2.0, for model exchange only", "export it for co-simulation"))
        return None
    tool = f", made by {description.generationTool}" if description.generationTool else ""
    findings.append(Finding("ok", "FMI", f"version 2.0, co-simulation{tool}"))
    return description


def _kind(description: Any, files: Mapping[str, bytes], findings: list[Finding]) -> None:
    """Its libraries and what it asks of its host."""
    flags = description.coSimulation
    offered: dict[str, str] = {}
    for name in sorted(files):
        platform, _, file = name.removeprefix("binaries/").partition("/")
        if file.rpartition(".")[0] == flags.modelIdentifier:
            offered[platform] = name
    listed = ", ".join(offered) or "none"
    if fmpy.platform in offered:
        others = ", ".join(name for name in offered if name != fmpy.platform)
        text = f"{fmpy.platform}, this platform" + (f"; also {others}" if others else "; no other")
        findings.append(Finding("ok", "binary", text))
    else:
        wanted = f"binaries/{fmpy.platform}/{flags.modelIdentifier}{fmpy.sharedLibraryExtension}"
        text = f"none for this platform: expected {wanted}, found binaries for {listed}"
        findings.append(
            Finding("fault", "binary", text, f"build it for {fmpy.platform}, or run on one of its platforms")
        )
    for platform, name in offered.items():
        _library(platform, files[name], files, findings)
    if flags.needsExecutionTool:
        text = "it needs the tool or the interpreter that made it where it runs (needsExecutionTool)"
        findings.append(Finding("warning", "host", text, "install that tool on every machine that runs it"))
    if flags.canBeInstantiatedOnlyOncePerProcess:
        findings.append(Finding("note", "host", "one instance in a process only; in a process of its own it is alone"))
    if not flags.canHandleVariableCommunicationStepSize:
        try:
            step = sample_time(description)
        except ValueError as error:
            text, _, remedy = str(error).partition("; remedy: ")
            findings.append(Finding("fault", "step", text, remedy))
            return
        if step is not None:
            text = f"it cannot vary its step of {float(step):.10g} s; a scenario's step has to divide it or be a multiple of it"
            findings.append(Finding("note", "step", text))
        else:
            text = "it cannot vary its step, and does not say which it is; the scenario's is taken"
            findings.append(Finding("warning", "step", text, "declare DefaultExperiment.stepSize in the FMU"))


def _library(platform: str, data: bytes, files: Mapping[str, bytes], findings: list[Finding]) -> None:
    here = platform == fmpy.platform
    try:
        library = binaries.read(data)
    except binaries.Unreadable as error:
        level, remedy = (
            ("fault", "build it anew for this platform")
            if here
            else ("warning", "build it anew, if that platform is used")
        )
        findings.append(Finding(level, "binary", f"{platform}: {error}", remedy))  # type: ignore[arg-type]
        return
    if library.kind == "Mach-O":
        findings.append(Finding("note", "binary", f"{platform}: a Mach-O library, whose functions are not looked at"))
        return
    missing = [name for name in binaries.FUNCTIONS if name not in library.exported]
    needed = [name for name in missing if name in binaries.CALLED]
    if needed:
        level = "fault" if here else "warning"
        text = f"{platform}: the library lacks {_some(needed)}"
        findings.append(Finding(level, "functions", text, "export every function of FMI 2.0, by its plain name"))  # type: ignore[arg-type]
    elif missing:
        text = f"{platform}: the library lacks {_some(missing)}, which are not called here, but which FMI demands"
        findings.append(Finding("warning", "functions", text, "export them; they may return fmi2Error"))
    else:
        findings.append(Finding("ok", "functions", f"{platform}: all of FMI 2.0 are there"))
    if here:
        beside = {n.rpartition("/")[2]: d for n, d in files.items() if n.startswith(f"binaries/{platform}/")}
        _loader(platform, binaries.unresolved(library, beside), findings)


def _loader(platform: str, left: binaries.Unresolved, findings: list[Finding]) -> None:
    if left.libraries:
        text = f"{platform}: needs libraries that this machine has not: {', '.join(left.libraries)}"
        findings.append(
            Finding(
                "fault",
                "symbols",
                text,
                "link them statically, or put them beside the library with an rpath of $ORIGIN",
            )
        )
    if left.symbols:
        text = f"{platform}: needs symbols that no library gives it: {_some(left.symbols)}"
        findings.append(Finding("fault", "symbols", text, "link the library that defines them, or add the source"))
    if left.versions:
        text = f"{platform}: needs a newer C library than this machine has: {', '.join(left.versions)}"
        findings.append(Finding("fault", "symbols", text, "build it on an older system, or link statically"))
    if left.host:
        text = f"{platform}: takes {len(left.host)} functions of Python from the process that loads it"
        findings.append(Finding("warning", "symbols", text, "run it in a process that holds Python, as is done here"))
    if not (left.libraries or left.symbols or left.versions or left.host):
        findings.append(Finding("ok", "symbols", f"{platform}: all that it needs is found"))


def _some(names: list[str]) -> str:
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


# ---------------------------------------------------------------- values and dependencies


def _start_values(found: Fit, starts: Mapping[Element, Any], findings: list[Finding]) -> None:
    differing = []
    for name, link in found.links.items():
        if link.ours.causality == "output" or not all(element in starts for element in link.theirs):
            continue
        theirs = _ours_of(link, [starts[element] for element in link.theirs])
        ours = [found.reference.starts.get(element) for element in link.ours.elements]
        if theirs is not None and not all(_equal(a, b) for a, b in zip(theirs, ours, strict=True)):
            unit = f" {link.ours.unit}" if link.ours.unit and link.ours.unit.name not in ("", "1") else ""
            differing.append(f"{name}: {_value(link, theirs)}{unit}, ours {_value(link, ours)}{unit}")
    for text in differing:
        findings.append(Finding("note", "start", text, "none needed where a scenario connects it or gives it a value"))


def _ours_of(link: Link, theirs: list[Any]) -> list[Any] | None:
    if link.ours.type != "real":
        return theirs
    if link.A is None or link.c is None:
        try:
            R = rotation.matrix([theirs[3], *theirs[:3]] if link.scalar_last else theirs)
        except ValueError:
            return None
        return rotation.transposed(R) if link.inverse else R
    return None if link.B is None else (link.B @ (np.array(theirs, float) - link.c)).tolist()


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, float) and isinstance(b, (int, float)):
        return abs(a - b) <= 1e-6 * max(abs(a), abs(b)) + 1e-12
    return bool(a == b)


def _value(link: Link, values: list[Any]) -> str:
    names = {number: item for item, number in link.ours.items}
    told = [f"{v:.6g}" if isinstance(v, float) else str(names.get(v, v)) for v in values]
    return told[0] if len(told) == 1 else f"[{', '.join(told)}]"


def _feedthrough(found: Fit, findings: list[Finding]) -> None:
    """Whether what it declares would close a loop with the other blocks of the project."""
    theirs, ours = model(found), found.reference.model
    silent = [
        v.name
        for v in theirs.of("output")
        if v.name in ours.variables and theirs.feedthrough.get(v.elements[0]) is None
    ]
    if silent:
        text = f"it does not say on which inputs {', '.join(silent)} depend directly; what our interface says is taken"
        findings.append(Finding("warning", "feedthrough", text, "list the dependencies in its ModelStructure"))
    direct: dict[Element, frozenset[Element]] = {}
    for element, known in ours.feedthrough.items():
        declared = theirs.feedthrough.get(element)
        direct[element] = (known or frozenset()) if declared is None else declared
    loops = _loops(found.reference, theirs, direct)
    for loop in loops:
        text = f"an algebraic loop through {loop}: all of these depend on each other at one instant"
        remedy = "let it act on inputs of the step before, or break the loop by 'delays' in the scenario"
        findings.append(Finding("fault", "feedthrough", text, remedy))
    more = sorted(
        {
            f"{e.variable} on {i.variable}"
            for e, known in direct.items()
            for i in known - (ours.feedthrough.get(e) or frozenset())
        }
    )
    if not loops and more:
        findings.append(
            Finding(
                "note", "feedthrough", f"depends directly where ours does not: {', '.join(more)}; no loop comes of it"
            )
        )
    elif not loops and not silent:
        findings.append(Finding("ok", "feedthrough", "closes no algebraic loop"))


def _loops(interface: Reference, theirs: Model, direct: Mapping[Element, frozenset[Element]]) -> list[str]:
    models = {**interface.others, interface.name: theirs}
    sources: dict[Element, list[tuple[str, Element]]] = {}
    for block, kind in models.items():
        for variable in kind.of("output"):
            for element in variable.elements:
                sources.setdefault(element, []).append((block, element))

    def needs(block: str, element: Element) -> list[tuple[str, Element]]:
        known = direct.get(element, frozenset()) if block == interface.name else models[block].feedthrough.get(element)
        found = (sources.get(e, []) for e in sorted(known or ()))
        return [source for several in found for source in several if source[0] != block]

    graph: Any = {source: needs(*source) for several in sources.values() for source in several}
    found = []
    for group in order.components(graph):
        if len(group) > 1:
            found.append(
                " -> ".join(dict.fromkeys(f"{block}.{e.variable}" for block, e in reversed(order.cycle(graph, group))))
            )
    return found


def _validator(path: Path, findings: list[Finding]) -> None:
    from fmpy.validation import validate_fmu

    known = {finding.text.removeprefix("modelDescription.xml: ") for finding in findings}
    problems = [problem for problem in validate_fmu(str(path)) if problem not in known]
    for problem in problems[:10]:
        findings.append(Finding("warning", "validator", " ".join(problem.split()), "correct it in the exporting tool"))
    if len(problems) > 10:
        findings.append(Finding("warning", "validator", f"and {len(problems) - 10} more", f"fmpy validate {path}"))
    if not problems:
        findings.append(Finding("ok", "validator", "FMPy finds nothing wrong"))
