"""A run to be shown, and what reads the page of it."""

from __future__ import annotations

import base64
import json
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np

from orchestration.quantities import parse_unit
from orchestration.results.result import Result

from ..mocks import Mock, model, real
from ..mocks import run as run_mocks

EVIL = "</script><script>window.hacked=1</script><img src=x onerror=window.hacked=1>\"'&"
VOID = {"meta", "link"}


def swing(steps: int = 400, note: str = "swings & settles", **more: Any) -> Result:
    """A run of one block: a decaying swing in two axes, a flag while it is large, and a signal that changes its
    sign."""

    def evaluate(block: Mock) -> None:
        t = block.state
        x = [np.exp(-t / 20) * np.cos(t), np.exp(-t / 20) * np.sin(t)]
        for element, value in zip(block.model.variables["x"].elements, x, strict=True):
            block.values[element] = value
        block["y"], block["on"], block["still"], block["t"] = x[0], 3 < t < 6, 7.25, t

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = time + step

    signals = (
        real("x", "output", shape=(2,), unit=parse_unit("rad"), description=note),
        real("y", "output"),
        real("on", "output", type="boolean"),
        real("still", "output"),
        real("t", "output"),
        real("u", "input", variability="tunable"),
    )
    scenario = {
        "description": note,
        "step": 0.1,
        "duration": 0.1 * steps,
        "cycle": {"name": "swings", "period": 6.283},
        "expect": [
            {"name": f"stays below 2 {note}", "signal": "a.x", "always": {"below": "2 rad"}},
            {"name": "norm", "signal": "a.x", "measure": "norm", "always": {"within": 0.5}},
        ],
        "holds": [{"name": f"hold {note}", "signal": "a.on", "keeps": ["a.still"]}],
        "faults": [{"at": 8, "until": 9, "set": "a.u = 1"}],
        "figures": [
            {
                "name": "swing",
                "title": f"Swing {note}",
                "shade": "a.on",
                "mark": "a.y",
                "panels": [
                    {
                        "signals": ["a.x"],
                        "unit": "deg",
                        "label": f"x {note}",
                        "names": ["one", note],
                        "lines": ["90 deg"],
                    },
                    {"signals": ["a.y"]},
                ],
            },
        ],
        **more,
    }
    return run_mocks([Mock("a", model("a", *signals), evaluate, advance, 0.0)], scenario, start={"a": {"u": 0}})


class Reader(HTMLParser):
    """The elements of a page; what is not closed as it was opened is an error."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] not in ("script", "style"):
            self.text.append(data)

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


def data_of(page: str) -> dict[str, Any]:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1], parse_constant=refuse)


def unpacked(array: dict[str, str]) -> np.ndarray:
    kind = {"u1": "<u1", "f4": "<f4", "f8": "<f8"}[array["type"]]
    return np.frombuffer(base64.b64decode(array["data"]), kind).astype(float)
