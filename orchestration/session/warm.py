"""The session of the last run waits for the next run of the same scenario in this process.

Without it each run would open and check the scenario again, which takes longer than the 5 ms that a run may take
beside its loop. Tests: tests/orchestration/session/test_standby.py.
"""

from __future__ import annotations

import atexit
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

from ..fmu.archive import Fmu
from ..fmu.interfaces import is_path
from ..scenario.scenario import Scenario
from .open import open_fmus, open_scenario
from .session import Session


class Warm:
    """Holds one session at most, which no thread uses."""

    def __init__(self) -> None:
        self._last: tuple[Scenario, Session] | None = None
        self._lock = threading.Lock()

    @contextmanager
    def session(
        self, scenario: Scenario, verbose: bool = False, records: Mapping[str, Path] = MappingProxyType({})
    ) -> Iterator[Session]:
        """Lends the session of a scenario, and keeps it afterwards where nothing was raised. Raises InputError.

        One that prints what FMUs log, or that records calls, is its own.
        """
        fmus = open_fmus(scenario)
        last, own = self._swapped(None), verbose or bool(records)
        if last is not None and not own and last[0] == scenario and _same(last[1].opened.fmus, fmus):
            session = last[1]
        else:
            _close(last)
            session = Session(open_scenario(scenario, fmus), verbose=verbose, records=records)
        try:
            yield session
        except BaseException:
            session.close()
            raise
        # The others read more files than their FMUs, which may have changed.
        if own or any(is_path(e.fmu) or e.interface or e.map for e in scenario.blocks.values()):
            session.close()
            return
        _close(self._swapped((scenario, session)))
        atexit.unregister(self.close)
        atexit.register(self.close)  # the last one, which is called first: before the libraries are unloaded

    def _swapped(self, session: tuple[Scenario, Session] | None) -> tuple[Scenario, Session] | None:
        """Returns the session that waits, and lets this one wait in its place."""
        with self._lock:
            last, self._last = self._last, session
        return last

    def close(self) -> None:
        """Ends the session that waits."""
        _close(self._swapped(None))


def _close(last: tuple[Scenario, Session] | None) -> None:
    if last is not None:
        last[1].close()


def _same(a: Mapping[str, Fmu], b: Mapping[str, Fmu]) -> bool:
    return a.keys() == b.keys() and all(a[name] is b[name] for name in a)


WARM = Warm()
