"""What the master asks of a block, whatever stands behind it: an FMU in this process, one in its own, a mock."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from ..fmu.model import Element, Floats, Model


class Block(Protocol):
    """One instance. Every method raises BlockError, with time None, where the block refuses or fails.

    Calls come in this order: `set` of start values; `enter`; `get` and `set` in turn; `wire`; `leave`;
    `get_all`; then for each step `set_inputs`, `do_step` and one of `get_live` and `get_all`; `close`
    at the end, whatever happened. Between two steps `get` and `set` may come again, for what changes
    during the run. What goes wrong in `do_step` may be raised by the getter after it.
    """

    name: str
    model: Model

    @property
    def log(self) -> Sequence[str]:
        """The last lines that it has logged, for the message when it fails."""

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        """Sets variables by name; slow."""

    def get(self, elements: Sequence[Element]) -> list[float]:
        """Values of variables by name; slow."""

    def enter(self, stop: float) -> None:
        """Into initialization mode, for a run from 0 to `stop`."""

    def leave(self) -> None:
        """Out of initialization mode."""

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        """Fixes what `set_inputs` and the two getters exchange from now on.

        `inputs` and `outputs` are grouped by type in the order of TYPES; `into` has a place for each output.
        Within a type, the outputs that `get_live` fetches come first; `live[i]` counts those of TYPES[i].
        Returns the array from which `set_inputs` takes its values.
        """

    def set_inputs(self) -> None:
        """Hands over the values of the array that `wire` returned."""

    def do_step(self, time: float, step: float) -> None:
        """From `time` to `time + step`."""

    def get_live(self) -> None:
        """Fetches the outputs that others need in every step."""

    def get_all(self) -> None:
        """Fetches all outputs that are wired."""

    def close(self) -> None:
        """Ends the instance and frees what it holds; never raises."""


class Instance(Block, Protocol):
    """A block that is an FMU's instance, and that can serve several runs."""

    def reset(self) -> None:
        """Back to where it stood after it was instantiated; what `wire` fixed stays so.

        Raises BlockError where it cannot.
        """
