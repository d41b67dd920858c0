"""A headless Chromium for tests, driven over its debugging pipe: no driver, no port, no network."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars --disable-dev-shm-usage --remote-debugging-pipe"
).split()


def executable() -> str | None:
    """The browser of this machine, if it has one."""
    return next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
    )


class Browser:
    """One page in a browser of its own. Use it in a `with` statement."""

    def __init__(self, path: str, width: int = 1366, height: int = 900) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="chromium-", ignore_cleanup_errors=True)
        read, self._to = os.pipe()
        self._from, write = os.pipe()
        options = [*FLAGS, f"--user-data-dir={self._folder.name}", f"--window-size={width},{height}", "about:blank"]

        def pipes() -> None:
            ends = os.dup(read), os.dup(write)  # clear of 3 and 4, which the browser takes
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        quiet = subprocess.DEVNULL
        self._process = subprocess.Popen(
            [path, *options], preexec_fn=pipes, close_fds=False, stdin=quiet, stdout=quiet, stderr=quiet
        )
        os.close(read)
        os.close(write)
        self._count = 0
        self._rest = b""
        self._session: str | None = None
        self.complaints: list[str] = []
        """What came to the console as warning or error, and exceptions that nobody caught."""
        self.requests: list[str] = []
        """The addresses that the page asked for."""

    def __enter__(self) -> Browser:
        target = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._to)
        os.close(self._from)
        self._folder.cleanup()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """A call of the DevTools protocol, and its answer."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while (answer := self._receive()).get("id") != self._count:
            self._heard(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def open(self, page: Path) -> None:
        """Loads a file, and waits until it is there."""
        self.call("Page.navigate", url=page.resolve().as_uri())
        for _ in range(200):
            if self.evaluate("document.readyState === 'complete' && location.protocol === 'file:'"):
                return
            time.sleep(0.05)
        raise TimeoutError(f"{page} was not loaded")

    def evaluate(self, script: str) -> Any:
        """The value of an expression in the page, a promise's when it is kept."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", str(answer)))
        return answer["result"].get("value")

    def settle(self) -> None:
        """Lets the page paint what it has to."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def drag(self, x0: float, x1: float, y: float) -> None:
        """Moves the mouse from one point to another with its button held."""
        self.mouse("mouseMoved", x0, y)
        self.mouse("mousePressed", x0, y, 1)
        self.mouse("mouseMoved", (x0 + x1) / 2, y, 1)
        self.mouse("mouseMoved", x1, y, 1)
        self.mouse("mouseReleased", x1, y)

    def mouse(self, kind: str, x: float, y: float, buttons: int = 0, clicks: int = 1) -> None:
        button = "left" if buttons or kind == "mouseReleased" else "none"
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=buttons, clickCount=clicks)

    def picture(self, path: Path) -> None:
        """The whole page as a PNG."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        shot = self.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
        path.write_bytes(base64.b64decode(shot["data"]))

    def print(self, path: Path) -> None:
        """The page on paper, as a PDF."""
        path.write_bytes(base64.b64decode(self.call("Page.printToPDF", preferCSSPageSize=True)["data"]))

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            if not select.select([self._from], [], [], 60)[0]:
                raise TimeoutError("the browser does not answer")
            piece = os.read(self._from, 1 << 20)
            if not piece:
                raise RuntimeError("the browser has ended")
            self._rest += piece
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def _heard(self, event: dict[str, Any]) -> None:
        method, told = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = told["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(a.get("value", a.get("description"))) for a in told["args"]))
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            self.complaints.append(f"{told['entry']['text']} {told['entry'].get('url', '')}")
        elif method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])


def pixels(page: Browser, colour: str, plot: int = 0) -> int:
    """How many points of a plot have about this colour."""
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return page.evaluate(
        f"""(() => {{
          const canvas = document.querySelectorAll(".plot canvas")[{plot}], {{ width, height }} = canvas;
          const copy = new OffscreenCanvas(width, height).getContext("2d", {{ willReadFrequently: true }});
          copy.drawImage(canvas, 0, 0);
          const {{ data }} = copy.getImageData(0, 0, width, height);
          let found = 0;
          for (let i = 0; i < data.length; i += 4)
            found += data[i + 3] > 128 && {json.dumps(rgb)}.every((c, k) => Math.abs(c - data[i + k]) < 24);
          return found;
        }})()"""
    )


def box(page: Browser, selector: str, place: int = 0) -> list[float]:
    """Left, top, width and height of an element that has been brought into view."""
    return page.evaluate(
        f"""(() => {{
          const it = document.querySelectorAll({json.dumps(selector)})[{place}];
          it.scrollIntoView({{ block: "center" }});
          const r = it.getBoundingClientRect();
          return [r.x, r.y, r.width, r.height];
        }})()"""
    )


def values(page: Browser, plot: int = 0) -> list[str]:
    cells = f"[...document.querySelectorAll('.plot')[{plot}].querySelectorAll('.u-value')]"
    return page.evaluate(f"{cells}.map(cell => cell.textContent)")
