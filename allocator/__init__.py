"""Allocation of a demanded torque to a wheel and three rods: Sanyal and Lee-Ho, AIAA 2009-5902, section IV.

"[n]" in a docstring is the paper's equation number.
"""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
