"""What an FMU declares of its use for co-simulation, from what FMPy read of its modelDescription.xml."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..errors import InputError, Problem
from .platforms import PLATFORM, PLATFORM_3, PLATFORMS_2, SUFFIX


@dataclass(frozen=True)
class CoSimulation:
    """Name of its library, what it needs and how it can be stepped."""

    version: int
    """FMI's major version."""
    identifier: str
    needs_tool: bool
    """Whether it needs the tool that made it (needsExecutionTool)."""
    variable_step: bool
    """canHandleVariableCommunicationStepSize."""
    inside: str | None
    """fixedInternalStepSize, s, of FMI 3.0: it divides each step into steps of this length."""
    step: str | None
    """DefaultExperiment.stepSize, s."""
    alone: bool = False
    """canBeInstantiatedOnlyOncePerProcess."""
    platform: str = PLATFORM
    """What it calls this platform: linux64 in FMI 2.0, x86_64-linux in 3.0."""

    @classmethod
    def of(cls, description: Any, platforms: Collection[str] = ()) -> CoSimulation:
        """`platforms` are those for which it has libraries."""
        two = next((name for name in PLATFORMS_2 if name in platforms), PLATFORM)
        flags, experiment = description.coSimulation, description.defaultExperiment
        return cls(
            description.fmiMajorVersion,
            flags.modelIdentifier,
            bool(flags.needsExecutionTool),
            bool(flags.canHandleVariableCommunicationStepSize),
            flags.fixedInternalStepSize,
            experiment.stepSize if experiment is not None else None,
            bool(flags.canBeInstantiatedOnlyOncePerProcess),
            two if description.fmiMajorVersion == 2 else PLATFORM_3,
        )

    @property
    def library(self) -> str:
        """Path in the FMU of the library for this platform."""
        return f"binaries/{self.platform}/{self.identifier}{SUFFIX}"

    @property
    def steps_inside(self) -> bool:
        """Returns whether it divides each step into steps of a fixed length, of which it has to be a multiple."""
        return self.inside is not None

    def sample_time(self) -> Fraction | None:
        """The step that it insists on, or into which it divides all steps, s; None where it has none or does not say.

        Raises InputError.
        """
        name, step = "stepSize", self.step
        if self.steps_inside:
            name, step = "fixedInternalStepSize", self.inside
        elif self.variable_step:
            return None
        if step is None:
            return None
        number = float(step)
        if not 0.0 < number < math.inf:
            where = name if name != "stepSize" else "DefaultExperiment.stepSize"
            text = f"its FMU cannot vary its step, and its {name} is {step}, expected a finite number above 0"
            raise InputError(Problem(text, remedy=f"declare {where} in the FMU"))
        return Fraction(repr(number))
