"""The estimator between sensors and controller. Python flavour, the reference."""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
