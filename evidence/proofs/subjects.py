"""What is proved: each subject is a program for Frama-C, its sources, and how closely it is followed.

Shows FC-1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import yaml

from fmus.block import Block, natives
from fmus.link import NATIVE
from fmus.native import COMMON, generated_sources
from fmus.native.toolchain import FREESTANDING
from fmus.places import PACKAGES

from .analysis import Alarm, Result, analyse
from .contracts import BY_WP
from .harness import Range, harness
from .rounds import copy, refuse_assumptions

GOALS = ("user assertion", "loop invariant")
"""Kinds of what WP proves beside postconditions; of memory it looks at nothing."""
HERE = Path(__file__).parent
REACHED = HERE / "reached.yaml"
CALLS = ("check", "prepare", "start", "outputs", "step")
"""What a block offers to flight software."""
ELEMENTARY = FREESTANDING / "elementary.c"
SPECIFIED = ("nearest_rotation", "log1p")
"""Functions whose contract stands in for their body where numbers have limits (arguments.yaml)."""


@dataclass(frozen=True)
class Subject:
    """A block with a range of numbers, or a program of this folder with its sources."""

    name: str
    span: Range | None = None
    """None: the program is `name`.c in this folder."""
    precision: int = 3
    closely: tuple[str, ...] = ()
    """Functions in which paths are kept apart."""
    by_contract: tuple[str, ...] = ()
    """Functions whose contract stands in for their body, which another program proves."""
    sources: tuple[Path, ...] = ()
    headers: tuple[Path, ...] = ()
    ports: str = ""
    """The block whose generated headers a program of this folder reads."""
    paths: int = 2000
    """How many paths are kept apart in each of `closely`."""
    options: tuple[str, ...] = ()
    within: bool = False
    """Numbers within the block may be NaN or infinite, where outputs have limits; else no operation may give one."""
    quick: bool = False
    """Below ten seconds of one core."""

    @property
    def title(self) -> str:
        return self.name if self.span is None else f"{self.name}, {self.span}"

    @property
    def block(self) -> Block | None:
        """The block whose generated headers it reads, if any."""
        name = self.ports or (self.name if self.span else "")
        return Block.named(name) if name else None

    def folders(self) -> list[Path]:
        """Returns where its C stands."""
        return natives(self.block.folder) if self.block else [path.parent for path in self.sources]

    def prove(self, folder: Path, root: Path = PACKAGES) -> Result:
        """Runs Eva in `folder`; `root`: a copy of the packages, with changes. Raises InputError."""
        folder.mkdir(parents=True, exist_ok=True)
        program, sources, headers = folder / f"{self.name}.c", list(self.sources), [*self.headers, COMMON]
        if self.span is None:
            program.write_bytes((HERE / program.name).read_bytes())
        if (block := self.block) is not None:
            own = natives(block.folder) if self.span else [block.folder / "native"]
            headers = [*own, *headers]
            for name, text in generated_sources(block.interface, block.folder).items():
                (folder / name).write_text(text, "utf-8")
            if self.span:
                sources += [*(path for native in own for path in sorted(native.rglob("*.c"))), ELEMENTARY]
                program = folder / "harness.c"
                program.write_text(harness(block.interface, self.span), "utf-8")
        refuse_assumptions(root)
        loops = copy(root, folder / "packages")
        root = folder / "packages"
        sources, headers = ([root / p.relative_to(PACKAGES) for p in paths] for paths in (sources, headers))
        define, prelude = self.definitions(), HERE / "prelude.h"
        result = analyse(program, sources, headers, self.words(), define, prelude, self.span == "limits", loops)
        alarms = (alarm for alarm in result.alarms if not self.is_proved_elsewhere(alarm))
        return replace(result, alarms=(*alarms, *self.unreached(result)))

    def unreached(self, result: Result) -> Iterator[Alarm]:
        """Calls that the program never makes, as where the check refuses all, and statements that it once reached."""
        if self.span is not None:
            code = Block.named(self.name).interface.code
            for call in (*(f"{code}_{call}" for call in CALLS), "read_outputs"):
                if call not in result.functions:
                    yield Alarm("harness.c", 0, call, "unreached", "the program never enters it")
        before = reached().get(self.title, 0)
        if result.statements[0] < before:
            text = f"{result.statements[0]} statements, {before} before; remedy: what refuses more? else {REACHED.name}"
            yield Alarm("harness.c" if self.span else f"{self.name}.c", 0, "main", "unreached", text)

    def is_proved_elsewhere(self, alarm: Alarm) -> bool:
        """A postcondition of a function whose body another program follows, or what WP proves of a function."""
        if (alarm.file, alarm.function) in BY_WP:
            return alarm.kind in ("postcondition", *(GOALS if alarm.file == "finite.h" else ()))
        return alarm.kind == "postcondition" and alarm.function in self.by_contract

    def definitions(self) -> tuple[str, ...]:
        """Macros of the C that the analysis sees."""
        return {"limits": ("PROOF_WITHIN_LIMITS",), "any": ("PROOF_APART",), None: ()}[self.span]

    def words(self) -> list[str]:
        """Options of Eva for this subject."""
        words = ["-eva-precision", str(self.precision), *self.options, "-warn-special-float"]
        words.append("non-finite" if self.span == "limits" and not self.within else "none")
        if specified := [*self.by_contract, *(SPECIFIED if self.span == "limits" else ())]:
            words += ["-eva-use-spec", ",".join(specified)]
        if self.span is None:
            return words
        code = Block.named(self.name).interface.code
        apart = {"fly": 0, "main": 200, "change": 200, f"{code}_check": 200, **dict.fromkeys(self.closely, self.paths)}
        return [*words, "-eva-slevel-function", ",".join(f"{name}:{n}" for name, n in apart.items())]


def reached() -> dict[str, int]:
    """The statements that the proof of each title reached when it was last made whole, less one in a hundred."""
    kept = yaml.safe_load(REACHED.read_text("utf-8")) if REACHED.exists() else {}
    return {title: int(0.99 * n) for title, n in kept.items()}


_BUILTINS = ("-eva-no-builtins-auto", "-eva-builtin", "memcpy:Frama_C_memcpy")
_FRAME = (
    *("-eva-slevel", "5000", "-eva-split-limit", "100"),
    *("-eva-split-return-function", "up_to_mark:full,take_number:full"),
)
_UNROLL = ("-eva-auto-loop-unroll", "64")


def _whole(
    name: str,
    *closely: str,
    by_contract: tuple[str, ...] = (),
    unroll: int = 64,
    paths: int = 2000,
    options: tuple[str, ...] = (),
) -> Subject:
    """A block with any numbers, not followed closely but where it refuses.

    Loops of up to `unroll` rounds are followed round by round; `paths` are kept apart in functions.
    """
    code = Block.named(name).interface.code
    calls = ("look", "move", *(f"{code}_{call}" for call in ("start", "outputs", "step")))
    options = ("-eva-auto-loop-unroll", str(unroll), *options)
    return Subject(name, "any", 0, (*calls, *closely), by_contract, paths=paths, options=options)


def _estimator(name: str) -> Subject:
    contract = ("estimator_correct_states",)
    return _whole(name, "check_choices", "epoch_read", by_contract=contract, unroll=12, paths=20)


SUBJECTS = (
    Subject("functions", None, 5, sources=(ELEMENTARY,), options=_BUILTINS, quick=True),
    Subject("date", None, 6, options=("-eva-slevel", "3000"), quick=True),
    Subject("field", None, 0, options=_UNROLL, quick=True),
    Subject(
        *("filter", None, 0),
        sources=(Block.named("estimator").folder / "native" / "filter.c",),
        headers=(Block.named("estimator").folder / "native",),
        options=("-eva-auto-loop-unroll", "160"),
        quick=True,
    ),
    Subject(
        *("box_qp", None, 0),
        sources=(Block.named("controller_planned").folder / "native" / "plan" / "box_qp.c",),
        ports="controller_planned",
        options=_UNROLL,
        quick=True,
    ),
    Subject("frame", None, 4, sources=(NATIVE / "frame.c",), headers=(NATIVE,), options=_FRAME),
    _whole("allocator"),
    Subject("allocator", "limits", quick=True),
    Subject("allocator_bounded", "limits", within=True, quick=True),
    _whole("allocator_bounded", "are_rods", "are_wheels", "are_inputs"),
    _whole("allocator_bounded_wheels", "are_rods", "are_wheels", "are_inputs"),
    Subject("controller", "any", 6),
    Subject("controller", "limits"),
    _whole("supervisor"),
    _estimator("estimator"),
    _whole("controller_wheels", "errors_of", "outputs_of", "reference_at", "reference_lvlh"),
    _estimator("estimator_wheels"),
    _whole(
        *("controller_planned", "check_choices", "epoch_read"),
        by_contract=("controller_planned_box_qp", "controller_planned_solve_free"),
        unroll=8,
        paths=20,
    ),
    _whole(
        *("controller_planned_wheels", "check_choices", "epoch_read", "advance", "target_of"),
        *("reference_at", "reference_lvlh", "controller_planned_wheels_take_sample"),
        *(f"controller_planned_{call}" for call in ("start", "outputs", "step")),
        *(f"controller_planned_wheels_{call}_few" for call in ("outputs", "step")),
        by_contract=("controller_planned_box_qp", "controller_planned_solve_free"),
        unroll=8,
        paths=20,
        options=("-eva-split-return-function", "controller_planned_wheels_step_few:full"),
    ),
)
