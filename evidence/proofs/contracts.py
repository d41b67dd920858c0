"""Contracts in the C that Frama-C's WP proves with z3: the guards through which outputs leave a block.

A guard relates a number to its limit, and says something of each of many numbers. Eva's sets of values do not.
Needs frama-c, why3 and z3 (Debian: frama-c-base, why3, z3).

Shows FC-4.
"""

from __future__ import annotations

import os
import re
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from fmus.block import Block
from fmus.native import lay_out
from fmus.places import PACKAGES
from orchestration import InputError

from ..tools import tool
from .analysis import MACHINE, Alarm, Result
from .rounds import refuse_assumptions

PRELUDE = Path(__file__).with_name("prelude.h")


@dataclass(frozen=True)
class Contract:
    """Functions of a file whose contracts are proved, as the file stands in the FMU of a block."""

    title: str
    file: str
    functions: tuple[str, ...]
    block: str

    def prove(self, folder: Path, root: Path = PACKAGES) -> Result:
        """WP on the file in `root`, in `folder`: an alarm is a goal that z3 does not prove.

        `root`: a copy of the packages, with changes. Raises InputError where a program is missing or fails.
        """
        folder.mkdir(parents=True, exist_ok=True)
        refuse_assumptions(root)
        refuse_unproved((root / self.file).read_text("utf-8"), self)
        began, block, config = time.monotonic(), Block.named(self.block), folder / "why3.conf"
        tool("z3")
        subprocess.run([tool("why3"), "config", "detect", "-C", str(config)], capture_output=True, check=True)
        _, include = lay_out(block.interface, block.folder, "{guid}", folder)
        places = [root / p.relative_to(PACKAGES) if p.is_relative_to(PACKAGES) else p for p in include]
        words = [f"-include {PRELUDE}", *(f"-I{path}" for path in places)]
        command = [tool("frama-c"), "-machdep", MACHINE, f"-cpp-extra-args={' '.join(words)}", "-wp"]
        command += ["-wp-split", "-wp-prover", "z3", "-wp-timeout", "30", "-wp-fct", ",".join(self.functions)]
        done = subprocess.run(
            [*command, str(root / self.file)],
            capture_output=True,
            text=True,
            check=False,
            cwd=folder,
            env={**os.environ, "WHY3CONFIG": str(config)},
        )
        proved = re.search(r"Proved goals:\s*(\d+) / (\d+)", done.stdout)
        if done.returncode or proved is None:
            raise InputError(f"{self.file}: Frama-C's WP failed:\n{done.stdout[-2000:]}{done.stderr[-500:]}")
        left = re.findall(r"Goal (\w+) : (?!Valid)\w+", done.stdout)
        if len(left) != int(proved[2]) - int(proved[1]):
            raise InputError(f"{self.file}: {proved[0]}, but these are named: {left}; remedy: Frama-C 25")
        alarms = tuple(Alarm(Path(self.file).name, 0, self._function(goal), "goal", goal) for goal in left)
        return Result(alarms, int(proved[1]), (int(proved[1]), int(proved[2])), time.monotonic() - began)

    def _function(self, goal: str) -> str:
        return max((f for f in self.functions if f"_{f}_" in goal), key=len, default="")


_OF_OUTPUTS = re.compile(
    r"\s*requires \\separated\((?:law, )?x, y, f\);\s*\w+_FINITE(?:\s*COMMANDS_WITHIN\(&law->p\))?\s*"
)
"""The contract by which outputs leave a block."""
_CLAUSE = re.compile(r"^\s*((?:requires|ensures|behavior|terminates|decreases|assigns)\b[^;\n]*)", re.MULTILINE)
"""Of a contract of a function; those of a loop have `loop` before."""


def refuse_unproved(text: str, contract: Contract) -> None:
    """Raises InputError where a function of the file has a contract that is not asked for, or calls another behind its
    guard."""
    functions = re.findall(r"^(?:static |inline )*\w[\w *]*?\b(\w+)\([^;{}]*?\)\n\{\n(.*?)^\}", text, re.M | re.S)
    notes = re.sub(r"/\*[^@].*?\*/", "", text, flags=re.S)
    stated = {
        name: note
        for note, name in re.findall(
            r"/\*@((?:(?!\*/).)*)\*/\n(?:static |inline )*\w[\w *]*?\b(\w+)\([^;{}]*?\)\n\{", notes, re.S
        )
    }
    if others := sorted(set(stated) - {*contract.functions}):
        raise InputError(f"{contract.file}: {others[0]} has a contract that is not proved; remedy: contracts.py")
    left = [note for pair in re.findall(r"/\*@((?:(?!\*/).)*)\*/|//@([^\n]*)", notes, re.S) if (note := "".join(pair))]
    for note in stated.values():
        left.remove(note)
    if elsewhere := [said for note in left for said in _CLAUSE.findall(note)]:
        raise InputError(f"{contract.file}: {elsewhere[0]!r} stands before no function's body; expected one")
    for name in contract.functions:
        if name.endswith(("_outputs", "_step")) and not _OF_OUTPUTS.fullmatch(stated.get(name, "")):
            raise InputError(f"{contract.file}: {name}: expected to require that x, y and f are apart, and no more")
    for name, body in functions:
        behind = re.split(r"\b(?:\w+_guard|give)\([^()]*\)", body)[-1]
        if name in contract.functions and behind != body and (call := re.search(r"\b(?!if|return|fault)\w+\(", behind)):
            raise InputError(f"{contract.file}: {name}: {call[0]}...) behind the guard; expected nothing there")


def _finite(name: str) -> Contract:
    """The generated guard of a block, and that its outputs leave through it."""
    block = Block.named(name)
    code, folder = block.interface.code, block.folder.relative_to(PACKAGES).as_posix()
    inner = {
        "allocator": ("remember",),
        "controller": ("outputs_of",),
        "controller_planned": ("bring_within", "is_command", "are_commands", "controller_planned_give", "give"),
    }
    functions = (*SHARED, f"{code}_refuse", f"{code}_guard", *inner.get(code, ()), f"{code}_outputs", f"{code}_step")
    return Contract(f"guard, {name}", f"{folder}/native/{code}.c", functions, name)


SHARED = ("is_number", "run_finite", "not_finite")
CONTRACTS = (
    *map(_finite, ("allocator", "allocator_bounded", "allocator_bounded_wheels", "controller", "controller_wheels")),
    *map(_finite, ("controller_planned", "controller_planned_wheels", "supervisor", "estimator", "estimator_wheels")),
)
BY_WP = frozenset(
    (file, name)
    for contract in CONTRACTS
    for name in contract.functions
    for file in (
        Path(contract.file).name,
        "finite.h",
        "guard.h",
        f"{Block.named(contract.block).interface.code}_guard.h",
    )
)
"""File and function of what is proved here and not by Eva."""
