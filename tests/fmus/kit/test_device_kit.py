"""The kit for a device: it builds as it stands, plays its vector with no FMU, and a right device is told from an empty
one."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from fmus import kit, link
from fmus.interface import load
from fmus.kit import linked
from fmus.native.toolchain import FREESTANDING, PLATFORMS
from orchestration.acceptance import binaries
from orchestration.acceptance.vector import record
from tests.commands import orchestrate
from tests.fmus.link import devices
from tests.machine import require

ROOT = Path(__file__).parents[3]
posix = pytest.mark.skipif(sys.platform == "win32", reason="the devices of these tests use POSIX")
needs_compiler = pytest.mark.usefixtures("c_compiler")


def made(folder: Path, language: str) -> Path:
    """A kit for a device of the controller, with a short vector."""
    record(kit.SCENARIO, "controller", folder / "vector")
    vector = folder / "vector" / "vector.csv"
    vector.write_text("".join(vector.read_text().splitlines(keepends=True)[:40]))
    linked.write(load("controller"), folder, language)
    return folder


@pytest.fixture(scope="module")
def c_kit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("kits") / "c", "c")


@pytest.fixture(scope="module")
def python_kit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("kits") / "python", "python")


def bench(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "bench.py", "vector", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@posix
@needs_compiler
def test_a_fresh_c_kit_answers_and_its_vector_tells_that_it_is_empty(c_kit):
    built = subprocess.run(
        ["make", "CFLAGS=-O0 -Werror", "vector"], cwd=c_kit, capture_output=True, text=True, check=False
    )
    assert (built.returncode, "***" in built.stderr) == (2, True), built.stdout + built.stderr
    assert "DIFFER  tau_cmd_B[1]" in built.stdout
    assert "ok      no_attitude" in built.stdout


@posix
def test_the_bench_finds_our_own_block_on_a_device_as_expected(c_kit):
    run = bench(c_kit, "run", str(devices.program("controller")))
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.startswith("39 rows")
    assert run.stdout.endswith("all outputs are as expected\n")


@posix
def test_the_bench_refuses_a_device_of_another_interface(c_kit):
    port = devices.free_port()
    with devices.running("allocator", "udp", port):
        run = bench(c_kit, "udp", f"127.0.0.1:{port}")
    assert (run.returncode, run.stderr) == (
        1,
        f"udp 127.0.0.1:{port}: the device is built for the interface allocator; expected controller\n",
    )


def _for_a_board(folder: Path, compiler: list[str], objects: Path) -> list[str]:
    """Compiles the kit's C for a Cortex-M7, each file by itself; the symbols that are left to be linked."""
    sources = [*folder.glob("*.c"), *folder.glob("generated/*.c")]
    sources += [folder / "firmware" / f"{name}.c" for name in ("device", "frame", "main", "board_uart")]
    paths = [f"-I{p}" for p in (folder, folder / "generated", folder / "firmware")]
    for source in sources:
        flags = ["-std=c11", "-O2", "-ffreestanding", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
        subprocess.run([*compiler, *flags, *paths, "-c", source, "-o", objects / f"{source.stem}.o"], check=True)
    listed = subprocess.run(["nm", *objects.glob("*.o")], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in listed.splitlines() if line and not line.endswith(":")]
    defined = {row[-1] for row in rows if row[-2] not in "Uw"}
    return sorted({row[-1] for row in rows if row[-2] == "U"} - defined)


@pytest.mark.parametrize("kind", ["zig", "gcc"])
def test_the_firmware_compiles_for_a_bare_cortex_m7_and_needs_no_operating_system(kind, c_kit, tmp_path):
    require("nm", *(["arm-none-eabi-gcc"] if kind == "gcc" else []))
    processor = ["-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard"]
    command = ["arm-none-eabi-gcc", *processor]
    if kind == "zig":
        target = ["-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7"]
        command = [sys.executable, "-m", "ziglang", "cc", *target, f"-I{FREESTANDING}"]
    left = [name for name in _for_a_board(c_kit, command, tmp_path) if not name.startswith("__aeabi_")]
    assert set(left) <= {"memcpy", "memset", "memcmp", "memmove"}


@posix
def test_a_python_device_is_told_from_an_empty_one(python_kit):
    empty = bench(python_kit, "run", "controller_device.py")
    assert (empty.returncode, "DIFFER  tau_cmd_B[1]" in empty.stdout) == (1, True), empty.stdout + empty.stderr
    law = python_kit / "controller_device.py"
    text = law.read_text()
    begin, end = text.index("    return {"), text.index("\n\n\nif __name__")
    body = """    items = {"phi": ("linear", "logarithm", "square_root"), "gain_schedule": ("error", "constant"),
             "reference": ("lvlh", "inertial", "rate")}
    chosen = {k: items[k][v - 1] if k in items else v for k, v in vars(p).items()}
    values = {k: np.array(v) if isinstance(v, list) else v for k, v in chosen.items()}
    parameters = controller.Parameters(**values)
    inputs = controller.Inputs(**{k: np.array(v) for k, v in vars(u).items()})
    if h == 0.0:
        memory.state = controller.start(parameters, inputs)
        return vars(controller.outputs(memory.state, inputs, parameters))
    memory.state, y = controller.step(memory.state, inputs, parameters, h)
    return vars(y)
"""
    law.write_text(
        f"import sys\nsys.path.append({str(ROOT)!r})\nimport controller\nimport numpy as "
        f"np\n{text[:begin]}{body}{text[end:]}"
    )
    right = bench(python_kit, "run", "controller_device.py")
    assert right.returncode == 0, right.stdout + right.stderr
    assert "all outputs are as expected" in right.stdout
    law.write_text(text)


@posix
def test_the_link_fmu_fits_without_a_warning_and_plays_the_vector_on_a_device(c_kit, tmp_path):
    port, fmu, mapping = devices.free_port(), c_kit / "controller_link.fmu", tmp_path / "mapping.yaml"
    mapping.write_text(f"start: {{link_address: '127.0.0.1:{port}'}}\n")
    with devices.running("controller", "udp", port):
        checked = orchestrate("check", fmu, "--as", "controller", "--map", mapping, "--vector", c_kit / "vector")
    assert checked.exit_code == 0, checked.output
    assert "warning" not in checked.stdout
    assert checked.stdout.count(": as expected") == len(load("controller").of("output"))


def test_new_writes_the_kit_for_a_device_and_says_what_comes_next(tmp_path, monkeypatch):
    fmu = tmp_path / "allocator_link.fmu"
    fmu.write_bytes(b"FMU of all platforms")
    monkeypatch.setattr(link, "ensure", lambda interface: fmu)
    for language, step in (("c", "make vector"), ("python", "python bench.py vector run allocator_device.py")):
        folder = tmp_path / language
        done = orchestrate("new", "allocator", folder, "--link", "--lang", language)
        assert (done.exit_code, step in done.stdout, "allocator_link.fmu" in done.stdout) == (0, True, True), (
            done.output
        )
        assert (folder / "allocator_link.fmu").read_bytes() == b"FMU of all platforms"
    other = orchestrate("new", "controller", tmp_path / "c", "--link")
    assert (other.exit_code, "expected the interface controller as it is written" in other.stderr) == (2, True)
    assert linked.is_of_device(tmp_path / "c")
    (tmp_path / "c" / "allocator.c").write_text("/* ours */")
    (tmp_path / "c" / "ports.py").unlink()
    linked.regenerate(tmp_path / "c")
    assert (tmp_path / "c" / "allocator.c").read_text() == "/* ours */"
    assert (tmp_path / "c" / "ports.py").exists()


def test_the_link_fmu_is_built_for_all_platforms_again_only_where_its_sources_have_changed(monkeypatch):
    fmu = link.ensure(load("controller"))
    monkeypatch.setattr(link, "package", lambda interface: pytest.fail("built again"))
    assert link.ensure(load("controller")) == fmu
    with zipfile.ZipFile(fmu) as archive:
        library = binaries.read(archive.read("binaries/win64/controller_link.dll"))
        assert {f"binaries/{p}/controller_link{known.suffix}" for p, known in PLATFORMS.items()} <= set(
            archive.namelist()
        )
    assert set(binaries.FUNCTIONS["fmi2"]) <= library.exported
    assert {name.lower() for name in library.needed} == {"kernel32.dll", "ws2_32.dll"}, "of Windows; no C runtime"
