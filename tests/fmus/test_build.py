"""What is built, from what, and that it runs on its own."""

from __future__ import annotations

import hashlib
import logging
import os
import re
import shutil
import struct
import subprocess
import sys
import threading
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import fmpy
import pytest

from fmus.build import ROOT, BuildError, blocks_of, build, ensure, ensure_all, is_current
from fmus.native.toolchain import host_platform

from .host import Host
from .toy import toy


@pytest.mark.thorough
def test_the_same_sources_give_the_same_bytes_in_another_folder_process_and_order_of_hashing(
    built_fmus: dict[str, Path], tmp_path: Path
) -> None:
    code = (
        f"from fmus.build import build; from pathlib import Path; build(flavour='python', out=Path({str(tmp_path)!r}))"
    )
    environment = os.environ | {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, check=True)
    for block, path in built_fmus.items():
        assert (tmp_path / f"{block}.fmu").read_bytes() == path.read_bytes()


def test_the_guid_follows_the_content(tmp_path: Path) -> None:
    guids = set()
    for name, version in (("a", 1), ("b", 1), ("c", 2)):
        path = build([toy(tmp_path / name, version)], "python", tmp_path / f"{name}_out")["toy"]
        guids.add(fmpy.read_model_description(str(path)).guid)
    assert len(guids) == 2


def test_two_versions_of_one_fmu_in_one_process_run_their_own_code(tmp_path: Path) -> None:
    speeds = []
    hosts = [
        Host(build([toy(tmp_path / f"v{version}", version)], "python", tmp_path / f"out{version}")["toy"]).started(
            rate=[3.0, 4.0]
        )
        for version in (1, 2)
    ]
    for host in hosts:
        host.step(0)
        speeds.append(host.get("speed"))
        host.close()
    assert speeds == [10.0, 20.0]


def test_an_fmu_unpacked_again_reads_its_own_data_after_the_first_copy_is_deleted(tmp_path: Path) -> None:
    path = build([toy(tmp_path)], "python", tmp_path)["toy"]
    for copy in ("first", "second"):
        with Host(path, folder=tmp_path / copy) as host:
            host.started(label="tables").step(0)
            assert host.get("label_used") == "outside"


