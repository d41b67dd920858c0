"""The supervisor: modes, targets and slews; it gives the controller its reference. Python flavour, the reference."""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
