"""The format of a value that varies in a campaign file: these models are part of its schema."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError, WithJsonSchema, model_validator

from ...scenario.types import NUMBER_OR_TEXT, Model, Quantity, Value, quantity

_LISTED = {"anyOf": [*NUMBER_OR_TEXT, {"type": "array", "items": {"anyOf": NUMBER_OR_TEXT}}]}


def _quantities(value: Any) -> Any:
    for item in value if isinstance(value, list) else [value]:
        quantity(item)
    return value


Quantities = Annotated[Any, BeforeValidator(_quantities), WithJsonSchema(_LISTED)]
"""A quantity, or a list of them for a vector."""
Share = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class Normal(Model):
    """A normal distribution, of one number or of a vector; truncated where `low` or `high` is given."""

    mean: Quantities
    deviation: Quantities | None = None
    """The standard deviation, of each element for itself."""
    covariance: list[list[float]] | None = None
    """The covariance matrix of a vector's elements, in the unit of `mean` squared."""
    low: Quantity | None = None
    """No value below this one."""
    high: Quantity | None = None
    """No value above this one."""

    @model_validator(mode="after")
    def _one(self) -> Normal:
        if (self.deviation is None) == (self.covariance is None):
            raise ValueError("expected exactly one of deviation and covariance")
        if self.covariance is not None:
            if not isinstance(self.mean, list):
                raise ValueError("a covariance is of a vector; expected a list as mean, or a deviation")
            if self.low is not None or self.high is not None:
                raise ValueError("correlated values cannot be truncated; expected no low and no high")
        return self


class LogNormal(Model):
    """A log-normal distribution: its logarithm is normal."""

    median: Quantities
    sigma: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    """The standard deviation of the natural logarithm."""


class Steps(Model):
    """Points at equal distances, the ends included."""

    start: Quantity = Field(alias="from")
    to: Quantity
    points: int = Field(strict=True, ge=2, le=1_000_000)


def _steps(value: Any) -> Any:
    """Returns points that are given by their ends, so that of `grid` only what was meant is reported."""
    return _inner(Steps, value)


def _inner(model: type[Model], value: Any) -> Any:
    """Returns the part as this model where it is written as one.

    Raises ValueError, in which the names of models have no place.
    """
    if not isinstance(value, dict):
        return value
    try:
        return model.model_validate(value)
    except ValidationError as error:
        problems = []
        for detail in error.errors(include_url=False):
            text = str(detail.get("ctx", {}).get("error") or detail["msg"][:1].lower() + detail["msg"][1:])
            ending = "" if detail["type"] in ("missing", "value_error") else f", found {detail['input']}"
            problems.append(": ".join([*map(str, detail["loc"][:1]), f"{text}{ending}"]))
        raise ValueError("; ".join(problems)) from None


class Varied(Model):
    """A value that varies from run to run. Exactly one of these, `weights` beside `choice`."""

    uniform: Annotated[list[Quantities], Field(min_length=2, max_length=2)] | None = None
    """`[low, high]`; for a vector, lists of the ends of its elements."""
    normal: Normal | None = None
    """`{mean: 0, deviation: 1}`, with `low` and `high` truncated, with `covariance` correlated."""
    lognormal: LogNormal | None = None
    """`{median: 1, sigma: 0.1}`."""
    integers: (
        Annotated[list[Annotated[int, Field(strict=True, ge=-(2**31), lt=2**31)]], Field(min_length=2, max_length=2)]
        | None
    ) = None
    """`[low, high]`: a whole number, both ends included, such as a seed."""
    choice: Annotated[list[Value], Field(min_length=1)] | None = None
    """One of these, all alike or by `weights`."""
    weights: list[Share] | None = None
    """Of `choice`: how often each is taken, relative to the others."""
    grid: Annotated[Annotated[list[Value], Field(min_length=1)] | Steps | None, BeforeValidator(_steps)] = None
    """All of these in turn, with `sampling: grid`: a list, or `{from: 0 deg, to: 90 deg, points: 10}`."""
    rotation: Literal["uniform"] | None = None
    """A rotation matrix, or a unit quaternion, uniform over all attitudes."""
    sphere: Annotated[Any, WithJsonSchema({"anyOf": [*NUMBER_OR_TEXT, {"type": "object"}]})] = None
    """A vector of this length in any direction, all alike; the length is a quantity or varies itself."""
    expression: Annotated[str, Field(strict=True, min_length=1)] | None = None
    """A value computed of others that vary, in base units: `diag(J + error)`."""

    @model_validator(mode="before")
    @classmethod
    def _length(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("sphere"), dict):
            data = {**data, "sphere": _inner(Varied, data["sphere"])}
        return data

    @model_validator(mode="after")
    def _one(self) -> Varied:
        given = [name for name in KINDS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"expected exactly one of {', '.join(KINDS)}; found {' and '.join(given) or 'none'}")
        if self.weights is not None:
            if self.choice is None or len(self.weights) != len(self.choice):
                raise ValueError("weights are of a choice, one for each of its values")
            if not sum(self.weights) > 0.0:
                raise ValueError("expected weights of which one at least is above 0")
        if self.sphere is not None and not isinstance(self.sphere, Varied):
            quantity(self.sphere)
        elif self.sphere is not None and self.sphere.kind not in ("uniform", "normal", "lognormal", "choice", "grid"):
            raise ValueError(f"sphere: the length cannot be {self.sphere.kind}; expected one number that varies")
        return self

    @property
    def kind(self) -> str:
        """Returns which of the distributions it is."""
        return next(name for name in KINDS if getattr(self, name) is not None)


KINDS = ("uniform", "normal", "lognormal", "integers", "choice", "grid", "rotation", "sphere", "expression")
