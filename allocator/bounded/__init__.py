"""Allocation of a demanded torque to wheels and rods within their limits: bounded least squares with a
preference.

It stands where the paper's allocator stands and has its ports, and two optional ones for a feed-forward. "[n]" in a
docstring is an equation of Sanyal and Lee-Ho, AIAA 2009-5902; the method is not in the paper.
"""

from .block import Inputs, Outputs, State, outputs, start, step
from .parameters import Parameters, check

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
