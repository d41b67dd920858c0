"""Builds wheels: with two import names only, and with the FMUs and the step loop's libraries ready-made.

In the repository the packages stand side by side. In a wheel `orchestration` keeps its name, and the others stand
inside `attitude_cosim`, since names such as `plant` may be anyone's: docs/decisions/0006.

The build backend is hatchling; what compiles the FMUs is asked for when a wheel is built, not for an editable install.
Tests: tests/packaging/test_wheel.py.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import sys
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
NAME = "attitude_cosim"
INSIDE = ("allocator", "controller", "design", "estimator", "fmus", "formats", "inflight", "plant", "supervisor")
"""The packages that stand inside it in a wheel."""
BUILT = "ATTITUDE_COSIM_FMUS"
"""This variable of the environment names a folder of FMUs, by flavour. One that is made of these very sources is not
built again: `python -m build` makes the wheel in a folder of its own, where nothing has been built before."""
_BUILDING = {"numpy", "ppigrf", "pygeomag", "pythonfmu", "ziglang"}
_PROOFS = (
    "docs/evidence/proofs.md",
    "docs/evidence/proved.json",
    "evidence/proofs/arguments.yaml",
    "evidence/proofs/deviations.yaml",
)
"""What fmus/kit/flight.py puts beside the C."""
_BY_NAME = {"import_module", "__import__", "find_spec", "files", "run_module"}
"""Functions that take a module by its name."""


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Returns the requirements of hatchling, and those of the project that build FMUs."""
    import tomllib  # here, so that an older Python comes as far as pip's line that it is too old  # noqa: PLC0415

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    listed = [*project["dependencies"], *project["optional-dependencies"]["build"]]
    needed = [line for line in listed if re.match(r"[\w-]+", line)[0] in _BUILDING]  # type: ignore[index]
    return [*hatchling.get_requires_for_build_wheel(config_settings), *needed]


class Layout(BuildHookInterface):
    """Lays the wheel out in out/wheel: `orchestration`, the other packages in `attitude_cosim`, and what is
    ready-made."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        out = ROOT / "out" / "wheel"
        shutil.rmtree(out, ignore_errors=True)
        for package in ("orchestration", *INSIDE):
            _copy(ROOT / package, out / (f"{NAME}/{package}" if package in INSIDE else package))
        (out / NAME / "__init__.py").write_text(f'"""{self.metadata.core.description}."""\n', "utf-8")
        (out / NAME / "py.typed").touch()
        _ready_made(out / NAME / "fmus" / "ready")
        for group in self.metadata.core.entry_points.values():
            group.update({name: entry_point(place) for name, place in group.items()})
        build_data["force_include"] |= {str(out / name): name for name in ("orchestration", NAME)}


def entry_point(place: str) -> str:
    """The place of an entry point, `package.module:name`, as the wheel has it."""
    return f"{NAME}.{place}" if _is_inside(place.partition(":")[0]) else place


def _copy(source: Path, target: Path) -> None:
    shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.pyc", ".*"))
    for path in target.rglob("*.py"):
        text = path.read_text("utf-8")
        path.write_text(renamed(text, str(path)), "utf-8", newline="\n")


def renamed(text: str, where: str) -> str:
    """A module's source with `from fmus...` as `from attitude_cosim.fmus...`, and `import plant` as `from
    attitude_cosim import plant`.

    Raises ValueError on any other way to import.
    """
    lines = text.splitlines(keepends=True)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.level == 0 and _is_inside(node.module):
            line = lines[node.lineno - 1]
            lines[node.lineno - 1] = line.replace(f"from {node.module} ", f"from {NAME}.{node.module} ", 1)
            known = lines[node.lineno - 1] != line
        elif isinstance(node, ast.Import):
            known = not any(_is_inside(alias.name) for alias in node.names)
            if node.names[0].name in INSIDE and len(node.names) == 1:  # `import plant` of a whole line
                line = lines[node.lineno - 1]
                lines[node.lineno - 1] = line.replace("import ", f"from {NAME} import ", 1)
                known = True
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):  # for import_module, `python -m`, a patch
            known = re.fullmatch(r"fmus(\.\w+)+", node.value) is None
        elif isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in _BY_NAME:
            names = [argument.value for argument in node.args if isinstance(argument, ast.Constant)]
            known = not any(isinstance(name, str) and _is_inside(name) for name in names)
        else:
            continue
        if not known:
            raise ValueError(
                f"{where}:{node.lineno}: {ast.unparse(node)}: the wheel has this module inside {NAME}, and only "
                "'from PACKAGE import ...' and 'import PACKAGE' are renamed; write these, or a relative import"
            )
    return "".join(lines)


def _is_inside(module: str | None) -> bool:
    return module is not None and module.partition(".")[0] in INSIDE


def _ready_made(folder: Path) -> None:
    """FMUs of both flavours, the libraries of the step loop and of the recorder, scenarios and licence."""
    sys.path.insert(0, str(ROOT))  # the build backend runs outside the repository's packages
    # Here, since it needs the path above.
    from fmus import changes, telemetry  # here, since it needs the path above  # noqa: PLC0415
    from fmus.build import FLAVOURS, blocks_of, build, is_current  # noqa: PLC0415
    from fmus.native import toolchain  # here, since it needs the path above  # noqa: PLC0415

    for flavour in FLAVOURS:
        (folder / flavour).mkdir(parents=True)
        for block in blocks_of(flavour):
            built = Path(os.environ.get(BUILT, ROOT / "out" / "fmus"), flavour, f"{block}.fmu")
            if is_current(built, block, flavour):
                shutil.copy(built, folder / flavour)
            else:
                build([block], flavour, folder / flavour)
    orchestration = ROOT / "orchestration"
    (folder / "loop").mkdir()
    for name, source, headers in (
        ("", orchestration / "master" / "loop.c", ROOT / "fmus" / "native" / "shell"),
        ("recorder-", orchestration / "instances" / "record" / "recorder.c", ROOT),
    ):
        made = toolchain.compile_library(source.stem, [source], [headers], toolchain.PLATFORMS)
        for platform, library in made.items():
            (folder / "loop" / f"{name}{platform}{toolchain.PLATFORMS[platform].suffix}").write_bytes(library)
    container = [*sorted((orchestration / "export" / "container").glob("*.c")), orchestration / "master" / "loop.c"]
    for name, libraries in (
        ("telemetry", telemetry.libraries()),
        ("changes", changes.libraries()),
        ("container", telemetry.libraries("container", [*container, *telemetry.SHARED])),
    ):
        (folder / name).mkdir()
        for platform, library in libraries.items():
            (folder / name / platform).write_bytes(library)
    for name in ("LICENSE", "CITATION.cff", *_PROOFS):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    for path in (ROOT / "scenarios").rglob("*.yaml"):
        target = folder / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target)
