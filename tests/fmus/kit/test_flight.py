"""A block's folder for a flight project: the same bits by every compiler as the FMU gives, and files that are safe."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

from fmus import places
from fmus.block import Block
from fmus.build import ensure
from fmus.interface import BLOCKS
from fmus.kit import InUse, flight
from fmus.native.toolchain import run_program
from tests.blocks import some
from tests.fmus.carried_data import hashed, played

START = Path(__file__).with_name("flight_start.c")
FLAGS = "-std=c11 -O2 -ffp-contract=off -fno-math-errno -Wall -Wextra -Iportable -Isrc".split()
CORTEX = "-mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard --specs=rdimon.specs".split()
BOARD = [str(START), "-Wl,--section-start=.vectors=0", "-Wl,-Ttext=0x10000"]
QEMU = "qemu-system-arm -M mps2-an500 -nographic -semihosting -kernel".split()
ZIG = [sys.executable, "-m", "ziglang", "cc"]
COMPILERS = {
    "gcc": (["gcc", "-lm"], []),
    "clang": (["clang", "-lm"], []),
    "zig": (ZIG, []),
    "zig for riscv64": ([*ZIG, "-target", "riscv64-linux-musl"], ["qemu-riscv64"]),
    "gcc for riscv64": (["riscv64-linux-gnu-gcc", "-static"], ["qemu-riscv64"]),
    "gcc for aarch64": (["aarch64-linux-gnu-gcc", "-static"], ["qemu-aarch64"]),
    "gcc for cortex-m7": (["arm-none-eabi-gcc", *CORTEX, *BOARD], QEMU),
}


def written(block: str, folder: Path) -> Path:
    chosen = Block.named(block)
    flight.write(chosen.interface, chosen.folder, folder)
    return folder


@pytest.mark.parametrize("block", some(BLOCKS, "allocator"))
def test_the_runner_knows_the_bits_of_the_fmu(block: str, tmp_path: Path) -> None:
    folder = written(block, tmp_path / block)
    (bits,) = re.findall(r"bits = 0x([0-9a-f]{16})u;", (folder / "vectors" / "vectors.h").read_text())
    assert int(bits, 16) == hashed(played(ensure(block), Block.named(block).interface))


@pytest.mark.parametrize("compiler", some(COMPILERS, "zig"))
@pytest.mark.parametrize("block", some(BLOCKS, "controller"))
def test_a_compiler_gives_the_bits_of_the_fmu(block: str, compiler: str, tmp_path: Path) -> None:
    command, run = COMPILERS[compiler]
    needed = [name for name in (command[0], *run[:1]) if shutil.which(name) is None]
    if needed:
        pytest.skip(f"needs {needed[0]}")
    folder = written(block, tmp_path / block)
    sources = [str(path.relative_to(folder)) for path in sorted(folder.rglob("*.c"))]
    libraries = [word for word in command if word == "-lm"]
    built = [word for word in command if word != "-lm"]
    subprocess.run([*built, *FLAGS, *sources, "-o", "vectors.elf", *libraries], cwd=folder, check=True)
    done = subprocess.run([*run, "./vectors.elf"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert ", those of the FMU" in done.stdout, done.stdout + done.stderr
    assert done.returncode == 0


@pytest.mark.thorough
def test_cmake_and_meson_build_the_folder_and_play_its_vectors(tmp_path: Path) -> None:
    folder = written("controller_planned", tmp_path / "planned")
    commands = [
        ["cmake", "-S", ".", "-B", "../cmake"],
        ["cmake", "--build", "../cmake"],
        ["ctest", "--test-dir", "../cmake", "--output-on-failure"],
        ["meson", "setup", "../meson"],
        ["meson", "test", "-C", "../meson"],
    ]
    for command in commands:
        if shutil.which(command[0]):
            subprocess.run(command, cwd=folder, check=True, capture_output=True)


def test_the_runner_tells_other_bits_from_differences_beyond_a_tolerance(tmp_path: Path) -> None:
    folder = written("controller", tmp_path / "controller")
    sources = [*folder.glob("src/*.c"), folder / "portable" / "elementary.c", folder / "vectors" / "runner.c"]
    vectors = folder / "vectors" / "vectors.h"
    text = vectors.read_text()
    found = {}
    for factor in (1e-12, 1e-3):
        (given,) = re.findall(r"u->omega_B\[0\] = x\[\d+\];", text)
        vectors.write_text(text.replace(given, given.replace(";", f" * (1.0 + {factor});")))
        printed = run_program(sources, [folder / "portable", folder / "src"])
        assert "not those of the FMU" in printed
        found[factor] = float(re.findall(r"difference is (\S+) of its tolerance", printed)[0])
    assert found[1e-12] < 1.0 < found[1e-3]


def test_the_bill_of_materials_is_cyclonedx_and_lists_every_file(tmp_path: Path) -> None:
    folder = written("estimator", tmp_path / "estimator")
    bill = (folder / "bom.cdx.json").read_text()
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(bill) is None
    names = {c["name"] for c in json.loads(bill)["components"]}
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert files - names == {"README.md", "bom.cdx.json", "SHA256SUMS"}
    assert "ppigrf" in names  # from which the field's coefficients come
    assert (folder / "reports" / "proofs.md").read_text().startswith("<!--")
    assert {path.name for path in (folder / "reports").iterdir()} == {
        *("proofs.md", "arguments.yaml", "deviations.yaml", "proved.txt")
    }


@pytest.mark.parametrize("block", ["allocator", "allocator_bounded", "controller", "supervisor", "estimator"])
def test_the_reports_are_of_the_c_that_was_proved(tmp_path: Path, block: str) -> None:
    assert (written(block, tmp_path / block) / "reports" / "proved.txt").read_text().startswith("The reports are of")


@pytest.mark.parametrize(
    ("proved", "said"),
    [({}, "not of this C: the proofs have no block allocator"), ({"allocator": "0"}, "that was proved is another")],
)
def test_reports_of_other_c_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, proved: dict, said: str) -> None:
    (tmp_path / "proved.json").write_text(json.dumps(proved))
    shared = places.shared
    monkeypatch.setattr(places, "shared", lambda n: tmp_path / "proved.json" if n == flight.PROVED else shared(n))
    assert said in (written("allocator", tmp_path / "allocator") / "reports" / "proved.txt").read_text()


def test_the_digest_is_of_all_c_and_of_nothing_else() -> None:
    files = {"src/a.c": b"1", "portable/b.h": b"2", "vectors/runner.c": b"3", "README.md": b"4"}
    digest = flight.digest_of(files)
    assert digest == flight.digest_of({**files, "vectors/runner.c": b"5", "README.md": b"6"})
    assert len({digest, flight.digest_of(files | {"src/a.c": b"2"}), flight.digest_of(files | {"src/c.c": b""})}) == 3


def test_sha256sum_agrees_and_the_same_sources_give_the_same_folder(tmp_path: Path) -> None:
    one, two = written("allocator", tmp_path / "one"), written("allocator", tmp_path / "two")
    assert (one / "SHA256SUMS").read_bytes() == (two / "SHA256SUMS").read_bytes()
    if shutil.which("sha256sum"):
        subprocess.run(["sha256sum", "--check", "--quiet", "SHA256SUMS"], cwd=one, check=True)


def test_what_was_edited_and_what_is_of_others_is_not_overwritten(tmp_path: Path) -> None:
    folder = written("allocator", tmp_path / "allocator")
    (folder / "src" / "fault.h").write_text("edited")
    with pytest.raises(InUse, match="fault.h was edited"):
        written("allocator", folder)
    assert (folder / "src" / "fault.h").read_text() == "edited"
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "main.c").write_text("int main(void) { return 0; }")
    with pytest.raises(InUse, match="expected an empty folder"):
        written("allocator", tmp_path / "theirs")


def test_a_list_of_hashes_leads_to_no_file_outside_its_folder(tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.write_text("kept")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "SHA256SUMS").write_text(f"{'0' * 64}  ../outside\n")
    with pytest.raises(InUse, match="leads out of the folder"):
        written("allocator", folder)
    assert outside.read_text() == "kept"


def test_another_block_takes_the_place_of_one_that_was_not_edited(tmp_path: Path) -> None:
    folder = written("allocator", tmp_path / "it")
    written("controller", folder)
    assert not (folder / "src" / "allocator.c").exists()
    assert (folder / "src" / "controller.c").exists()
