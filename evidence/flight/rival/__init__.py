"""A controller from the literature: non-monotonic detumbling, then a proportional-derivative law."""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
