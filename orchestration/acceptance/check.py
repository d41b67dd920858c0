"""Whether an FMU can take a block's place, before anything of it runs.

Everything comes from its files: modelDescription.xml, and the tables of its libraries. A swap fits the
ports by the same rules, see `fit`.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

from fmpy.model_description import ValidationError, read_model_description
from fmpy.validation import validate_fmu

from ..errors import InputError
from ..fmu.archive import entries, fmi_version, open_fmu, optional_inputs, refuse_entities, shown
from ..fmu.description import describe
from ..fmu.interfaces import reference, starts_of
from ..scenario.mapping import load
from ..swap.findings import Finding, Fit
from ..swap.fit import fit
from . import feedthrough, library, starts


def check(path: Path, as_: str, map_: Path | None = None) -> tuple[list[Finding], Fit | None]:
    """All findings, and how its ports fit where they could be looked at.

    Raises InputError where the FMU, the interface or the mapping cannot be read at all.
    """
    interface = reference(as_, Path.cwd())
    mapping = load(map_)[0] if map_ is not None else None
    if not path.exists() or path.is_dir():
        open_fmu(path)  # raises the error
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
    library.look(description, files, findings)
    theirs = describe(description, optional_inputs(xml))
    fitted = fit(interface, theirs, mapping)
    findings += fitted.findings
    starts.look(fitted, starts_of(description, theirs), findings)
    feedthrough.look(fitted, findings)
    _validator(path, findings)
    return findings, fitted


def _description(path: Path, xml: bytes, findings: list[Finding]) -> Any:
    if (version := fmi_version(xml) or "unknown") != "2.0":
        findings.append(
            Finding("error", "FMI", f"version {version}; expected 2.0", "export it for FMI 2.0, co-simulation")
        )
        return None
    try:
        description = read_model_description(str(path))
    except ValidationError as error:
        for problem in error.problems[:10]:
            findings.append(
                Finding("error", "FMI", f"modelDescription.xml: {problem}", "correct it in the exporting tool")
            )
        try:
            description = read_model_description(str(path), validate=False)
        except Exception:
            return None
    except Exception as error:  # FMPy and lxml raise what they please
        text = f"modelDescription.xml cannot be read: {' '.join(str(error).split())}"
        findings.append(Finding("error", "FMI", text, "export it anew"))
        return None
    if description.coSimulation is None:
        findings.append(Finding("error", "FMI", "version 2.0, for model exchange only", "export it for co-simulation"))
        return None
    tool = f", made by {description.generationTool}" if description.generationTool else ""
    findings.append(Finding("ok", "FMI", f"version 2.0, co-simulation{tool}"))
    return description


def _validator(path: Path, findings: list[Finding]) -> None:
    known = {finding.text.removeprefix("modelDescription.xml: ") for finding in findings}
    problems = [problem for problem in validate_fmu(str(path)) if problem not in known]
    for problem in problems[:10]:
        findings.append(Finding("warning", "validator", " ".join(problem.split()), "correct it in the exporting tool"))
    if len(problems) > 10:
        findings.append(Finding("warning", "validator", f"and {len(problems) - 10} more", f"fmpy validate {path}"))
    if not problems:
        findings.append(Finding("ok", "validator", "FMPy's validator has no findings"))
