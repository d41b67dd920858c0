"""Attitude tracking on SO(3): the law of Sanyal and Lee-Ho, AIAA 2009-5902.

"[n]" in a docstring is the paper's equation number.
"""

from .block import Inputs, Outputs, Parameters, State, outputs, start, step
from .checks import check

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
