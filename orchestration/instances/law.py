"""A law in a Python file as a block: its ports are those of an interface, and no FMU is built.

The file has a function `step(inputs, parameters, t, h)`, or one class with such a method, which remembers what it
likes.
Tests: tests/orchestration/instances/test_law.py.
"""

from __future__ import annotations

import copy
import os
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import CodeType, SimpleNamespace
from typing import Any

import numpy as np

from ..errors import BlockError
from ..fmu.model import Element, Floats, Model, Variable
from ..foreign import shown, told
from .guest import TRACE

ESTIMATE = "_estimate"
"""At the end of an output's name: where others take it in and a law leaves it out, it is the input of that name."""


class Law:
    """An instance. `inputs` and `parameters` are given to the law as attributes by the names of the ports, in SI units:
    numbers, arrays of the port's shape, items of enumerations by their names. It returns a mapping from names of
    outputs to values; what it leaves out keeps its last value, zero at first, but for what other blocks take in, and
    for an estimate of an input, which is the input itself.

    t s is the instant of the inputs, h s the time since the last call; at t = 0 h is 0.
    """

    log: Sequence[str] = ()

    def __init__(self, name: str, model: Model, path: Path) -> None:
        """Raises BlockError where the file cannot be read, or has no law."""
        self.name, self.model, self._path, self._process = name, model, path, os.getpid()
        try:
            self._code = compile(path.read_text("utf-8"), str(path), "exec")
        except OSError as error:
            raise BlockError(name, "reading the law", f"{path}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise BlockError(name, "reading the law", f"{path}: expected text in UTF-8, found {error.reason}") from None
        except (SyntaxError, ValueError) as error:
            line = getattr(error, "lineno", None)
            raise BlockError(name, "reading the law", f"{path}:{line or 1}: {error.args[0]}") from None
        self.reset()

    def reset(self) -> None:
        """Runs the file anew, so that nothing is left of the last run."""
        starts = self.model.starts
        self._values: dict[Element, Any] = {
            element: starts.get(element, "" if variable.type == "string" else 0.0)
            for variable in self.model.variables.values()
            for element in variable.elements
        }
        self._step, self._law = self._loaded(self._code)
        self._given: dict[str, Any] = {}
        self._parameters: SimpleNamespace | None = None
        self._running, self._last = False, 0.0

    def _loaded(self, code: CodeType) -> tuple[Callable[..., Any], Any]:
        """Returns the law's function and, of a class, its object."""
        module: dict[str, Any] = {"__name__": "law", "__file__": str(self._path)}
        self._guarded("reading the law", lambda: exec(code, module))
        if callable(step := module.get("step")):
            return step, None
        classes = [c for c in module.values() if isinstance(c, type) and c.__module__ == "law" and hasattr(c, "step")]
        if len(classes) != 1:
            found = f"{len(classes)} classes with one" if classes else "neither"
            problem = (
                f"{self._path}: expected a function step(inputs, parameters, t, h) or one class with it, found {found}"
            )
            raise BlockError(self.name, "reading the law", problem)
        law: Any = self._guarded("reading the law", classes[0])
        return law.step, law

    def _guarded(self, call: str, work: Callable[[], Any]) -> Any:
        """Makes what it raises the block's error, and no end of the run but by its status; only a signal is one."""
        TRACE.at(self.name, call)
        try:
            return work()
        except BaseException as error:
            raise self._told(call, error) from None
        finally:
            self._leave_copy()

    def _leave_copy(self) -> None:
        """Ends this process where it is a copy that the law has made (os.fork): one is enough to write results."""
        if os.getpid() != self._process:
            os._exit(0)

    def _told(self, call: str, error: BaseException) -> BlockError:
        """The error with the line of the law's own file at which it was raised; a signal's is raised again."""
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(self._path)]
        where = f"{self._path}:{frames[-1].lineno}: " if frames else f"{self._path}: "
        there = ""
        if isinstance(error, AttributeError) and isinstance(error.obj, SimpleNamespace):
            there = f"; there are {', '.join(vars(error.obj))}"
        return BlockError(self.name, call, f"{where}{told(error)}{there}")

    # ------------------------------------------------------------ values

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        self._values.update(values)
        self._parameters = None

    def get(self, elements: Sequence[Element]) -> list[float]:
        """In initialization the law is asked on a copy, so that it remembers nothing of it."""
        if not self._running and any(self.model.variables[e.variable].causality == "output" for e in elements):
            step = self._step
            if self._law is not None:
                step = self._guarded("copying the law", lambda: copy.deepcopy(self._law).step)
            TRACE.at(self.name, "step in initialization")
            self._given = self._outputs(step, self._namespace("input"), 0.0, 0.0)
        return [float(self._value(element)) for element in elements]

    def _value(self, element: Element) -> Any:
        given = self._given.get(element.variable)
        return self._values[element] if given is None else given[element.position]

    def _namespace(self, causality: str) -> SimpleNamespace:
        return SimpleNamespace(**{v.name: self._as_given(v) for v in self.model.of(causality)})

    def _as_given(self, variable: Variable) -> Any:
        values = [self._values[element] for element in variable.elements]
        if variable.items and not variable.shape:
            return next((item for item, number in variable.items if number == values[0]), values[0])
        if not variable.shape:
            return bool(values[0]) if variable.type == "boolean" else values[0]
        array = np.array(values).reshape(variable.shape)
        array.flags.writeable = False
        return array

    def _outputs(self, step: Callable[..., Any], inputs: SimpleNamespace, t: float, h: float) -> dict[str, Any]:
        """Returns what the law gives, each output flat. Raises BlockError, with the line of the file or the output's
        name.
        """
        if self._parameters is None:
            self._parameters = self._namespace("parameter")
        try:
            flat = self._flat(step(inputs, self._parameters, t, h), inputs)
        except BlockError:
            raise
        except BaseException as error:
            raise self._told("step", error) from None
        finally:
            self._leave_copy()
        return flat

    def _flat(self, given: Any, inputs: SimpleNamespace) -> dict[str, Any]:
        """The outputs that a step returned, by name, each flat. Raises BlockError, and what classes of the law's own
        raise."""
        if not isinstance(given, Mapping):
            raise self._refused(f"expected a mapping such as {{'tau_cmd_B': [...]}}, found {type(given).__name__}")
        flat = dict(self._given)
        for name, value in given.items():
            variable = self.model.variables.get(name)
            if variable is None or variable.causality != "output":
                known = ", ".join(v.name for v in self.model.of("output"))
                raise self._refused(f"there is no output {shown(name)}; expected some of {known}")
            try:
                array = np.asarray(value, np.float64)
            except (TypeError, ValueError, OverflowError):
                raise self._refused(f"{name}: expected {variable.kind}, found {shown(value)}") from None
            if array.shape != variable.shape:
                raise self._refused(f"{name}: expected {variable.kind}, found one of shape {list(array.shape)}")
            flat[name] = array.ravel()
        for name in self.model.needed:
            if name not in given and (seen := getattr(inputs, name.removesuffix(ESTIMATE), None)) is not None:
                flat[name] = np.asarray(seen, np.float64).ravel()
        if missing := self.model.needed - flat.keys():
            raise self._refused(
                f"expected {', '.join(sorted(missing))}, which other blocks take in, found {shown(list(given))}"
            )
        return flat

    def _refused(self, problem: str) -> BlockError:
        return BlockError(self.name, "step", f"{self._path}: step returned what is no outputs: {problem}")

    # ------------------------------------------------------------ the course of a run

    def enter(self, stop: float) -> None:
        """Nothing: the law begins at the end of initialization."""

    def leave(self) -> None:
        TRACE.at(self.name, "step")
        self._given = self._outputs(self._step, self._namespace("input"), 0.0, 0.0)
        self._running = True

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._from, self._into = np.zeros(len(inputs)), into
        self._inputs = self._namespace("input")
        self._takes = []
        for variable in self.model.of("input"):
            places = [inputs.index(e) if e in inputs else -1 for e in variable.elements]
            if max(places, default=-1) >= 0:
                self._takes.append((variable, places, self._reader(variable, places)))
        self._gives: list[tuple[str, list[int], list[int]]] = []
        for name in dict.fromkeys(e.variable for e in outputs):
            pairs = [(place, e.position) for place, e in enumerate(outputs) if e.variable == name]
            self._gives.append((name, [p for p, _ in pairs], [p for _, p in pairs]))
        self._starts = np.array([self._values[e] for e in outputs], np.float64)
        self.get_all()
        return self._from

    def _reader(self, variable: Variable, places: list[int]) -> Callable[[], Any]:
        """A function that takes an input from the array of all; a view where its elements stand side by side."""
        first = places[0]
        if variable.shape and places == list(range(first, first + variable.size)):
            view = self._from[first : first + variable.size].reshape(variable.shape)
            view.flags.writeable = False
            return lambda: view
        elements = variable.elements

        def slow() -> Any:
            for element, place in zip(elements, places, strict=True):
                if place >= 0:
                    self._values[element] = self._from[place]
            return self._as_given(variable)

        return (
            slow if variable.shape or variable.items or variable.type == "boolean" else lambda: float(self._from[first])
        )

    def set_inputs(self) -> None:
        """The step reads them."""

    def do_step(self, time: float, step: float) -> None:
        inputs = self._inputs
        for variable, _, take in self._takes:
            setattr(inputs, variable.name, take())
        self._given = self._outputs(self._step, inputs, time + step, step)

    def get_all(self) -> None:
        into, given = self._into, self._given
        into[:] = self._starts  # of outputs that the law leaves out
        for name, places, positions in self._gives:
            if (flat := given.get(name)) is not None:
                into[places] = flat[positions]

    get_live = get_all

    def close(self) -> None:
        """Nothing is held."""
