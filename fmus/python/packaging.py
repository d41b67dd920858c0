"""Turns a block into a Python FMU: PythonFMU packages it, then the description, names and bytes are made ours.

Inside the FMU all Python code stands in one package whose name ends in the hash of its content, so that two FMUs, or
two versions of one, run their own code in one process:

resources/plant_0123456789ab.py             the entry: the one class that PythonFMU's library looks for
resources/plant_0123456789ab_code/          part_sets.py, parsing.py, variables.py, interface.toml, python/asked.py,
calls.py, memory.py, slave.py, written.py resources/plant_0123456789ab_code/plant/    the block, with the data that it
carries in tables/ resources/plant_0123456789ab_code/pythonfmu/ Tests: tests/fmus/python/test_slave.py."""

from __future__ import annotations

import hashlib
import tempfile
import zipfile
from importlib.metadata import distribution, version
from pathlib import Path

from pythonfmu import FmuBuilder

from ..block import files_of, importing_from, module_of, package_name
from ..contents.archive import archive, common
from ..contents.description import Capabilities, guid_from, model_description
from ..contents.origin import origin
from ..interface import Interface
from ..native.toolchain import PLATFORMS
from .shell import PLATFORM_ARGUMENTS, compile_shell, shell_sources

RUNTIME = (
    "part_sets.py",
    "parsing.py",
    "variables.py",
    "python/__init__.py",
    "python/asked.py",
    "python/calls.py",
    "python/memory.py",
    "python/slave.py",
    "python/written.py",
)
"""The modules of `fmus` that an FMU carries."""
CAPABILITIES = Capabilities(needsExecutionTool=True)
"""It needs a process that holds Python; it has all other capabilities."""
REQUIREMENTS = "numpy>=1.26\n"
"""For `pythonfmu deploy`; Python itself is 3.11 or later."""
NEEDS = (
    "Python flavour: the host's process must hold Python 3.11 or later with numpy; "
    "any other host takes the native flavour"
)
HOST = (
    "A process that holds Python 3.11 or later in which numpy can be imported (resources/requirements.txt): a "
    "tool that is "
    "itself a Python program, such as FMPy. Any other host gets no instance, and a message that says so: give it "
    "the native "
    "flavour of this block, which has the same ports and needs nothing."
)

_FMUS = Path(__file__).parents[1]
_PYTHONFMU = ("_version", "default_experiment", "enums", "fmi2slave", "logmsg", "variables")
"""PythonFMU's modules that run; the others build."""

_ENTRY = '''"""Entry of the FMU: PythonFMU's library looks here for the class of the slave."""

from {code}.python.calls import keep
from {code}.python.slave import BlockSlave

keep(globals())  # PythonFMU runs this text once more for each instance, then drops a reference that it never took


class {name}(BlockSlave):
    """{description}"""

    package = "{package}"
    identity = "{identity}"
'''


def package(interface: Interface, folder: Path, licence: Path | None) -> bytes:
    """The FMU of the block whose package is `folder`, as bytes. The same content gives the same bytes."""
    content = _content(interface, folder)
    tool = f"PythonFMU {version('pythonfmu')}, for hosts that hold Python 3.11 or later with numpy"
    digest = hashlib.sha256(model_description(interface, "", CAPABILITIES, tool, NEEDS))
    for name, data in sorted((content | shell_sources()).items()):
        digest.update(f"{name}\n{len(data)}\n".encode() + data)
    identity = digest.hexdigest()
    entry = f"{interface.name}_{identity[:12]}"
    with tempfile.TemporaryDirectory() as temporary:
        built = _build(Path(temporary), entry, identity, interface, _carried(folder), content)
        with zipfile.ZipFile(built) as made:
            files = {name: made.read(name) for name in made.namelist()}
    guid = guid_from(identity)
    return archive(
        _finish(files, entry, interface.name, guid)
        | {
            "modelDescription.xml": model_description(interface, guid, CAPABILITIES, tool, NEEDS, origin=origin()),
            "resources/requirements.txt": REQUIREMENTS.encode(),
            **common(interface, folder, licence, HOST),
            **_licence_of_pythonfmu(),
        }
    )


def _content(interface: Interface, folder: Path) -> dict[str, bytes]:
    """The package of the code, by path inside it."""
    content = {name: (_FMUS / name).read_bytes() for name in RUNTIME}
    content["interface.toml"] = interface.source.encode()
    carried = _carried(folder)
    content |= {f"{carried}/{path}": data for path, data in sources(folder).items()}
    if (folder / "tables").exists() or (folder / "tables.py").exists():
        with module_of(folder, "tables") as tables:
            content |= {f"{carried}/tables/{path}": data for path, data in tables.dump().items()}
    return content


def _carried(folder: Path) -> str:
    """The name of the block's package inside the FMU."""
    return package_name(folder).replace(".", "_")


def sources(folder: Path) -> dict[str, bytes]:
    """The Python files of a block's package, by their paths in it."""
    files = {path.relative_to(folder).as_posix(): path for path in files_of(folder) if path.suffix == ".py"}
    return {name: path.read_bytes().replace(b"\r\n", b"\n") for name, path in sorted(files.items())}


def _build(
    temporary: Path, entry: str, identity: str, interface: Interface, block: str, content: dict[str, bytes]
) -> Path:
    """Lays the project out and lets PythonFMU package it."""
    code = temporary / "project" / f"{entry}_code"
    for name, data in content.items():
        path = code / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    (code / "__init__.py").touch()
    script = code.parent / f"{entry}.py"
    text = _ENTRY.format(
        code=code.name, name=interface.name, description=interface.description, package=block, identity=identity
    )
    script.write_text(text, "utf-8", newline="\n")
    with importing_from(script.parent, entry, code.name):
        return Path(FmuBuilder.build_FMU(script, dest=temporary / "built", project_files=[code]))


def _finish(files: dict[str, bytes], entry: str, name: str, guid: str) -> dict[str, bytes]:
    """PythonFMU's files with its modules inside our package and the shell round its libraries."""
    finished = {}
    for path, data in files.items():
        folder, _, file = path.rpartition("/")
        if folder == "resources/pythonfmu":
            if file.removesuffix(".py") in _PYTHONFMU:
                finished[f"resources/{entry}_code/pythonfmu/{file}"] = data.replace(b"\r\n", b"\n")
        elif folder.startswith("binaries/"):
            platform, suffix = folder.removeprefix("binaries/"), Path(file).suffix
            finished[f"{folder}/{'lib' if suffix == '.so' else ''}pythonfmu-export{suffix}"] = data
            if platform in PLATFORM_ARGUMENTS:
                finished[path] = compile_shell(platform, guid)
        elif path != "modelDescription.xml":
            finished[path] = data
    finished[f"resources/{entry}_code/pythonfmu/__init__.py"] = b""
    missing = {f"binaries/{p}/{name}{PLATFORMS[p].suffix}" for p in PLATFORM_ARGUMENTS} - set(finished)
    if missing:
        raise RuntimeError(f"PythonFMU packaged no library for {sorted(missing)[0]}")
    return finished


def _licence_of_pythonfmu() -> dict[str, bytes]:
    """Its licence, since every FMU carries parts of it."""
    found = {}
    for file in distribution("pythonfmu").files or []:
        if file.name.upper().startswith("LICENSE"):
            found["documentation/licenses/PythonFMU.txt"] = Path(str(file.locate())).read_bytes()
    return found
