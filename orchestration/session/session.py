"""The session: one owner of what runs, from flight to flight.

Tests: tests/orchestration/session/test_standby.py, test_flight.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType

from ..errors import BlockError, InputError, NoRoom, reason
from ..fmu.archive import shown
from ..fmu.interfaces import is_path
from ..instances.block import Block, Instance
from ..instances.guest import Guest
from ..instances.isolation import STARTING, IsolatedBlock
from ..instances.law import Law
from ..instances.record.play import RECORD, write_folder
from ..instances.record.recorder import Record, record
from ..instances.slave import Slave
from ..instances.surroundings import Surroundings
from ..master.circuit import Circuit
from ..master.master import Kept, Master, Options
from ..master.recording import Recording
from ..system.observer import Observer
from ..system.starts import Start
from ..system.wiring import Node
from ..temporary import temporary
from .limits import limits
from .open import Opened, with_remedies

Blocks = dict[str, Block]


class Session:
    """An opened scenario with the instances of its FMUs and the bus between them.

    They are made for the first flight and reset for the next, so what a flight gives depends on its start values alone.
    After a failure, and where a reset fails, they are made anew.
    """

    def __init__(
        self,
        opened: Opened,
        resets: bool | None = None,
        verbose: bool = False,
        records: Mapping[str, Path] = MappingProxyType({}),
    ) -> None:
        """`resets`: whether instances are reset from flight to flight; by default those of this project's own native
        FMUs.

        The reset of these leaves nothing behind, which is not known of any other. `verbose` prints what the FMUs log.
        `records` are folders to which the calls of blocks are written.
        """
        self.opened, self._verbose, self._records = opened, verbose, records
        self._resets = all(map(self._is_own, opened.fmus)) if resets is None else resets
        self._stack = ExitStack()
        self._instances: dict[str, Instance] = {}
        self._master: Master | None = None
        self._around: Surroundings | None = None
        self.notes: list[str] = []
        """What FMUs of others have changed in this process, and what became of it."""

    def fly(
        self,
        starts: Mapping[str, Sequence[Start]],
        observers: Sequence[Observer] = (),
        nodes: Sequence[Node] = (),
        *,
        columns: Sequence[Node] = (),
        circuit: Circuit | None = None,
        around: Callable[[Blocks], Blocks] | None = None,
        options: Options = Options(),  # noqa: B008  (it is frozen)
    ) -> Recording:
        """Flies once with these start values. A failing block or a signal ends the flight, and the recording says so.

        `observers` are shown `nodes` after every base step, and `columns` are recorded. `circuit` takes the place of
        the scenario's own; `around` puts other blocks before or beside those of the session. Raises InputError where
        an instance cannot be made, BlockError where its process is ended while it starts.
        """
        circuit = circuit or self.opened.plan.circuit
        recording = self._ready(circuit, columns, nodes, around).run(starts, observers, options)
        if self._around is not None:
            guests = [name for name, block in self._instances.items() if isinstance(block, (Guest, Law))]
            self._around.look(" or ".join(guests), "the run")
        if recording.failure is not None or recording.interrupted or not self._resets:
            recording.closing = self.close()  # FMI allows little after a failure
        return recording

    def kept(self, count: int) -> Kept | None:
        """Returns where the last flight has ended, after so many base steps, for others to go on from there.

        None where not all instances can be reset and save their states; it is of no use once they are closed.
        """
        faults, slaves = self.opened.plan.circuit.faults, list(self._instances.values())
        if not slaves or faults.settings or faults.disturbances or self.opened.rates.substeps:
            return None
        try:
            states = [(block, block.save()) for block in slaves if isinstance(block, Slave)]
        except BlockError:
            return None

        def restore() -> None:
            for block, state in states:
                block.restore(state)

        return Kept(count, restore) if len(states) == len(slaves) else None

    def _ready(
        self,
        circuit: Circuit,
        columns: Sequence[Node],
        nodes: Sequence[Node],
        around: Callable[[Blocks], Blocks] | None,
    ) -> Master:
        """Returns the master of instances in their first state; that of the last flight where it suits.

        Raises InputError.
        """
        if self._instances and not self._reset():
            self.close()
        if not self._instances:
            with ExitStack() as stack:
                self._instances = self._instantiated(stack)
                self._stack = stack.pop_all()
        blocks = {name: self.opened.adapted(block) for name, block in self._instances.items()}
        blocks = blocks if around is None else around(blocks)
        last = self._master
        # What stands before an instance has a state of its own, so it is new for each flight.
        bare = last is not None and blocks == last.blocks
        if (
            last is not None
            and bare
            and last.circuit is circuit
            and (last.columns, last.observed) == (list(columns), list(nodes))
        ):
            return last
        self._master = Master(blocks, circuit, columns, nodes)
        return self._master

    def _reset(self) -> bool:
        """Returns whether all instances stand where they stood at first."""
        try:
            for block in self._instances.values():
                block.reset()
        except BlockError:
            self._resets = False
        return self._resets

    def _instantiated(self, stack: ExitStack) -> dict[str, Instance]:
        """Returns an instance of each FMU, which the stack ends. Raises InputError."""
        opened, scenario, work = self.opened, self.opened.plan.scenario, Path()
        if not all(map(self._is_own, opened.fmus)):
            work = stack.enter_context(temporary())
        instances: dict[str, Instance] = {}
        name = ""
        try:
            for name, fmu in opened.fmus.items():
                own, bound, law = self._is_own(name), limits(scenario, name), scenario.blocks[name].python
                calls = self._recorded(name) if name in self._records else None
                if law:
                    (work / name).mkdir(parents=True, exist_ok=True)
                elif not own:
                    fmu.extract(work / name)
                if law and bound is None:
                    self._around = self._around or Surroundings(self.notes)
                    try:
                        instances[name] = Law(name, fmu.model, fmu.path)
                    finally:
                        self._around.look(name, "reading the law")
                elif bound is None:
                    instances[name] = (
                        Slave(name, fmu, None, self._verbose, calls) if own else self._guest(name, work / name, calls)
                    )
                else:
                    instances[name] = IsolatedBlock(name, fmu, work / name, bound, self._verbose, calls)
                stack.callback(instances[name].close)
            for name in instances:  # all processes have been started before the first is waited for
                if isinstance(block := instances[name], IsolatedBlock):
                    block.started()
        except NoRoom:
            raise
        except InputError as error:
            raise InputError(*with_remedies(error, scenario, name)) from None
        except BlockError as error:
            if error.call == STARTING:
                raise
            message = f"{shown(opened.fmus[name].path)}: {error}"
            key = "python" if scenario.blocks[name].python else "fmu"
            raise InputError(scenario.error(("blocks", name, key), message)) from None
        return instances

    def _recorded(self, name: str) -> Record:
        """Returns the record of a block's calls, in a folder with all that plays it. Raises InputError."""
        folder, fmu = self._records[name], self.opened.fmus[name]
        if self.opened.plan.scenario.blocks[name].python:
            raise InputError(f"--record-calls {name}: it is a law in Python, which is not called by FMI")
        try:
            write_folder(folder, fmu)
        except OSError as error:
            raise InputError(f"{folder}: the calls cannot be recorded: {reason(error)}") from None
        return record(folder / RECORD, fmu)

    def _guest(self, name: str, folder: Path, calls: Record | None) -> Guest:
        """Returns the instance of an FMU of others in this process."""
        self._around = self._around or Surroundings(self.notes)
        return Guest(self._around, name, self.opened.fmus[name], folder, self._verbose, calls)

    def _is_own(self, name: str) -> bool:
        """Returns whether a block is one of this project's own native FMUs, in this process."""
        scenario = self.opened.plan.scenario
        entry = scenario.blocks[name]
        native = not entry.python and (entry.flavour or scenario.flavour) == "native"
        return native and not is_path(entry.fmu) and limits(scenario, name) is None

    def close(self) -> BlockError | None:
        """Ends the instances, and returns what went wrong in that; the next flight makes others."""
        instances, self._instances, self._master = self._instances, {}, None
        self._stack.close()
        if self._around is not None:
            self._around.close()
            self._around = None
        return next((failure for block in instances.values() if (failure := getattr(block, "failure", None))), None)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
