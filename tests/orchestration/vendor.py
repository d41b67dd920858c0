"""An FMU of another team for tests: the regulator of `fmus` with other names, units and a gain to match.

Theirs: voltage_mV = kp * speed_rpm on the probe's arithmetic, so kp = 1000 pi/30 gain gives what ours gives.
"""

from __future__ import annotations

import math
from pathlib import Path

from . import fmus

GAIN = 1000 * math.pi / 30
MAPPING = f"""\
ports:
  speed: rate
  voltage: command
  gain: {{theirs: kp, scale: {GAIN!r}}}
"""


def description(*changes: tuple[str, str], own_names: bool = True) -> str:
    """The modelDescription.xml of their regulator, with text replaced."""
    xml = fmus.description("regulator")
    if own_names:
        for old, new in (
            (
                'name="speed" valueReference="2" causality="input"><Real unit="rad/s"',
                'name="rate" valueReference="2" causality="input"><Real unit="rpm"',
            ),
            (
                'name="voltage" valueReference="1" causality="output"><Real unit="V"',
                'name="command" valueReference="1" causality="output"><Real unit="mV"',
            ),
            ('name="gain"', 'name="kp"'),
            ('<Real start="-1"/>', f'<Real start="{-GAIN!r}"/>'),
        ):
            assert old in xml, old
            xml = xml.replace(old, new)
    for old, new in changes:
        assert old in xml, old
        xml = xml.replace(old, new, 1)
    return xml


def write(folder: Path, *changes: tuple[str, str], runnable: bool = False, own_names: bool = True) -> Path:
    """vendor.fmu, and mapping.yaml beside it."""
    (folder / "mapping.yaml").write_text(MAPPING, "utf-8")
    xml = description(*changes, own_names=own_names)
    return fmus.write(folder / "vendor.fmu", xml, fmus.library() if runnable else b"")
