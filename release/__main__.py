"""`python -m release`: tested versions of dependencies, software bills of materials, hashes of the FMUs.
Tests: tests/release/test_release.py."""

from __future__ import annotations

import hashlib
from pathlib import Path

import click

from . import constraints


@click.group()
def main() -> None:
    """Writes the additions to a release's files; `make release` calls it."""


@main.command("constraints")
def write_constraints() -> None:
    """Write the versions in this environment to constraints.txt."""
    constraints.FILE.write_text(constraints.text(), "utf-8")


@main.command("building")
def write_building() -> None:
    """Write what builds the wheel to release/building.txt, with hashes; asks the package index."""
    constraints.BUILDING.write_text(constraints.hashed(), "utf-8")


@main.command("check")
def check() -> None:
    """Refuse an environment in which the FMUs would get other bytes than with the pinned versions."""
    if differing := constraints.differing():
        raise click.ClickException("\n".join([*differing, "remedy: pip install -c constraints.txt '.[build]'"]))


@main.command("files")
@click.argument("folder", type=click.Path(path_type=Path, exists=True, file_okay=False))
def files(folder: Path) -> None:
    """Write the bills of the one wheel in FOLDER and of its FMUs beside it, and hashes.md, for the release notes."""
    from . import sbom  # here, since it imports what only a release needs  # noqa: PLC0415

    wheels = list(folder.glob("*.whl"))
    if len(wheels) != 1:
        raise click.ClickException(f"{folder} holds {len(wheels)} wheels; expected one")
    data = wheels[0].read_bytes()
    version = wheels[0].name.split("-")[1]
    (folder / f"{wheels[0].stem}.cdx.json").write_text(sbom.of_wheel(data), "utf-8")
    fmus = sbom.fmus_in(data)
    for name, content in fmus.items():
        bill = folder / f"{name.replace('/', '-').removesuffix('.fmu')}.fmu.cdx.json"
        bill.write_text(sbom.of_fmu(name, content, version), "utf-8")
    text = hashes({wheels[0].name: data, **fmus})
    (folder / "hashes.md").write_text(text, "utf-8")
    click.echo(text, nl=False)


def hashes(contents: dict[str, bytes]) -> str:
    """A table of SHA-256, for release notes."""
    rows = [f"| `{name}` | `{hashlib.sha256(data).hexdigest()}` |" for name, data in contents.items()]
    return "\n".join(["| file | SHA-256 |", "| --- | --- |", *rows]) + "\n"


if __name__ == "__main__":
    main(prog_name="python -m release")
