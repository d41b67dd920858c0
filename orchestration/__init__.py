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
    from .functions import (
        check_fmu,
        check_polarity,
        compare_fmu,
        export_loop,
        run_campaign,
        sweep,
    )
    from .results.result import Result
    from .scenario.scenario import Scenario
    from .session.read import load
    from .session.run import run

    __version__: str

_MODULES = {
    "Result": ".results.result",
    "Scenario": ".scenario.scenario",
    "check_fmu": ".functions",
    "check_polarity": ".functions",
    "compare_fmu": ".functions",
    "export_loop": ".functions",
    "load": ".session.read",
    "run": ".session.run",
    "run_campaign": ".functions",
    "sweep": ".functions",
}

__all__ = [
    "BlockError",
    "InputError",
    "Result",
    "Scenario",
    "__version__",
    "check_fmu",
    "check_polarity",
    "compare_fmu",
    "export_loop",
    "load",
    "run",
    "run_campaign",
    "sweep",
]


def __getattr__(name: str) -> Any:
    # Imported when asked for, so that a small use of the package stays quick.
    if name in _MODULES:
        return getattr(import_module(_MODULES[name], __name__), name)
    if name == "__version__":
        from importlib.metadata import version  # here, since it takes 40 ms  # noqa: PLC0415

        return version("attitude-cosim")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Returns a name that a user calls; the modules of the package are found by their own names."""
    return __all__
