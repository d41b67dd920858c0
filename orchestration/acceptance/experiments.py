"""Reads the experiments of an FMU that carries reference data (FMI-LS-REF) from its manifest and its files.

Tests: tests/orchestration/acceptance/test_references.py.

FMI-LS-REF 1.0.0-beta.1 (July 2026) names the files of `extra/org.fmi-standard.fmi-ls-ref/` and their roles, and leaves
the experiments to the Modelica Association's Experiments Format. Three older and newer forms are read, too:
experiments in the manifest (1.0.0-rc.1 of 2024), the settings in an element `TransientSimulation` (the format's draft
of autumn 2026), and a result of the default experiment without any (the Reference FMUs).
"""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fmus.contents.references import FOLDER

from ..errors import InputError, hint
from ..fmu.head import ANNOTATION
from ..fmu.model import Element, Floats, Model
from ..fmu.zipped import reading, shown
from ..quantities import QuantityError
from ..ssp.documents import check as check_schema
from ..ssp.reader import start_value
from ..ssp.structure import parameters
from .carried import Carried, Missing

MANIFEST = f"{FOLDER}/fmi-ls-manifest.xml"
EXPERIMENTS = ("application/x-ma-hs-experiments", "application/x-ma-ls-experiments")
"""Type of an experiments file, as FMI-LS-REF 1.0.0-beta.1 has it and as its own example still does."""
PARAMETERS = "application/x-ssp-parameter-set"
STEPS_MAX = 1e6
_ANALYSES = (
    "SteadyState",
    "ParameterOptimization",
    "SetPointOptimization",
    "SensitivityAnalysis",
    "TrajectoryOptimization",
    "Linearization",
)


@dataclass(frozen=True)
class Table:
    """A time series: columns (rows,) of scalars of the FMU."""

    where: str
    time: Floats
    """It may stand still once, at an event."""
    columns: dict[Element, Floats]
    left_out: tuple[str, ...] = ()
    """Columns of text, and of others that are not exchanged here."""


@dataclass
class Experiment:
    """An experiment says what to set, what to feed, and what has to come out."""

    name: str
    step: float
    stop: float
    references: Table
    stimuli: Table | None = None
    start: dict[str, Any] = field(default_factory=dict)
    """Parameters by the names of elements, `x[1,2]`."""
    tolerance: float | None = None
    """Relative to the largest value of a signal."""
    tolerances: dict[Element, float] = field(default_factory=dict)
    """Absolute, of single signals."""


def read(path: Path, model: Model, default: Any) -> tuple[list[Experiment], list[str]]:
    """Returns the experiments of an FMU, and why others cannot be played; none without a manifest.

    `default` is FMPy's default experiment of the FMU, or None. Raises InputError with the file and the line.
    """
    with reading(path, "FMU") as archive:
        if MANIFEST not in archive.namelist():
            return [], []
        return _Reader(path, archive, model, default).read()


