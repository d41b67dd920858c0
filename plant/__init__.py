"""The plant: rigid satellite, wheel and rods on an orbit in the geomagnetic field. Python flavour, the reference."""

from .block import Inputs, Outputs, State, outputs, start, step
from .checks import check
from .parameters import Parameters

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
