"""The sensors between the plant and its flight software. Python flavour, the reference."""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