@dataclass
class _Reader(Carried):
    model: Model
    default: Any

    def read(self) -> tuple[list[Experiment], list[str]]:
        root = self.root(MANIFEST)
        if root.tag != "fmiReferences":
            raise self.wrong(MANIFEST, root, f"expected the element fmiReferences, found {root.tag}")
        files = [(MANIFEST, entry) for entry in root.findall("Experiment")]
        notes, results = [], []
        for entry in root.findall("Related"):
            role = self.required(MANIFEST, entry, "role")
            source = self.required(MANIFEST, entry, "source")
            try:
                if role.partition("/")[0] == "experiment" and entry.get("type") in EXPERIMENTS:
                    name = self.file(MANIFEST, entry, source)
                    experiments = self.root(name)
                    if (tag := experiments.tag) != "Experiments":
                        raise self.wrong(name, experiments, f"expected the element Experiments, found {tag}")
                    files += [(name, each) for each in experiments.findall("Experiment")]
                elif role == "result" and entry.get("type") == "text/csv":
                    results.append((source, entry))
            except Missing as error:
                notes.append(str(error))
        found = []
        for where, entry in files:
            try:
                found.append(self._experiment(where, entry))
            except Missing as error:
                notes.append(f"experiment {entry.get('name')!r}: {error}")
        if not files:
            for source, entry in results:
                try:
                    found.append(self._made("default experiment", MANIFEST, entry, source, {}))
                except Missing as error:
                    notes.append(str(error))
        return found, notes

    def _experiment(self, where: str, entry: Any) -> Experiment:
        name = self.required(where, entry, "name")
        for analysis in _ANALYSES:
            if entry.find(analysis) is not None:
                raise Missing(f"a {analysis}; only simulations over time are played")
        transient = entry.find("TransientSimulation")
        settings = {
            key: self.number(where, given, key)
            for given in (entry, *(() if transient is None else (transient,)))
            for key in ("startTime", "stopTime", "stepSize", "tolerance")
            if given.get(key) is not None
        }
        references = entry.find("References")
        if references is None:
            raise Missing("no References")
        made = self._made(name, where, references, self.required(where, references, "source"), settings)
        made.tolerances = dict(self._tolerances(where, references))
        stimuli, given = entry.find("Stimuli"), entry.find("Parameters")
        if stimuli is not None:
            made.stimuli = self._table(where, stimuli, self.required(where, stimuli, "source"), "input")
        if given is not None:
            made.start = self._parameters(where, given)
        return made

    def _made(self, name: str, where: str, entry: Any, source: str, settings: dict[str, float]) -> Experiment:
        table = self._table(where, entry, source, "output")
        for key in ("startTime", "stopTime", "stepSize"):
            if key not in settings and (value := getattr(self.default, key, None)) is not None:
                settings[key] = float(value)
        if settings.get("startTime", 0.0) != 0.0:
            raise Missing(f"it starts at {settings['startTime']:g} s; only experiments from 0 s are played")
        step = settings.get("stepSize", float(np.diff(np.unique(table.time)).min()))
        stop = min(settings.get("stopTime", math.inf), float(table.time[-1]))
        if not (0.0 < step <= stop):
            raise self.wrong(where, entry, f"expected a step above 0 and up to the stop time, found {step:g} s")
        if stop / step > STEPS_MAX:
            raise Missing(f"{stop / step:.3g} steps; at most {STEPS_MAX:.0e} are played")
        return Experiment(name, step, stop, table, tolerance=settings.get("tolerance"))

    def _tolerances(self, where: str, references: Any) -> Iterator[tuple[Element, float]]:
        for entry in references.findall(f"Annotations/Annotation[@type='{ANNOTATION}']/Tolerance"):
            element = self._element(where, entry.sourceline, self.required(where, entry, "name"), "output")
            yield element, self.number(where, entry, "absolute")

    def _parameters(self, where: str, entry: Any) -> dict[str, Any]:
        if entry.get("type", PARAMETERS) != PARAMETERS:
            raise Missing(f"parameters of the type {entry.get('type')!r}; expected {PARAMETERS}")
        name = self.file(where, entry, self.required(where, entry, "source"))
        root = self.root(name)
        check_schema(self.path, name, root, "ssv:ParameterSet")
        start: dict[str, Any] = {}
        for label, given in parameters(root):
            element = self._element(name, None, label, "parameter")
            variable = self.model.variables[element.variable].at([element.position])
            try:
                start[variable.label(element.position).replace("][", ",")] = start_value(given, variable)
            except (ValueError, QuantityError) as error:
                raise InputError(f"{shown(self.path)}: {name}: {label}: {error}") from None
        return start

    def _table(self, where: str, entry: Any, source: str, causality: str) -> Table:
        if entry.get("type", "text/csv") != "text/csv":
            raise Missing(f"{source} is of the type {entry.get('type')!r}; only text/csv is read")
        name = self.file(where, entry, source)
        try:
            rows = list(csv.reader(io.StringIO(self.data(name).decode("utf-8-sig"))))
        except (UnicodeDecodeError, csv.Error) as error:
            raise self.located(name, None, f"no CSV file in UTF-8: {error}") from None
        if len(rows := [row for row in rows if row]) < 3 or rows[0][0].strip() != "time":
            raise self.located(name, 1, "expected a column 'time', then signals, in two rows or more")
        labels = [label.strip() for label in rows[0]]
        texts = {v.name for v in self.model.variables.values() if v.type == "string"} | self.model.left_out.keys()
        left_out = [i for i, label in enumerate(labels) if label in texts]
        read = {i: label for i, label in enumerate(labels) if i and i not in left_out}
        elements = {i: self._array(name, label, causality) for i, label in read.items()}
        places = [Element("time", 0), *(element for array in elements.values() for element in array)]
        values = np.zeros((len(rows) - 1, len(places)))
        for i, row in enumerate(rows[1:]):
            if len(row) != len(rows[0]):
                raise self.located(name, i + 2, f"expected {len(rows[0])} values, found {len(row)}")
            words = (row[j].split() if len(array) > 1 else [row[j].strip()] for j, array in elements.items())
            cells = [row[0].strip(), *itertools.chain.from_iterable(words)]
            if len(cells) != len(places):
                raise self.located(name, i + 2, f"expected {len(places)} values in arrays, found {len(cells)}")
            try:
                values[i] = [float(_NUMBERS.get(cell.lower(), cell)) for cell in cells]
            except ValueError as error:
                raise self.located(name, i + 2, str(error)) from None
        if len(at := np.argwhere(~np.isfinite(values))):
            raise self.located(name, int(at[0][0]) + 2, "expected finite numbers")
        if not (np.diff(values[:, 0]) >= 0.0).all() or values[0, 0] != 0.0 or values[-1, 0] == 0.0:
            raise self.located(name, 2, "expected times that begin at 0 and rise")
        columns = {element: values[:, i] for i, element in enumerate(places) if i}
        return Table(f"{shown(self.path)}: {name}", values[:, 0], columns, tuple(labels[i] for i in left_out))

    def _array(self, where: str, label: str, causality: str) -> list[Element]:
        """The elements of a column: of FMI 3.0 an array's in one, with blanks between them."""
        array = self.model.variables.get(label)
        if array is None or not array.shape:
            return [self._element(where, 1, label, causality)]
        self._element(where, 1, array.label(0), causality)
        return list(array.elements)

    def _element(self, where: str, line: int | None, name: str, causality: str) -> Element:
        if not hasattr(self, "_labels"):
            self._labels = {
                variable.label(position): Element(variable.name, position)
                for variable in self.model.variables.values()
                for position in range(variable.size)
            }
        label = "][".join(part.strip() for part in name.split(","))
        if label not in self._labels:
            raise self.located(where, line, f"the FMU has no variable {name!r}{hint(label, self._labels)}")
        element = self._labels[label]
        found = self.model.variables[element.variable].causality
        if causality != "output" and found != causality:
            raise self.located(where, line, f"{name} is no {causality}; its causality is {found}")
        return element


_NUMBERS = {"true": "1", "false": "0"}
