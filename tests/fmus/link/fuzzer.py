"""The frame parsers at both ends of the link, and what stands behind them, built with random frames under
sanitizers."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from fmus import link
from fmus.interface import load
from fmus.kit import linked
from fmus.kit.fill import filled
from tests.native.driver import GUID
from tests.once import built

HERE = Path(__file__).parent
ENDS = ("device", "master")


def fuzzer(end: str, compiler: Sequence[str]) -> Path:
    """The program `fuzz_device` or `fuzz_master SEED FRAMES`, kept from one run to the next."""
    command = [*compiler, "-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror"]
    own = HERE / f"fuzz_{end}.c"
    with tempfile.TemporaryDirectory() as folder:
        sources, includes = (_device if end == "device" else _master)(Path(folder))
        arguments = [*(f"-I{path}" for path in (*includes, HERE)), *map(str, (*sources, own))]

        def build(path: Path) -> None:
            done = subprocess.run([*command, *arguments, "-o", path], capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr

        made_of = [version("ziglang"), *command, *sources, *includes, own, HERE / "random.h"]
        return built(f"fuzz_{end}", made_of, build)


def _device(folder: Path) -> tuple[list[Path], list[Path]]:
    """The skeleton of the kit, whose one function is in the fuzz program."""
    for name, text in linked.generated(load("controller")).items():
        (folder / name).write_text(text)
    (folder / "controller.h").write_text(filled("device.h.template", load("controller")))
    sources = [link.FIRMWARE / "device.c", link.NATIVE / "frame.c", folder / "wire.c"]
    return sources, [folder, link.FIRMWARE, link.NATIVE]


def _master(folder: Path) -> tuple[list[Path], list[Path]]:
    """What the FMU's shell calls, with the line in the fuzz program."""
    sources, includes = link.lay_out(load("controller"), GUID, folder)
    wanted = (
        "address.c",
        "exchange.c",
        "frame.c",
        "greeting.c",
        "link_block.c",
        "message.c",
        "samples.c",
        "zero.c",
        "wire.c",
        "table.c",
    )
    return [path for path in sources if path.name in wanted], includes
