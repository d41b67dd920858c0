"""What a wheel is laid out from, without building one: an FMU that was built before its sources changed stays out."""

from pathlib import Path

import pytest

import hatch_build
from fmus import build, telemetry
from fmus.native import toolchain


def test_an_fmu_of_other_sources_is_built_anew_and_not_packed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "FLAVOURS", ("native",))
    monkeypatch.setattr(build, "blocks_of", lambda flavour: ["fresh", "stale"])
    monkeypatch.setattr(build, "is_current", lambda path, block, flavour: block == "fresh")
    monkeypatch.setattr(build, "build", lambda names, flavour, out: (out / f"{names[0]}.fmu").write_text("built anew"))
    monkeypatch.setattr(toolchain, "compile_library", lambda *arguments: {})
    monkeypatch.setattr(telemetry, "libraries", lambda *arguments: {})
    monkeypatch.setenv(hatch_build.BUILT, str(tmp_path / "built"))
    (tmp_path / "built" / "native").mkdir(parents=True)
    for name in ("fresh", "stale"):
        (tmp_path / "built" / "native" / f"{name}.fmu").write_text("built before")
    hatch_build._ready_made(tmp_path / "ready")
    packed = {path.stem: path.read_text() for path in (tmp_path / "ready" / "native").glob("*.fmu")}
    assert packed == {"fresh": "built before", "stale": "built anew"}
