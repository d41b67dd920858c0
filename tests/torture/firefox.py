"""Live pages in Firefox, driven by WebDriver BiDi: the hash of each flight beside that of the native run."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

import click
import numpy as np

from orchestration import BlockError, InputError, run

from .pages import SCENARIOS, made

SHOWN = """new Promise((done) => {
  const { dataset } = document.documentElement, look = () => setTimeout(
    () => (dataset.state === "flying" ? look() : done()), 20);
  look();
})"""
"""Waits until nothing flies."""


class Firefox:
    """One tab of a browser without a screen, with what it wrote to its console."""

    def __init__(self, program: str, profile: Path) -> None:
        connect = import_module("websockets.sync.client").connect  # of the extra `measures`
        given = [program, "--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port=0"]
        self.process = subprocess.Popen(given, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        assert self.process.stderr
        address = next(found[0] for line in self.process.stderr if (found := re.search(r"ws://\S+", line)))
        self.socket, self.asked = connect(f"{address}/session", max_size=None).__enter__(), 0
        self.console: list[str] = []
        self.ask("session.new", capabilities={})
        self.ask("session.subscribe", events=["log.entryAdded"])
        self.tab = self.ask("browsingContext.getTree")["contexts"][0]["context"]

    def ask(self, method: str, **params: object) -> Any:
        """Returns the result of a command of BiDi; what comes before it goes to `console`."""
        self.asked += 1
        self.socket.send(json.dumps({"id": self.asked, "method": method, "params": params}))
        while (answer := json.loads(self.socket.recv())).get("id") != self.asked:
            self.console.append(answer["params"]["text"])
        return answer["result"]

    def evaluate(self, expression: str) -> Any:
        """Returns the value of an expression in the page, a number or a text, once it is there."""
        target = {"context": self.tab}
        found = self.ask("script.evaluate", expression=expression, target=target, awaitPromise=True)
        return found["result"].get("value")


def _native(scenario: Path) -> str:
    """Returns the hash of the native run; empty where a block refuses it, as the page then has none."""
    try:
        return run(scenario).sha256
    except (BlockError, InputError):
        return ""


@click.command("firefox")
@click.argument("names", nargs=-1)
@click.option("--count", default=5, show_default=True, help="Settings of each page.")
@click.option("--seed", default=1, show_default=True)
def command(names: tuple[str, ...], count: int, seed: int) -> None:
    """Fly the pages of scenarios in Firefox, V.B where none is named, and their native runs."""
    program = shutil.which("firefox-esr") or shutil.which("firefox")
    assert program is not None, "no Firefox on this machine (Debian: apt-get install firefox-esr)"
    bad = 0
    with tempfile.TemporaryDirectory(prefix="firefox-", ignore_cleanup_errors=True) as name:
        folder, drawn = Path(name), np.random.default_rng(seed)
        shutil.copytree(SCENARIOS, folder / "scenarios")
        (folder / "profile").mkdir()
        tab = Firefox(program, folder / "profile")
        try:
            for stem in names or ("paper_no_singularity",):
                tab.ask("browsingContext.navigate", context=tab.tab, url=made(folder, stem).as_uri(), wait="complete")
                tab.evaluate(SHOWN)
                equal = tab.evaluate("document.querySelector('#same').textContent") == "the same as of the native run"
                for _ in range(count):
                    tab.evaluate(
                        f"(() => {{ const all = document.querySelectorAll('[data-control]'), s = {drawn.random()};"
                        f" const it = all[Math.floor({drawn.random()} * all.length)];"
                        " it.value = Number(it.min) + s * (it.max - it.min); it.dispatchEvent(new Event('input')); })()"
                    )
                    tab.evaluate(SHOWN)
                    scenario = folder / "scenarios" / "of_the_page.yaml"
                    scenario.write_text(tab.evaluate("document.querySelector('#scenario').textContent"), "utf-8")
                    equal &= tab.evaluate("document.documentElement.dataset.hash") == _native(scenario)
                bad += not equal
                click.echo(
                    f"{stem}: {count + 1} flights, {'each' if equal else 'ERROR: not each'} with the native hash"
                )
            click.echo(f"console: {', '.join(tab.console) or 'nothing'}")
        finally:
            tab.process.terminate()
            tab.process.wait()
    sys.exit(bool(bad))
