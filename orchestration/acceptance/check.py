"""Finds out whether an FMU can take a block's place.

All but what its reference data say comes from its files, before anything of it runs: modelDescription.xml,
and the tables of its libraries. A swap fits the ports by the same rules, see `fit`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fmpy.validation import validate_model_description

from ..errors import InputError
from ..fmu import zipped
from ..fmu.archive import Head, Unsupported, check_version, described, open_fmu, read_head
from ..fmu.interfaces import reference
from ..fmu.model import Model
from ..scenario.mapping import load
from ..scenario.scenario import Scenario
from ..swap.findings import Finding, Fit
from ..swap.fit import fit
from ..swap.own_claims import own_claims
from ..temporary import temporary
from . import aliases, feedthrough, inputs, library, references, starts


def check(
    path: Path,
    as_: str,
    map_: Path | None = None,
    lenient: bool = False,
    scenario: Scenario | None = None,
    tolerance: float | None = None,
) -> tuple[list[Finding], Fit | None]:
    """Returns all findings, and how its ports fit where they could be looked at.

    `lenient`: what is not valid in its description is a warning, as it is for a block with `validation: lenient`.
    `tolerance`: where the FMU can be loaded, the reference data that it carries are played, in a process of its own;
    it counts where they have none, relative to each output's largest value. None: nothing of the FMU runs.
    With a scenario the findings name the expectations that would rest on what the FMU says of itself.
    Raises InputError where the FMU, the interface or the mapping cannot be read at all, the FMU cannot be unpacked,
    or the scenario has no such block.
    """
    interface = reference(as_, Path.cwd())
    blocks = _blocks(scenario, as_) if scenario is not None else []
    mapping = load(map_)[0] if map_ is not None else None
    if not path.exists():
        open_fmu(path)  # raises the error
    head = read_head(path)
    findings: list[Finding] = []
    read = _description(path, head, findings, lenient)
    if read is None:
        return findings, None
    description, theirs = read
    with temporary() as folder:
        zipped.unpack(path, folder, "FMU")
        library.look(description, theirs, library.files(folder), findings)
    if tolerance is not None and not any(finding.level == "error" for finding in findings):
        references.look(path, theirs, description.defaultExperiment, tolerance, findings)
    if description.fmiVersion == "2.0":
        aliases.look(description, findings)
    fitted = fit(interface, theirs, mapping)
    findings += fitted.findings
    _ignored(fitted, scenario, blocks, findings)
    starts.look(fitted, theirs.starts, findings)
    inputs.look(fitted, findings)
    feedthrough.look(fitted, findings)
    if scenario is not None:
        ports = [*(link.ours for link in fitted.links.values()), *fitted.extra]
        given = [port.name for port in ports if port.causality == "output"]
        for block in blocks:
            findings += own_claims(scenario, block, given)
    _validator(path, description, findings)
    return findings, fitted


def _ignored(fitted: Fit, scenario: Scenario | None, blocks: Sequence[str], findings: list[Finding]) -> None:
    """Says of outputs that the mapping ignores whether others are connected to them, since such a run is refused."""
    connections = [] if scenario is None else scenario.connections
    fed = {str(c.source.variable): str(c.target) for c in connections if c.source.block in blocks}
    for name, ours in fitted.ignored.items():
        reader = fed.get(name) if scenario is not None else "other blocks" if name in fitted.reference.needed else None
        if ours.causality == "output" and reader is not None:
            text = f"output {name} is ignored, but {reader} {'needs' if scenario is not None else 'need'} it"
            remedy = f"map it: '{name}: THEIRS' under ports in the mapping, or connect another signal in the scenario"
            findings.append(Finding("error", "ignored", text, remedy))


def _blocks(scenario: Scenario, as_: str) -> list[str]:
    """Returns the blocks of a scenario whose place it would take: those of this interface, or else of this name."""
    alike = [name for name, entry in scenario.blocks.items() if as_ in (entry.interface, entry.fmu)]
    if not alike and as_ not in scenario.blocks:
        raise InputError(
            f"{scenario.source.file or 'scenario'} has no block with the interface {as_!r}; "
            f"its blocks are {', '.join(scenario.blocks)}"
        )
    return alike or [as_]


def _description(path: Path, head: Head, findings: list[Finding], lenient: bool) -> tuple[Any, Model] | None:
    """Returns FMPy's ModelDescription and the model, where FMI's version and the kind are ours."""
    try:
        check_version(path, head)
        description, model, problems = described(path, head, lenient=True)
    except Unsupported as error:
        findings.append(Finding("error", "FMI", error.what, "export it so"))
        return None
    remedy = "correct it in the exporting tool" + ("" if lenient else ", or run it all the same: 'validation: lenient'")
    findings += [
        Finding("warning" if lenient else "error", "FMI", f"modelDescription.xml: {problem}", remedy)
        for problem in problems[:10]
    ]
    tool = f", made by {description.generationTool}" if description.generationTool else ""
    findings.append(Finding("ok", "FMI", f"version {model.fmi}, co-simulation{tool}"))
    findings += [Finding("note", "variable", f"{name} is {why}") for name, why in model.left_out.items()]
    return description, model


_BNAME = r"(?:[_a-zA-Z][_a-zA-Z0-9]*|'(?:[_a-zA-Z0-9!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['\"?\\abfnrtv])+')"
_INDICES = r"(?:\[\d+(?:,\d+)*\])?"
_IDENTIFIER = rf"{_BNAME}{_INDICES}(?:\.{_BNAME}{_INDICES})*"
_STRUCTURED = re.compile(rf"{_IDENTIFIER}|der\({_IDENTIFIER}(?:,\d+)?\)", re.ASCII)
"""A name by the convention "structured" (FMI 2.0, 2.2.9). FMPy's own grammar takes 2 ms a name."""


def _validator(path: Path, description: Any, findings: list[Finding]) -> None:
    known = {finding.text.removeprefix("modelDescription.xml: ") for finding in findings}
    found = validate_model_description(description, validate_variable_names=False, validate_model_structure=True)
    problems = [problem for problem in [*_misnamed(description), *found] if problem not in known]
    for problem in problems[:10]:
        findings.append(Finding("warning", "validator", " ".join(problem.split()), "correct it in the exporting tool"))
    if len(problems) > 10:
        findings.append(Finding("warning", "validator", f"and {len(problems) - 10} more", f"fmpy validate {path}"))
    if not problems:
        findings.append(Finding("ok", "validator", "FMPy's validator has no findings"))


def _misnamed(description: Any) -> list[str]:
    """Returns the names that the naming convention does not allow."""
    flat = description.variableNamingConvention == "flat"
    legal = (lambda name: not re.search(r"[\r\n\t]", name)) if flat else _STRUCTURED.fullmatch
    convention = "flat" if flat else "structured"
    return [
        f'"{v.name}" (line {v.sourceline}) is not a legal variable name for naming convention "{convention}".'
        for v in description.modelVariables
        if not legal(v.name)
    ]
