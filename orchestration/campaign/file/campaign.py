"""The format of campaign files: these models are its schema.

`orchestrate schema --campaign` prints it as JSON Schema, for editors.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, WithJsonSchema, field_validator, model_validator

from ...errors import hint
from ...scenario.expectations import Bound
from ...scenario.metrics import Metric
from ...scenario.references import Name
from ...scenario.types import NUMBER_OR_TEXT, Counted, Extending, Flavour, Model, Quantity, Value
from .analysis import Search, Sensitivity
from .distributions import Varied

Variable = Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")]


class Requirement(Model):
    """Requirement on a share of all runs: a bound on a metric, or an expectation of the scenario."""

    name: str = Field(strict=True, min_length=1)
    """A sentence that reads well in the table at the end."""
    metric: str | None = None
    """The metric that is held against the bound."""
    expectation: str | None = None
    """In place of a metric: the name of an expectation of the scenario, to be met."""
    below: Annotated[Quantity, Counted] | None = None
    """metric < bound"""
    above: Annotated[Quantity, Counted] | None = None
    """metric > bound"""
    within: Annotated[
        Any, Counted, WithJsonSchema({"anyOf": [*NUMBER_OR_TEXT, {"type": "array", "minItems": 2, "maxItems": 2}]})
    ] = None
    """|metric| <= bound, or low <= metric <= high for `[low, high]`"""
    probability: float = Field(gt=0.0, lt=1.0)
    """The share of all runs that has to meet it. A run that fails meets nothing."""
    confidence: float = Field(0.95, gt=0.0, lt=1.0)
    """How sure the verdict has to be."""

    @model_validator(mode="after")
    def _one(self) -> Requirement:
        if (self.metric is None) == (self.expectation is None):
            raise ValueError("expected exactly one of metric and expectation")
        ends = {name: value for name in ("below", "above", "within") if (value := getattr(self, name)) is not None}
        if self.expectation is not None:
            if ends:
                raise ValueError(f"an expectation has its own bound; expected no '{next(iter(ends))}'")
            return self
        if len(ends) != 1:
            raise ValueError(f"expected exactly one of below, above, within; found {' and '.join(ends) or 'none'}")
        Bound.model_validate(ends)
        return self

    @property
    def bound(self) -> Bound | None:
        """Returns the bound on the metric."""
        ends = {name: getattr(self, name) for name in ("below", "above", "within")}
        return None if self.metric is None else Bound.model_validate({k: v for k, v in ends.items() if v is not None})


class Keep(Model):
    """The runs whose signals are kept, in folders as a run of the scenario writes them."""

    runs: list[Annotated[int, Field(strict=True, ge=0, lt=10**9)]] = []
    """These, by their indices."""
    not_met: Annotated[int, Field(strict=True, ge=0, le=1000)] = 0
    """So many of the first that do not meet a requirement."""
    failed: Annotated[int, Field(strict=True, ge=0, le=1000)] = 0
    """So many of the first that failed."""


class Campaign(Extending):
    """A scenario flown again and again with values that vary, metrics of each run, and requirements on them."""

    name: Annotated[str, Field(strict=True, pattern=r"^\w[\w.-]*$", max_length=200)]
    """Its name, and that of the results' folder: letters, digits, `.`, `_` and `-`."""
    description: str = ""
    """What the campaign examines."""
    scenario: Annotated[str, Field(min_length=1)] | dict[str, Any]
    """The path of a scenario, relative to this file, or a scenario in place, such as
    `{extends: a.yaml, duration: 2 h}`."""
    swap: dict[str, Annotated[str, Field(strict=True, min_length=1)]] = {}
    """FMUs in the places of blocks, relative to this file: `{allocator: vendor.fmu}`."""
    map: dict[str, Annotated[str, Field(strict=True, min_length=1)]] = {}
    """Of blocks that are swapped, the mapping of their ports."""
    set: dict[str, Value] = {}
    """Start values in place of the scenario's, for all runs: `{plant.h_w0: 1 mN.m.s}`."""
    flavour: Flavour | None = None
    """Which build of the project's own blocks is run; default: the scenario's."""
    draw: dict[Variable, Varied] = {}
    """Values that are drawn for expressions and set nothing themselves."""
    vary: dict[str, Varied] = {}
    """Start values that vary, by name as `--set` takes them: `plant.h_w0`, `plant.x[2]`, or `J_B` for a shared one."""
    sampling: Literal["random", "latin hypercube", "sobol", "grid"] = "random"
    """How the values are drawn. Of `random`, run i depends on seed and i alone; `latin hypercube` and `sobol` make one
    design of
    all runs from the seed; `grid` crosses all that is given as `grid`, and draws the rest at random."""
    runs: int | None = Field(None, strict=True, ge=1, le=10**9)
    """How many runs there are; default: 1000, or with `grid` its number of points."""
    seed: int = Field(0, strict=True, ge=0)
    """What the values are drawn from."""
    stop: Literal["budget", "decided"] = "budget"
    """Whether all runs are flown, or the campaign ends as soon as every requirement is decided (with
    `sampling: random`)."""
    metrics: list[Metric] = []
    """What each run is measured by."""
    requirements: list[Requirement] = []
    """Requirements, which decide the exit status."""
    keep: Keep = Field(default_factory=Keep)
    sensitivity: Sensitivity | None = None
    """Which of the values that vary decide the metrics, by runs of a design of their own."""
    search: Search | None = None
    """A search for the run with the worst value of a metric."""

    @field_validator("metrics", "requirements")
    @classmethod
    def _names_once(cls, entries: list[Any]) -> list[Any]:
        names = [entry.name for entry in entries]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise ValueError(f"{twice!r} is given twice; expected a name for each")
        return entries

    @field_validator("vary")
    @classmethod
    def _set_once(cls, vary: dict[str, Varied]) -> dict[str, Varied]:
        for name in vary:
            whole = Name(name)
            if not whole.variable or any(ending == whole.variable for ending in ("shared.", ".")):
                raise ValueError(f"{name!r}: expected block.parameter, or parameter for a shared one")
        return vary

    @field_validator("stop")
    @classmethod
    def _at_random(cls, stop: str, info: ValidationInfo) -> str:
        if stop == "decided" and info.data.get("sampling", "random") != "random":
            raise ValueError(f"only runs drawn at random can end early, found sampling: {info.data['sampling']}")
        return stop

    @field_validator("search")
    @classmethod
    def _of_a_metric(cls, search: Search | None, info: ValidationInfo) -> Search | None:
        known = [metric.name for metric in info.data.get("metrics", ())]
        if search is not None and search.metric not in known:
            raise ValueError(f"metric: the campaign has no metric {search.metric!r}{hint(search.metric, known)}")
        return search

    @model_validator(mode="after")
    def _together(self) -> Campaign:
        if self.sampling == "grid" and not any(
            entry.kind == "grid" for entry in (*self.draw.values(), *self.vary.values())
        ):
            raise ValueError("sampling: a grid needs an entry under vary or draw that is given as 'grid'")
        if self.stop == "decided" and not self.requirements:
            raise ValueError("stop: there is no requirement that could be decided")
        if self.sensitivity is not None and not self.metrics:
            raise ValueError("sensitivity: there is no metric whose dependence could be told")
        if not self.metrics and not self.requirements:
            raise ValueError("expected metrics or requirements: without them nothing is known of a run")
        return self


def schema() -> str:
    """Returns the JSON Schema of campaign files; `docs/campaign.schema.json` is this text."""
    document = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Campaign.model_json_schema()}
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"
