"""Small real FMUs for tests: a motor and a regulator, both on probe.c, and spoilt copies of them."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import zipfile
from functools import lru_cache
from pathlib import Path

import fmpy

_UNITS = """
  <UnitDefinitions>
    <Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>
    <Unit name="mV"><BaseUnit kg="1" m="2" s="-3" A="-1" factor="0.001"/></Unit>
    <Unit name="rad/s"><BaseUnit s="-1" rad="1"/><DisplayUnit name="rpm" factor="9.549296585513721"/></Unit>
    <Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit>
    <Unit name="kg.m2"><BaseUnit kg="1" m="2"/></Unit>
    <Unit name="s"><BaseUnit s="1"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Mode"><Enumeration>
      <Item name="normal" value="1"/><Item name="brake" value="2"/></Enumeration></SimpleType>
  </TypeDefinitions>"""

_FAULTS = """
    <ScalarVariable name="fault" valueReference="0" causality="parameter" variability="fixed">
      <Integer start="0"/></ScalarVariable>
    <ScalarVariable name="fault_time" valueReference="0" causality="parameter" variability="fixed">
      <Real unit="s" start="0"/></ScalarVariable>"""

_MOTOR = f"""{_FAULTS}
    <ScalarVariable name="voltage" valueReference="2" causality="input"><Real unit="V" start="0"/></ScalarVariable>
    <ScalarVariable name="speed" valueReference="4" causality="output"><Real unit="rad/s"/></ScalarVariable>
    <ScalarVariable name="steps" valueReference="1" causality="output" variability="discrete">
      <Integer/></ScalarVariable>
    <ScalarVariable name="inertia" valueReference="10" causality="parameter" variability="fixed">
      <Real unit="kg.m2" start="1" min="0.001" max="10"/></ScalarVariable>
    <ScalarVariable name="axis[1]" valueReference="11" causality="parameter" variability="fixed">
      <Real start="1"/></ScalarVariable>
    <ScalarVariable name="axis[2]" valueReference="12" causality="parameter" variability="fixed">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="axis[3]" valueReference="13" causality="parameter" variability="fixed">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="2" causality="parameter" variability="fixed">
      <Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="poles" valueReference="3" causality="parameter" variability="fixed">
      <Integer start="2" min="2" max="32"/></ScalarVariable>
    <ScalarVariable name="cooled" valueReference="0" causality="parameter" variability="fixed">
      <Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="label" valueReference="0" causality="parameter" variability="fixed">
      <String start=""/></ScalarVariable>
    <ScalarVariable name="hot" valueReference="1" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="speed0" valueReference="4" causality="parameter" variability="fixed">
      <Real unit="rad/s" start="1"/></ScalarVariable>"""
_MOTOR_OUTPUTS = (
    '<Unknown index="4" dependencies=""/><Unknown index="5" dependencies=""/><Unknown index="14" dependencies=""/>'
)

_REGULATOR = f"""{_FAULTS}
    <ScalarVariable name="speed" valueReference="2" causality="input"><Real unit="rad/s" start="0"/></ScalarVariable>
    <ScalarVariable name="enabled" valueReference="5" causality="input" variability="discrete">
      <Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="voltage" valueReference="1" causality="output"><Real unit="V"/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="3" causality="parameter" variability="tunable">
      <Real start="-1"/></ScalarVariable>
    <ScalarVariable name="samples[1]" valueReference="20" causality="output"><Real unit="V"/></ScalarVariable>
    <ScalarVariable name="samples[2]" valueReference="21" causality="output"><Real unit="V"/></ScalarVariable>"""
_REGULATOR_OUTPUTS = (
    '<Unknown index="5" dependencies="3"/><Unknown index="7" dependencies=""/><Unknown index="8" dependencies=""/>'
)

VARIABLES = {"motor": (_MOTOR, _MOTOR_OUTPUTS), "regulator": (_REGULATOR, _REGULATOR_OUTPUTS)}


def description(name: str, version: str = "2.0", guid: str = "probe", kind: str = "CoSimulation") -> str:
    """The modelDescription.xml of "motor" or "regulator"."""
    variables, outputs = VARIABLES[name]
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{version}" modelName="{name}" guid="{guid}" variableNamingConvention="structured">
  <{kind} modelIdentifier="probe"/>{_UNITS}
  <ModelVariables>{variables}
  </ModelVariables>
  <ModelStructure>
    <Outputs>{outputs}</Outputs>
    <InitialUnknowns>{outputs}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


@lru_cache(maxsize=8)
def library(name: str = "probe", *options: str) -> bytes:
    """probe.c, or another source beside this file, compiled for this platform."""
    system = shutil.which("cc") or shutil.which("gcc")
    compiler = [system] if system else [sys.executable, "-m", "ziglang", "cc"]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / f"{name}{fmpy.sharedLibraryExtension}"
        source = Path(__file__).with_name(f"{name}.c")
        subprocess.run(
            [*compiler, "-shared", "-fPIC", "-O1", *options, "-o", str(out), str(source)],
            check=True,
            capture_output=True,
        )
        return out.read_bytes()


def write(path: Path, xml: str, binary: bytes | None = None, folder: str = fmpy.platform, stem: str = "probe") -> Path:
    """An FMU of this description; without a binary it can be checked but not loaded."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", xml)
        suffix = {"win64": ".dll", "darwin64": ".dylib", "linux64": ".so"}[folder]
        archive.writestr(f"binaries/{folder}/{stem}{suffix}", b"no library" if binary is None else binary)
    return path


def write_pair(folder: Path, runnable: bool = True) -> None:
    """motor.fmu and regulator.fmu."""
    for name in VARIABLES:
        write(folder / f"{name}.fmu", description(name), library() if runnable else None)
