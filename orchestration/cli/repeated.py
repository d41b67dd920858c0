"""What `orchestrate margins --orbit` prints: multipliers, or what is left of disturbances from period to period.

Tests: tests/orchestration/cli/test_margins.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..errors import InputError, Place, Problem
from ..margins.floquet import PULSE, Coordinates, Repeated
from ..margins.inject import Altered, Rig
from ..margins.periods import Followed, follow
from ..margins.search import Change, Slope, Starts, lost
from .console import complain, say, say_json
from .status import EXPECTATION_FAILED


def samples_of(rig: Rig, period: float, states: Sequence[str]) -> int:
    """Returns the samples of a period. Raises InputError."""
    samples = round(period / rig.period)
    if not states or samples < 2:
        expected = "--state BLOCK.PORT with --orbit" if not states else "a period of some samples"
        found = "none" if not states else f"{period:g} s"
        raise InputError(Problem(expected=expected, found=found, place=Place("--orbit")))
    return samples


def followed(
    rig: Rig,
    period: int,
    periods: int,
    piece: int,
    seen: Coordinates,
    names: Sequence[str],
    changes_: Sequence[Change],
    json_: bool,
) -> int:
    """Prints what is left of disturbances from period to period; the status is 1 where the loop is not linear."""

    def flown(altered: Altered, starts: Starts) -> Followed:
        return follow(rig, seen, period, periods, piece, altered, starts)

    def holds(altered: Altered, starts: Starts) -> bool:
        found = flown(altered, starts)
        return not found.refused and found.left < 1.0

    def log(starts: Starts) -> float:
        changed = follow(rig, seen, period, periods, piece, starts=starts, sizes=(found.size,))
        return math.log(changed.decay) if changed.repeats == found.repeats else math.nan

    found = flown(Altered(), None)
    slopes = {name: Slope.of(rig, name, math.log(found.decay), log) for name in names if not found.refused}
    searched = [lost(rig, one, holds) for one in changes_ if not found.refused]
    if json_:
        windows = [
            {"ratio": one.ratio, "most": one.most, "least": one.least, "error": one.error, "rest": one.rest}
            for one in found.windows
        ]
        said = {"period": period * rig.period, "windows": windows, "refused": found.refused or None}
        say_json({**said, **_slopes(slopes), "searched": [one.data() for one in searched]})
        return EXPECTATION_FAILED if found.refused else 0
    if found.refused:
        complain(f"no number: {found.refused}")
        return EXPECTATION_FAILED
    say(f"Answers to pulses over periods of {period * rig.period:g} s, of {', '.join(found.labels)}:", bold=True)
    what = "the largest multiplier" if found.repeats else "what is left after the last period"
    for line in [*found.lines(), *(slope.line(name, what) for name, slope in slopes.items()), *map(str, searched)]:
        say(line)
    return 0


def _slopes(slopes: Mapping[str, Slope]) -> dict[str, dict[str, float | None]]:
    """Returns sensitivities for JSON, and by how much they differ upwards and downwards."""
    parts = {"sensitivity": "value", "sensitivity_error": "apart"}
    of = {key: {name: getattr(slope, part) for name, slope in slopes.items()} for key, part in parts.items()}
    return {key: {name: None if math.isnan(v) else v for name, v in values.items()} for key, values in of.items()}


def multipliers(
    rig: Rig,
    samples: int,
    piece: int,
    seen: Coordinates,
    names: Sequence[str],
    changes_: Sequence[Change],
    json_: bool,
) -> int:
    """Prints the Floquet multipliers; the status is 1 where the state is not seen."""
    repeated = Repeated.of(rig, seen, samples, PULSE * rig.scales, piece)
    found = repeated.nominal
    slopes = {name: repeated.sensitivity(name) for name in names}
    searched = [lost(rig, one, repeated.decays) for one in changes_ if found.known]
    if json_:
        logs = [[log.real, log.imag] for log in found.logs]
        said = {"period": found.period, "logs": logs, "rest": found.rest, "spread": found.spread}
        say_json({**said, **_slopes(slopes), "searched": [one.data() for one in searched]})
    else:
        say(f"Floquet multipliers over {found.period:g} s, of {', '.join(found.labels)}:", bold=True)
        for line in found.lines():
            say(line)
        for name, slope in slopes.items():
            say(slope.line(name, "the largest multiplier"))
        for one in searched:
            say(str(one))
    return 0 if found.known else EXPECTATION_FAILED
