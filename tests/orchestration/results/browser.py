"""Pages in a headless Chromium, the system's own, driven by Playwright."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, ConsoleMessage, Locator, Page, sync_playwright

FLAGS = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--enable-unsafe-swiftshader"]
"""The processor draws page and WebGL, as on a machine without a graphics card, so that each machine shows the same."""


def executable() -> str | None:
    """The browser of this machine, if it has one."""
    return next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
    )


PATIENCE = 120
"""For how long a page is waited for, s: what takes seconds on an idle machine takes minutes on a slow, busy one."""

SETTLED = """new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() =>
  new IntersectionObserver((_, self) => { self.disconnect(); requestAnimationFrame(() => setTimeout(done)); })
    .observe(document.documentElement))))"""
"""Two frames; then a frame whose observers have all been told, since this one is the last of them; then the frame that
shows what they have drawn."""


@contextmanager
def launched(path: str) -> Iterator[Tab]:
    """One tab in a browser of its own."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=FLAGS, timeout=1000 * PATIENCE)
        try:
            yield Tab(browser)
        finally:
            browser.close()


class Tab:
    """One page, with what it complained of and asked for since it was opened."""

    def __init__(self, browser: Browser) -> None:
        self.page: Page = browser.new_page()
        self.page.set_default_timeout(1000 * PATIENCE)
        self.complaints: list[str] = []
        """What came to the console as warning or error, and exceptions that nobody caught."""
        self.requests: list[str] = []
        """The addresses that the page asked for."""
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))

    def _heard(self, message: ConsoleMessage) -> None:
        driver = "GPU stall due to ReadPixels"  # the tests read pictures back, which the page does not
        if message.type in ("error", "warning", "assert") and driver not in message.text:
            self.complaints.append(message.text)

    def open(self, path: Path, width: int = 1366, height: int = 900) -> None:
        """Loads a file in the light style at this width."""
        self.page.emulate_media(color_scheme="light", media="screen", reduced_motion="no-preference")
        self.page.set_viewport_size({"width": width, "height": height})
        self.complaints.clear()
        self.requests.clear()
        self.page.goto(path.resolve().as_uri())
        self.settle()

    def resize(self, width: int, height: int = 900) -> None:
        """The same page at another width."""
        self.page.set_viewport_size({"width": width, "height": height})
        self.until(f"innerWidth === {width} && innerHeight === {height}")
        self.settle()

    def settle(self) -> None:
        """Waits until the page has painted what it has to: frames asked for, plots that have come near the screen.

        What a worker or a timer does is not waited for: see `until`.
        """
        self.page.evaluate(SETTLED)

    def until(self, condition: str, patience: float = PATIENCE) -> None:
        """Waits (s) until an expression is true; Playwright's own way evaluates text in the page, which its policy
        refuses."""
        became = self.page.evaluate(
            f"""new Promise(done => {{
              const late = performance.now() + {1000 * patience};
              const look = () => (
                ({condition}) ? done(true) : performance.now() > late ? done(false) : setTimeout(look, 4)
              );
              look();
            }})"""
        )
        if not became:
            raise TimeoutError(f"{condition} did not become true: {self.complaints}")

    @property
    def foreign(self) -> list[str]:
        """What the page asked for beside itself and its own data."""
        return [url for url in self.requests if not url.startswith("data:") and url != self.page.url]


def pixels(tab: Tab, colour: str, plot: int = 0) -> int:
    """How many points of a plot have about this colour; it is brought into view, since it is not drawn before."""
    see(tab, ".plot", plot)
    tab.until(f"document.querySelectorAll('.plot')[{plot}].querySelector('canvas')")
    tab.settle()
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return tab.page.evaluate(
        f"""(() => {{
          const canvas = document.querySelectorAll(".plot")[{plot}].querySelector("canvas");
          const {{ width, height }} = canvas;
          const copy = new OffscreenCanvas(width, height).getContext("2d", {{ willReadFrequently: true }});
          copy.drawImage(canvas, 0, 0);
          const {{ data }} = copy.getImageData(0, 0, width, height);
          let found = 0;
          for (let i = 0; i < data.length; i += 4)
            found += data[i + 3] > 128 && {json.dumps(rgb)}.every((c, k) => Math.abs(c - data[i + k]) < 24);
          return found;
        }})()"""
    )


def see(tab: Tab, selector: str, place: int = 0) -> Locator:
    """Brings an element into view."""
    element = tab.page.locator(selector).nth(place)
    element.evaluate("it => it.scrollIntoView({ block: 'center' })")
    return element


def box(tab: Tab, selector: str, place: int = 0) -> list[float]:
    """Left, top, width and height of an element that has been brought into view."""
    found = see(tab, selector, place).bounding_box()
    assert found
    return [found[key] for key in ("x", "y", "width", "height")]


def values(tab: Tab, plot: int = 0) -> list[str]:
    """What stands beside a plot's cursor: the time, then the value of each curve."""
    return tab.page.locator(".plot").nth(plot).locator(".readout:not([hidden]) b").all_text_contents()
