"""Builds wheels that bring the FMUs and the step loop's libraries ready-made, so that a user needs no compiler.

The build backend is hatchling; what compiles the FMUs is asked for when a wheel is built, not for an editable install.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

from hatchling import build as hatchling
from hatchling.build import build_editable, build_sdist, get_requires_for_build_editable, get_requires_for_build_sdist
from hatchling.build import build_wheel as build_wheel
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]

ROOT = Path(__file__).parent
_BUILDING = {"numpy", "pint", "platformdirs", "ppigrf", "pygeomag", "pythonfmu", "ziglang"}


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """What hatchling needs, and the project's own requirements that build FMUs."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    listed = [*project["dependencies"], *project["optional-dependencies"]["build"]]
    needed = [line for line in listed if re.match(r"[\w-]+", line)[0] in _BUILDING]  # type: ignore[index]
    return [*hatchling.get_requires_for_build_wheel(config_settings), *needed]


class ReadyMade(BuildHookInterface):
    """Puts FMUs, step loops, scenarios and licence into the wheel's `fmus/ready`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable" or self.target_name != "wheel":
            return
        sys.path.insert(0, str(ROOT))
        from fmus.build import FLAVOURS, build
        from fmus.native import toolchain

        out = ROOT / "build" / "wheel"
        files = {"LICENSE": ROOT / "LICENSE"}
        files |= {f"scenarios/{path.name}": path for path in sorted((ROOT / "scenarios").glob("*.yaml"))}
        for flavour in FLAVOURS:
            files |= {f"{flavour}/{path.name}": path for path in build(flavour=flavour, out=out / flavour).values()}
        headers, loop = [ROOT / "fmus" / "native" / "shell"], [ROOT / "orchestration" / "master" / "loop.c"]
        for platform, library in toolchain.compile_library("loop", loop, headers, toolchain.PLATFORMS).items():
            path = out / "loop" / f"{platform}{toolchain.PLATFORMS[platform].suffix}"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(library)
            files[f"loop/{path.name}"] = path
        build_data["force_include"] |= {str(path): f"fmus/ready/{name}" for name, path in files.items()}
