"""The judge: errors of attitude and rate from the plant's truth. Python flavour, the reference."""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
