"""What an FMU in a process of its own prints and logs, taken in by a thread; its last lines are kept."""

from __future__ import annotations

import os
import sys
import threading
from collections import deque

from ..errors import printable
from .channel import MARK
from .log import LINES_MAX, shortened
from .process import GRACE

_REST_MAX = 1 << 16


class Listener:
    """Reads the standard error of a worker until it is closed."""

    def __init__(self, name: str, source: int, verbose: bool) -> None:
        self.lines: deque[str] = deque(maxlen=LINES_MAX)
        self._name, self._source, self._verbose = name, source, verbose
        self._marked = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def wait(self) -> None:
        """Waits for the mark that ends what the FMU has printed until now."""
        self._marked.wait(GRACE)
        self._marked.clear()

    def join(self) -> None:
        """Waits for the last line of a process that has ended."""
        self._thread.join(GRACE)

    def _listen(self) -> None:
        rest = b""
        while True:
            try:
                chunk = os.read(self._source, _REST_MAX)
            except OSError:
                return
            *lines, rest = (rest + chunk).split(b"\n")
            if not chunk and rest:
                lines.append(rest)
            for line in lines:
                self._take(line.removesuffix(MARK))
                if line.endswith(MARK):
                    self._marked.set()
            if not chunk:
                return
            rest = rest[:_REST_MAX]

    def _take(self, line: bytes) -> None:
        text = shortened(line.decode("utf-8", "replace").rstrip())
        if text:
            self.lines.append(text)
            if self._verbose:
                print(printable(f"{self._name}: {text}"), file=sys.stderr)