def test_a_running_fmu_needs_python_and_numpy_only(built_fmus: dict[str, Path], tmp_path: Path) -> None:
    """fmpy drives here, in a process in which this repository and all packages but numpy are out of reach for the
    FMU."""
    drive = f"""
import sys
import fmpy, fmpy.fmi2, lxml.etree, numpy
blocked = {{"pint", "pygeomag", "ppigrf", "pythonfmu", "ziglang", "scipy", "fmus", "orchestration"}}
blocked |= {{"plant", "estimator", "controller", "allocator"}}
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in blocked:
            raise ModuleNotFoundError(f"blocked: {{name}}", name=name)
sys.meta_path.insert(0, Block())
before = set(sys.modules)
for block, path in {[(b, str(p)) for b, p in built_fmus.items()]!r}:
    description = fmpy.read_model_description(path)
    folder = fmpy.extract(path)
    fmu = fmpy.fmi2.FMU2Slave(guid=description.guid, unzipDirectory=folder,
                              modelIdentifier=description.coSimulation.modelIdentifier, instanceName=block)
    fmu.instantiate(); fmu.setupExperiment(); fmu.enterInitializationMode(); fmu.exitInitializationMode()
    fmu.doStep(0.0, 0.1); fmu.terminate(); fmu.freeInstance()
foreign = {{n.partition(".")[0] for n in set(sys.modules) - before if getattr(sys.modules[n], "__file__", None)
           and "site-packages" in sys.modules[n].__file__}}
print("foreign:", sorted(foreign - {{"numpy", "fmpy", "lxml"}}))
"""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    run = subprocess.run(
        [sys.executable, "-P", "-c", drive], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == "foreign: []"


def test_an_fmu_carries_requirements_documentation_and_licences(built_fmus: dict[str, Path]) -> None:
    for block in blocks_of("python"):
        with zipfile.ZipFile(built_fmus[block]) as archive:
            assert archive.read("resources/requirements.txt").startswith(b"numpy")
            assert b"omega_B" in archive.read("documentation/index.html")
            assert "documentation/licenses/PythonFMU.txt" in archive.namelist()


def test_the_library_for_windows_exports_every_function_of_fmi(built_fmus: dict[str, Path]) -> None:
    with zipfile.ZipFile(built_fmus["plant"]) as archive:
        exported = _exports(archive.read("binaries/win64/plant.dll"))
    header = (ROOT / "fmus" / "native" / "shell" / "fmi2.h").read_text()
    declared = set(re.findall(r"\b(fmi2\w+)\(fmi2|\b(fmi2\w+)\(void", header))
    names = {name for pair in declared for name in pair if name}
    assert len(names) == 34
    assert names <= exported


def _exports(library: bytes) -> set[str]:
    """The names in the export table of a 64-bit PE library."""

    def numbers(at: int, count: int = 1) -> tuple[int, ...]:
        return struct.unpack_from(f"<{count}I", library, at)

    header = numbers(0x3C)[0]
    count, optional = (
        struct.unpack_from("<H", library, header + 6)[0],
        struct.unpack_from("<H", library, header + 20)[0],
    )
    sections = [numbers(header + 24 + optional + 40 * i + 8, 4) for i in range(count)]

    def offset(address: int) -> int:
        return next(address - start + raw for size, start, _, raw in sections if start <= address < start + size)

    table = offset(numbers(header + 24 + 112)[0])
    places = numbers(offset(numbers(table + 32)[0]), numbers(table + 24)[0])
    return {library[offset(p) : library.index(b"\0", offset(p))].decode() for p in places}


def test_ensure_builds_once_and_again_when_a_source_changes(tmp_path: Path) -> None:
    block = toy(tmp_path)
    path = ensure(block, "python", tmp_path)
    first = path.stat().st_mtime_ns, hashlib.sha256(path.read_bytes()).hexdigest()
    time.sleep(0.01)
    assert ensure(block, "python", tmp_path) == path
    assert path.stat().st_mtime_ns == first[0]
    (block.folder / "helper.py").write_text("VERSION = 3\n")
    assert hashlib.sha256(ensure(block, "python", tmp_path).read_bytes()).hexdigest() != first[1]


def test_what_is_built_by_default_is_native() -> None:
    assert ensure("plant") == ROOT / "out" / "fmus" / "native" / "plant.fmu"


def test_what_need_only_run_here_has_one_library_and_stands_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fmus.places.work", lambda: tmp_path)
    path = ensure("allocator", here=True)
    assert path == tmp_path / "fmus" / "here" / "allocator.fmu"
    with zipfile.ZipFile(path) as archive:
        found = [name for name in archive.namelist() if name.startswith("binaries/")]
    assert [name.split("/")[1] for name in found] == [host_platform()]
    first = path.stat().st_mtime_ns
    assert ensure("allocator", here=True).stat().st_mtime_ns == first


def test_a_build_for_all_platforms_renews_the_file_of_this_machine_and_never_takes_it_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another process may be about to open it."""
    monkeypatch.setattr("fmus.places.work", lambda: tmp_path)
    monkeypatch.setattr(Path, "unlink", lambda path, **_: pytest.fail(f"{path} was taken away"))
    path = ensure("allocator", here=True)
    path.write_bytes(b"spoilt")
    everywhere = build(["allocator"])["allocator"]
    assert path.read_bytes() == everywhere.read_bytes()
    assert ensure("allocator", here=True) == path
    build(["allocator"], "python")
    assert path.read_bytes() == everywhere.read_bytes()


def test_every_file_that_makes_an_fmu_counts_for_its_fingerprint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from fmus import fingerprint as module

    copy = tmp_path / "fmus"
    shutil.copytree(module._HERE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(module, "_HERE", copy)
    block = module.Block.named("plant")
    seen = {module.fingerprint(block, "native")}
    names = ("units.py", "native/shell/step.c", "contents/icon.py", "interfaces/plant.svg", "a_new_file.py")
    for number, name in enumerate(names, start=2):
        with (copy / name).open("a") as file:
            file.write("\n")
        seen.add(module.fingerprint(block, "native"))
        assert len(seen) == number, name


def test_tables_that_a_block_borrows_count_for_its_fingerprint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both where the files are looked at and where their content is hashed, as another process does."""
    from fmus import fingerprint as module

    lender = tmp_path / "lender"
    (lender / "native").mkdir(parents=True)
    (lender / "tables").mkdir()
    monkeypatch.setattr(module, "lenders", lambda folder: {"gauss_models.h": lender})
    monkeypatch.setattr(module, "_known", {})
    monkeypatch.setattr(module, "kept", lambda kind, made_of, make: make())
    block = module.Block.named("allocator")
    seen = set()
    for file in ("native/tables.py", "tables/epochs.txt"):
        for content in ("", "1", "22"):
            (lender / file).write_text(content)
            seen.add(module.fingerprint(block, "native"))
    assert len(seen) == 6
    own = module.data_packages(block.folder)
    (lender / "tables" / "__init__.py").write_text('PACKAGES = ("some-package",)\n')
    assert module.data_packages(block.folder) == [*own, "some-package"]


def test_callers_that_ask_at_the_same_time_build_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block, out, built = toy(tmp_path / "toy"), tmp_path / "out", []

    def slow(*arguments: Any) -> dict[str, Path]:
        built.append(arguments)
        time.sleep(0.2)  # so that all the others are waiting
        return build(*arguments)

    monkeypatch.setattr("fmus.build.build", slow)
    with ThreadPoolExecutor(4) as pool:
        paths = set(pool.map(lambda _: ensure(block, "python", out), range(4)))
    assert (paths, len(built)) == ({out / "toy.fmu"}, 1)


def test_blocks_are_built_side_by_side_and_the_log_has_their_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Each `package` waits for the other, so this ends only where they run at the same time."""
    both = threading.Barrier(2, timeout=20)
    monkeypatch.setattr("fmus.native.package", lambda *_, **__: b"%d" % both.wait())
    monkeypatch.setattr("fmus.places.work", lambda: tmp_path)
    with caplog.at_level(logging.INFO, "attitude_cosim.build"):
        ensure_all(["plant", "allocator", "plant"])
    assert re.fullmatch(
        "building 2 FMUs for all platforms: plant, allocator ...\nbuilt in \\d+ s", "\n".join(caplog.messages)
    )
    assert [is_current(tmp_path / f"fmus/native/{name}.fmu", name, "native") for name in ("plant", "allocator")]


def test_a_full_disk_leaves_no_temporary_file_and_is_told_with_the_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fmus.build.os.fdopen", full)
    with pytest.raises(OSError, match="No space left") as info:
        build([toy(tmp_path / "toy")], "python", tmp_path / "out")
    assert info.value.filename == str(tmp_path / "out" / "toy.fmu")
    assert list((tmp_path / "out").iterdir()) == []


def test_ensure_does_not_import_what_only_a_build_needs() -> None:
    code = (
        "import sys; from fmus.build import ensure; ensure('plant'); "
        "print([n for n in ('pint', 'pygeomag', 'ppigrf', 'pythonfmu', 'numpy') if n in sys.modules])"
    )
    ensure("plant")
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_an_unknown_block_or_flavour_is_refused_by_name() -> None:
    with pytest.raises(BuildError, match="no block 'plan'; expected one of plant, controller, allocator"):
        ensure("plan")
    with pytest.raises(BuildError, match="no flavour 'cobol'"):
        ensure("plant", "cobol")


def test_a_block_whose_ports_are_not_those_of_its_interface_is_refused_with_the_port_s_name(tmp_path: Path) -> None:
    block = toy(tmp_path)
    code = block.folder / "block.py"
    code.write_text(code.read_text().replace("    order: int\n", "    ordre: int\n"))
    with pytest.raises(BuildError, match=r"'order' is missing in the toy_.*Parameters"):
        build([block], "python", tmp_path)
