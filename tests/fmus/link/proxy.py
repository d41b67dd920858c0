"""A line with faults between the link FMU and a device: UDP on loopback, and a pair of pseudo terminals."""

from __future__ import annotations

import os
import selectors
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

Rule = Callable[[bytes, str], list[tuple[float, bytes]]]
"""What becomes of bytes on their way "to" the device or "from" it: what is passed on, each after so many s."""


def as_they_are(data: bytes, way: str) -> list[tuple[float, bytes]]:
    return [(0.0, data)]


@dataclass
class Proxy:
    """Passes on what its rule says, until it is cut."""

    address: str
    rule: Rule = as_they_are
    passed: dict[str, int] = field(default_factory=lambda: {"to": 0, "from": 0})
    is_cut: bool = False
    _due: list[tuple[float, int, Callable[[], object]]] = field(default_factory=list)

    def pass_on(self, data: bytes, way: str, send: Callable[[bytes], object]) -> None:
        self.passed[way] += 1
        for delay, part in [] if self.is_cut else self.rule(data, way):
            self._due.append((time.monotonic() + delay, len(self._due), lambda part=part: send(part)))

    def work(self) -> float:
        """Sends what is due; the time until there is more, s."""
        now = time.monotonic()
        due, self._due = [d for d in self._due if d[0] <= now], [d for d in self._due if d[0] > now]
        for _, _, send in sorted(due, key=lambda d: d[:2]):
            with suppress(OSError):
                send()
        return min((d[0] - now for d in self._due), default=0.05)


@contextmanager
def datagrams(port: str, rule: Rule = as_they_are) -> Iterator[Proxy]:
    """A UDP line to the device at a port of this computer."""
    near, far = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in "12")
    near.bind(("127.0.0.1", 0))
    far.connect(("127.0.0.1", int(port)))
    proxy, peer = Proxy(f"127.0.0.1:{near.getsockname()[1]}", rule), []

    def step(ready: list[socket.socket]) -> None:
        if near in ready:
            data, peer[:] = (lambda r: (r[0], [r[1]]))(near.recvfrom(65536))
            proxy.pass_on(data, "to", far.send)
        if far in ready:
            with suppress(ConnectionRefusedError):
                proxy.pass_on(far.recv(65536), "from", lambda data: near.sendto(data, peer[0]))

    with _running(proxy, [near, far], step):
        yield proxy
    near.close()
    far.close()


@contextmanager
def terminals(rule: Rule = as_they_are) -> Iterator[tuple[Proxy, str, Callable[[], None]]]:
    """A serial line of two pseudo terminals: the proxy with the FMU's address, the device's path, and what unplugs the
    FMU's end."""
    (near, near_slave), (far, far_slave) = os.openpty(), os.openpty()
    for slave in (near_slave, far_slave):
        tty.setraw(slave)
    proxy, open_ends = Proxy(os.ttyname(near_slave), rule), {near, far, near_slave, far_slave}

    def unplug() -> None:
        proxy.is_cut = True
        for end in (near, near_slave):
            open_ends.discard(end)
            os.close(end)

    def step(ready: list[int]) -> None:
        for source, target, way in ((near, far, "to"), (far, near, "from")):
            if source in ready and source in open_ends:
                proxy.pass_on(os.read(source, 4096), way, lambda data, target=target: os.write(target, data))

    with _running(proxy, [near, far], step):
        yield proxy, os.ttyname(far_slave), unplug
    for end in open_ends:
        os.close(end)


@contextmanager
def _running(proxy: Proxy, sources: list, step: Callable[[list], None]) -> Iterator[None]:
    ended = threading.Event()

    def work() -> None:
        while not ended.is_set():
            wait = proxy.work()
            with suppress(OSError, ValueError):
                there = [s for s in sources if not proxy.is_cut or s != sources[0]]
                with selectors.PollSelector() as line:  # which takes files of any number
                    for source in there:
                        line.register(source, selectors.EVENT_READ)
                    step([key.fileobj for key, _ in line.select(min(wait, 0.05))])

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
