"""The folder of a run: signals, manifest, expectations, and a page that shows them.

It takes the place of what an earlier run left in it, when all of its files are complete; files that are not a run's own
are not touched. See place.py for how, and formats.py for the signals.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from ..errors import InputError, ResultsError, reason
from . import formats, place, report
from .data import RunData, json_text


def write(result: RunData, folder: Path, format: str = "csv") -> Path:
    """Writes the folder and returns it. Raises ResultsError where it cannot be written; what was in it then stands.

    Of a run that did not come to its first sample there are no signals. Raises InputError where another run writes
    there.
    """
    formats.check(format)
    formats.check_names(result.columns, result.models, format)
    expected = {
        "complete": _complete(result),
        "passed": result.passed,
        "expectations": [
            *({**asdict(outcome), "status": outcome.status} for outcome in result.outcomes),
            *({**asdict(entry), "passed": None, "status": entry.status} for entry in result.not_evaluated),
        ],
        "holds": [{**asdict(hold), "text": hold.text} for hold in result.holds],
    }
    try:
        with place.replacing(folder) as part:
            if len(result.time):
                formats.write(result, part, format)
            _json(part / "expectations.json", expected)
            _report(result, part, folder)
            _json(
                part / place.MANIFEST,
                {**result.manifest, "samples_sha256": result.sha256, "files": place.digests(part)},
            )
    except (OSError, ValueError) as error:  # a value that the format does not take, whatever library says so
        if isinstance(error, InputError):
            raise
        where = f"{getattr(error, 'filename', None) or folder}: {reason(error)}"
        problem = ResultsError(f"the results cannot be written: {where}")
        problem.result = result
        raise problem from None
    return folder


def _report(result: RunData, part: Path, folder: Path) -> None:
    """Writes the page. Where that fails, the results stand without it, and a warning of the run says why."""
    try:
        report.write(result, part / "report.html")
    except Exception as error:
        (part / "report.html").unlink(missing_ok=True)
        why = reason(error) if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        result.warnings.append(f"{folder / 'report.html'} cannot be written: {why}")


def _complete(result: RunData) -> bool:
    return result.failure is None and not result.interrupted


def _json(path: Path, data: object) -> None:
    path.write_text(json_text(data) + "\n", "utf-8", errors="backslashreplace")  # half a character, as JSON has it
