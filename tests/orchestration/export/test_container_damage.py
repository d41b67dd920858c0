"""A container whose resources are damaged is refused with the file and what is wrong in it."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

import orchestration

from .host import Host

COUNTS = ("blocks", "variables", "starts", "inputs", "outputs", "initial", "text")
HEAD = 8 + 40 + 8 * 4 + 2 * 8
DAMAGED = "resources/container.bin is damaged: expected the tables that its head announces"
ANOTHER = "resources/container.bin is not that of this modelDescription.xml"


def with_count(data: bytes, name: str, count: int) -> bytes:
    at = 48 + 4 * COUNTS.index(name)
    return data[:at] + struct.pack("<I", count) + data[at + 4 :]


def count_of(data: bytes, name: str) -> int:
    return int(struct.unpack_from("<I", data, 48 + 4 * COUNTS.index(name))[0])


def with_block(data: bytes, block: int) -> bytes:
    """The first variable behind the time is said to be of this block."""
    at = HEAD + 16 * count_of(data, "blocks") + 16 + 4
    return data[:at] + struct.pack("<I", block) + data[at + 4 :]


DAMAGES: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "empty": (lambda data: b"", "resources/container.bin cannot be read"),
    "half a head": (lambda data: data[:50], "resources/container.bin cannot be read"),
    "no tables": (lambda data: data[:HEAD], DAMAGED),
    "half": (lambda data: data[: len(data) // 2], DAMAGED),
    "a byte short": (lambda data: data[:-1], DAMAGED),
    "another magic": (lambda data: b"CNTNR9" + data[6:], ANOTHER),
    "another GUID": (lambda data: data[:10] + b"00" + data[12:], ANOTHER),
    "a block that is not there": (lambda data: with_block(data, 77), DAMAGED),
    "no text": (lambda data: with_count(data, "text", 0), ANOTHER),
} | {
    f"{name}: {count}": (lambda data, name=name, count=count: with_count(data, name, count), words)
    for name in COUNTS
    for count, words in ((1000000, DAMAGED), (0xFFFFFFFF, ANOTHER))
}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A container in a folder."""
    folder = tmp_path_factory.mktemp("damage")
    scenario = Path(__file__).parents[3] / "scenarios" / "minimal.yaml"
    source = orchestration.load(scenario).source.without([("expect",), ("figures",)])
    container = orchestration.export_loop(orchestration.load(source), folder / "loop.fmu")
    return Path(fmpy.extract(str(container), str(folder / "unpacked")))


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_tables_are_refused_by_the_name_of_their_file(unpacked: Path, damage: str) -> None:
    spoil, expected = DAMAGES[damage]
    table = unpacked / "resources" / "container.bin"
    whole = table.read_bytes()
    try:
        table.write_bytes(spoil(whole))
        said: list[str] = []
        with pytest.raises(Exception, match="instantiate"):
            Host(unpacked, said=said)
        assert said == [expected]
    finally:
        table.write_bytes(whole)


def test_lost_files_are_named(unpacked: Path) -> None:
    library = next((unpacked / "resources" / "0_plant" / "binaries" / fmpy.platform).iterdir())
    for lost, expected in (
        (unpacked / "resources" / "container.bin", "resources/container.bin cannot be read"),
        (library, "plant: its library cannot be loaded: "),
    ):
        said: list[str] = []
        away = lost.rename(lost.with_suffix(".away"))
        try:
            with pytest.raises(Exception, match="instantiate"):
                Host(unpacked, said=said)
        finally:
            away.rename(lost)
        assert said[0].startswith(expected)
    Host(unpacked).fmu.freeInstance()
