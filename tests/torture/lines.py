"""A device behind a line with strangers, wrong times, values that are not finite, slow and lost answers, all at random.

In lock-step a step ends with the block's own bits for its instant, or is silent or refused with a place; the run goes
on after the trouble, where its policy says so."""

from __future__ import annotations

import socket
import struct
import sys
import time
from collections import Counter
from contextlib import suppress
from math import nan
from random import Random

import click
import numpy as np

from fmus.link.device import ANSWER, STEP, Reader, frame

from ..fmus.link import devices
from ..fmus.link.proxy import datagrams
from ..fmus.link.test_link import OUTPUTS, H, inputs
from ..fmus.link.test_strangers import STRANGE
from ..native.driver import Instance, Refused

STEPS = 60
TIME_OUT = 0.4  # s, of which a busy machine does not need all
TROUBLES = ("stranger", "time", "nan", "slow", "loss", "none")


@click.command("lines")
@click.option("--count", default=30, show_default=True, help="Runs.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Fly a controller on a device behind a line with strangers, wrong times and slow answers."""
    counts: Counter[str] = Counter()
    direct = _direct()
    for number in range(count):
        _trial(Random(f"{seed}.{number}"), direct, counts, f"run {number}")
    for text, n in sorted(counts.items()):
        click.echo(f"{n:6} {text}")
    sys.exit(any(text.startswith("ERROR") for text in counts))


def _values(block: Instance) -> np.ndarray:
    return np.concatenate([np.ravel(block.get(name)) for name in OUTPUTS])


def _feed(block: Instance, k: int) -> None:
    for name, value in inputs(k).items():
        block.set(name, value)


def _direct() -> list[np.ndarray]:
    with Instance("controller") as block:
        _feed(block, 0)
        block.initialize()
        rows = [_values(block)]
        for k in range(1, STEPS + 1):
            _feed(block, k)
            block.step((k - 1) * H, H)
            rows.append(_values(block))
    return rows


def _spoilt(random: Random, data: bytes, trouble: str) -> list[tuple[float, bytes]]:
    if trouble == "loss":
        return []
    if trouble == "slow":
        return [(random.choice((0.2, 0.6, 1.5)) * TIME_OUT, data)]
    if trouble not in ("time", "nan") or data[3] != STEP | ANSWER:
        return [(0.0, data)]
    (answer,) = Reader(4000).feed(data)
    payload = bytearray(answer.payload)
    (stamp,) = struct.unpack_from("<d", payload)
    if trouble == "time":
        struct.pack_into(
            "<d", payload, 0, random.choice((nan, -stamp - 1.0, stamp + random.choice((-5, -0.1, 0.1, 5))))
        )
    else:
        struct.pack_into("<d", payload, 8, nan)
    return [(0.0, frame(answer.type, answer.session, answer.sequence, bytes(payload)))]


def _trial(random: Random, direct: list[np.ndarray], counts: Counter[str], name: str) -> None:
    policy, trouble = random.choice(("stop", "hold", "zero")), random.choice(TROUBLES)
    share = random.choice((0.05, 0.3, 1.0))
    first, last = sorted(random.sample(range(1, STEPS), 2))
    now = 0

    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        spoilt = way == "from" and first <= now < last and random.random() < share
        return _spoilt(random, data, trouble) if spoilt else [(0.0, data)]

    port = devices.free_port()
    settings = {"time_out": TIME_OUT, "tries": random.choice((1, 4)), "when_silent": policy}
    with (
        devices.running("controller", "udp", port),
        datagrams(port, rule) as proxy,
        devices.instance("controller", address=proxy.address, **settings) as block,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        stranger.connect(("127.0.0.1", int(port)))
        _feed(block, 0)
        block.initialize()
        gap = False
        for now in range(1, STEPS + 1):
            if trouble == "stranger":
                with suppress(OSError):
                    stranger.send(random.choice(list(STRANGE.values())))
            _feed(block, now)
            try:
                block.step((now - 1) * H, H)
            except Refused as refused:
                right = (
                    policy == "stop" and trouble in ("time", "nan", "slow", "loss") and "device at udp" in str(refused)
                )
                counts[f"{policy}: refused with its place" if right else f"ERROR: {name}: {refused}"] += 1
                return
            silent = bool(block.get("link_silent"))
            gap = gap or silent
            if silent and (policy == "stop" or trouble in ("stranger", "none")):
                counts[f"ERROR: {name}: {policy}, {trouble}: silent at step {now}"] += 1
                return
            if not silent and not gap and not np.array_equal(_values(block), direct[now]):
                counts[f"ERROR: {name}: {policy}, {trouble}: other bits at step {now}"] += 1
                return
        until = time.monotonic() + 5.0
        while block.get("link_silent") and time.monotonic() < until:
            time.sleep(0.02)
            block.step(now * H, H)
            now += 1
        well = not block.get("link_silent") and np.all(np.isfinite(_values(block)))
        counts[f"{policy}: whole" if well else f"ERROR: {name}: {policy}, {trouble}: not used again"] += 1
