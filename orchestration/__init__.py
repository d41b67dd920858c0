"""Runs co-simulation FMUs of FMI 2.0 and 3.0 from a scenario file.

from orchestration import run

result = run("scenario.yaml", {"plant.x0": "51.6 deg", "duration": "60 s"})
result.time, result["plant.x"]
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

if sys.version_info < (3, 11):  # one line, where the imports below would end in a traceback  # noqa: UP036
    raise SystemExit(
        f"attitude-cosim needs Python 3.11 or later; this is Python {sys.version_info[0]}.{sys.version_info[1]}"
    )

from .errors import BlockError, InputError

if TYPE_CHECKING:
    from .results.result import Result
    from .scenario.scenario import Scenario
    from .session.read import load
    from .session.run import run

__all__ = ["BlockError", "InputError", "Result", "Scenario", "load", "run"]


_MODULES = {
    "Result": ".results.result",
    "Scenario": ".scenario.scenario",
    "load": ".session.read",
    "run": ".session.run",
}


def __getattr__(name: str) -> Any:
    # Imported when asked for, so that a small use of the package stays quick.
    if name in _MODULES:
        return getattr(import_module(_MODULES[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
