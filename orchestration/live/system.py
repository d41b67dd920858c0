"""A scenario made ready for a page: its blocks, sliders and faults as WebAssembly, and the native run that it is held
against.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from fmus.block import Block
from fmus.native.toolchain import CompilerError
from fmus.native.wasm import module

from ..errors import InputError, Problems
from ..fmu.interfaces import is_path
from ..scenario.faults import Fault
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..session.limits import limits
from ..session.open import Opened, open_scenario
from ..session.read import load
from ..system.faults import Faults, Setting, resolve
from ..system.starts import Start
from .sliders import Control, controls, start_value
from .suggestions import with_suggestions
from .tables import Tables, tables

_HERE = Path(__file__).parent
_LOOP = _HERE.parent / "master"


@dataclass(frozen=True)
class Live:
    """Data of a page."""

    scenario: Scenario
    opened: Opened
    wasm: bytes
    tables: Tables
    controls: list[Control]
    faults: list[Fault]
    """Those of the scenario, then those that only the page injects."""
    each: list[Faults]
    """What each does; nothing in a run that an option shortens so that it ends before."""


def prepare(scenario: Scenario) -> Live:
    """Checks a scenario and compiles it. Raises InputError with everything that a page cannot have."""
    _refuse(scenario)
    if scenario.live is None:
        scenario = with_suggestions(scenario, open_scenario(scenario).plan)
    both, opened, made, each = checked(scenario)
    plan = opened.plan
    if changed := sorted({*opened.rates.substeps, *opened.prepared.fits}):
        key = ("blocks", changed[0])
        raise InputError(both.error(key, "a page has no adapter and no steps within a step; remedy: orchestrate run"))
    starts = {name: list(plan.starts.get(name, ())) for name in plan.models}
    for node in (node for control in made for nodes in control.nodes for node in nodes):
        if node.element not in {start.element for start in starts[node.block]}:
            starts[node.block].append(Start(node.element, start_value(plan, node)))
    code = {name: entry.fmu for name, entry in both.blocks.items()}
    tabled = tables(plan, code, starts, each)
    return Live(scenario, opened, _compiled(scenario, code, tabled), tabled, made, both.faults, each)


def checked(scenario: Scenario) -> tuple[Scenario, Opened, list[Control], list[Faults]]:
    """Returns the scenario with the faults of its `live` as its own, its blocks, its sliders, and each fault alone.

    Raises InputError with everything in `live` that does not fit the blocks.
    """
    own = scenario.live.faults if scenario.live else []
    source = scenario.source
    for number in range(len(own)):
        data = source.data["live"]["faults"][number]
        entry = {key: value for key, value in data.items() if key != "name"}
        source = source.with_item("faults", entry, source.where(("live", "faults", number)))
    both = load(source) if own else scenario
    problems = Problems()
    with problems.gathered():
        opened = open_scenario(both)
    with problems.gathered():
        made = controls(scenario, open_scenario(scenario).plan)
    if problems:
        raise InputError(*dict.fromkeys(problems))
    plan = opened.plan
    each = [resolve(both.model_copy(update={"faults": [fault]}), plan.models, plan.wiring) for fault in both.faults]
    for number, faults in enumerate(each):
        _refuse_text(both, ("faults", number), faults.settings)
    _refuse_text(both, ("timeline",), [setting for setting in plan.faults.settings if not setting.of_fault])
    return both, opened, made, each


def _refuse_text(scenario: Scenario, key: Key, settings: Iterable[Setting]) -> None:
    if any(isinstance(value, str) for setting in settings for _, value in setting.values):
        raise InputError(scenario.error(key, "a page sets no text during a run"))


def _compiled(scenario: Scenario, code: dict[str, str], tabled: Tables) -> bytes:
    blocks = [Block.named(name) for name in dict.fromkeys(code.values())]
    with TemporaryDirectory() as folder:
        generated = Path(folder, "tables.c")
        generated.write_text(tabled.text, "utf-8")
        sources = [generated, _HERE / "live.c", _HERE / "changes.c", _LOOP / "loop.c"]
        try:
            return module("live.wasm", blocks, sources, [_HERE, _LOOP])
        except CompilerError as error:
            raise InputError(scenario.error((), f"cannot be compiled to WebAssembly: {error}")) from None


def _refuse(scenario: Scenario) -> None:
    """Raises InputError for each block that a page cannot have."""
    errors = []
    for name, entry in scenario.blocks.items():
        key = ("blocks", name)
        if entry.telemetry is not None:
            message = f"{name} is a record, which a page has not; remedy: orchestrate run"
            errors.append(scenario.error((*key, "telemetry"), message))
        elif is_path(entry.fmu):
            what = f"{entry.fmu} is an FMU in binaries, which no browser runs; expected one of the project's own blocks"
            errors.append(scenario.error((*key, "fmu"), f"{what}; remedy: orchestrate run"))
        elif (entry.flavour or scenario.flavour) != "native":
            where = (*key, "flavour") if entry.flavour else ("flavour",)
            message = f"{name} is of the Python flavour, which no browser runs; remedy: flavour: native"
            errors.append(scenario.error(where, message))
        elif limits(scenario, name) is not None:
            where = (*key, "isolation") if entry.isolation else ("isolation",)
            message = f"{name} runs in a process of its own, which a page has not; remedy: isolation: none"
            errors.append(scenario.error(where, message))
    if errors:
        raise InputError(*dict.fromkeys(errors))
