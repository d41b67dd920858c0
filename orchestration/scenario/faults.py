"""The faults that a scenario injects."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from .references import Assignment, Reference
from .types import Model, Time, Value


class Fault(Model):
    """A fault from some time on. Exactly one of `set`, `freeze`, `bias` and `cut`.

    All but `set` change what the receivers of a signal are given: all of them where the signal is an output, one of
    them where it is an input. The block that gives the signal, and what is recorded of it, stay as they are.
    """

    at: Time
    """When it begins."""
    until: Time | None = None
    """When it ends; default: never."""
    set: Assignment | None = None
    """`plant.friction = 0.1`: a tunable parameter, or an input that is not connected."""
    freeze: Reference | None = None
    """A signal that stays at the value that it has at this time."""
    bias: Reference | None = None
    """A signal to which `by` is added."""
    by: Value = None
    """What `bias` adds."""
    cut: Reference | None = None
    """A signal that is lost: its receivers are given `to`."""
    to: Value = None
    """What is given instead of a signal that is cut; default: zero, or false."""

    @model_validator(mode="after")
    def _one(self) -> Fault:
        self._only("set", "freeze", "bias", "cut")
        if (self.by is None) == (self.bias is not None):
            raise ValueError("'by' says what 'bias' adds; expected both or neither")
        if self.to is not None and self.cut is None:
            raise ValueError("'to' says what is given instead of a signal that is cut; found no 'cut'")
        if self.at < 0.0:
            raise ValueError(f"at: expected zero or more, found {self.at:g} s")
        if self.until is not None and self.until <= self.at:
            raise ValueError(f"until: expected a time after {self.at:g} s, found {self.until:g} s")
        return self

    @property
    def kind(self) -> str:
        return self._only("set", "freeze", "bias", "cut")

    @property
    def target(self) -> Reference:
        """The parameter or signal to which it happens."""
        if self.set is not None:
            return self.set.target
        return next(signal for signal in (self.freeze, self.bias, self.cut) if signal is not None)


def sentence(fault: Fault, unit: str = "") -> str:
    """Returns what goes wrong and when, in words; `unit` is that of its numbers."""
    unit = f" {unit}" if unit else ""
    what = {
        "set": f"{fault.set}{unit}",
        "freeze": f"{fault.freeze} frozen",
        "bias": f"{fault.bias} biased by {_shown(fault.by)}{unit}",
        "cut": f"{fault.cut} cut" + ("" if fault.to is None else f", {_shown(fault.to)}{unit} instead"),
    }[fault.kind]
    end = "on" if fault.until is None else f"to {fault.until:.10g} s"
    return f"{what}, from {fault.at:.10g} s {end}"


def _shown(value: Any) -> str:
    return f"[{', '.join(map(_shown, value))}]" if isinstance(value, (list, tuple)) else str(value)
