"""The sensors between the plant and its flight software. Python flavour, the reference."""

from .block import Inputs, Outputs, State, outputs, start, step
from .parameters import Parameters, check

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
