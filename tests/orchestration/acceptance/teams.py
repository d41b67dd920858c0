"""FMUs of other teams for tests: our controller or allocator behind ports that are read in another way.

Each is this project's C with a conversion before and behind it, under an interface that does not tell of the
conversion.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import fmpy

from fmus.interface import load, parse
from fmus.kit import generated
from fmus.native import COMMON, SHELL
from fmus.native.guard import headers

from ..fmus import write

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Team:
    """One team's FMU: which block it stands for, how its interface differs from ours, and its conversions in C."""

    block: str
    inputs: str
    """C that makes `in`, our inputs, of `u`, theirs, which is a copy of the same fields where they are the same."""
    outputs: str = ""
    """C that changes `y`, our outputs."""
    interface: tuple[tuple[str, str], ...] = ()
    """Regular expressions and what takes their place in our interface."""
    behaves: dict[str, str] = field(default_factory=dict)
    """The wrong wirings that are to be found."""
    rewritten: tuple[str, ...] = ()
    """Inputs that theirs has under another shape, and so are not copied."""


_QUATERNION = """\
const double x = u->att[0], y_ = u->att[1], z = u->att[2], w = {sign}u->att[3];
const double R[3][3] = {{{{1 - 2 * (y_ * y_ + z * z), 2 * (x * y_ - w * z), 2 * (x * z + w * y_)}},
 {{2 * (x * y_ + w * z), 1 - 2 * (x * x + z * z), 2 * (y_ * z - w * x)}},
 {{2 * (x * z - w * y_), 2 * (y_ * z + w * x), 1 - 2 * (x * x + y_ * y_)}}}};
memcpy(in.R_NB, R, sizeof R);"""
_ATTITUDE = (
    (
        r"\[variables\.R_NB\]\n(?:.*\n)*?\n",
        '[variables.att]\ncausality = "input"\nshape = [4]\ndescription = "Attitude quaternion"\n'
        "start = [0.0, 0.0, 0.0, 1.0]\n\n",
    ),
    (r'"R_NB\[:,i\]"', '"att"'),
    (r'"R_NB"', '"att"'),
)
TEAMS = {
    "signs": Team(
        "allocator",
        "in.h_w = -u->h_w;",
        "y->wheel_torque_cmd = -y->wheel_torque_cmd; y->dipole_cmd[1] = -y->dipole_cmd[1];",
        behaves={"h_w": "opposite sign", "dipole_cmd": "+x -y +z", "wheel_torque_cmd": "opposite sign"},
    ),
    "axes": Team(  # their x, y, z are our y, z, x
        "controller",
        "for (int i = 0; i < 3; ++i) { for (int j = 0; j < 3; ++j) { in.R_NB[i][(j + 1) % 3] = u->R_NB[i][j]; }\n"
        " in.omega_B[(i + 1) % 3] = u->omega_B[i]; }",
        "const double t[3] = {y->tau_cmd_B[0], y->tau_cmd_B[1], y->tau_cmd_B[2]};\n"
        "const double w[3] = {y->rate_error_B[0], y->rate_error_B[1], y->rate_error_B[2]};\n"
        "for (int i = 0; i < 3; ++i) { y->tau_cmd_B[i] = t[(i + 1) % 3]; y->rate_error_B[i] = w[(i + 1) % 3]; }",
        behaves={
            "R_NB": "columns +z +x +y",
            "omega_B": "+z +x +y",
            "tau_cmd_B": "+y +z +x",
            "rate_error_B": "+y +z +x",
        },
    ),
    "units": Team(  # nT, mN m, deg/s and mA m2, of which the description says nothing
        "allocator",
        "for (int i = 0; i < 3; ++i) { in.tau_cmd_B[i] = 1e-3 * u->tau_cmd_B[i]; in.b_B[i] = 1e-9 * u->b_B[i];\n"
        " in.omega_B[i] = 0.017453292519943295 * u->omega_B[i]; }",
        "for (int i = 0; i < 3; ++i) { y->dipole_cmd[i] *= 1e3; y->tau_residual_B[i] *= 1e3; }",
        (
            (r"(\[variables\.(tau_cmd_B|b_B|omega_B|dipole_cmd|tau_residual_B)\]\n(?:.*\n)*?)unit = .*\n", r"\1"),
            (r"(\[variables\.(tau_cmd_B|b_B|omega_B|tau_residual_B)\]\n(?:.*\n)*?)display_unit = .*\n", r"\1"),
            (r"start = \[2e-5, 1e-5, -3e-5\]", "start = [20000.0, 10000.0, -30000.0]"),
        ),
        behaves={
            "tau_cmd_B": "read in mN.m",
            "b_B": "read in nT",
            "omega_B": "read in deg/s",
            "dipole_cmd": "given in mA.m2",
        },
    ),
    "transposed": Team(
        "controller",
        "for (int i = 0; i < 3; ++i) { for (int j = 0; j < 3; ++j) { in.R_NB[i][j] = u->R_NB[j][i]; } }",
        behaves={"R_NB": "transposed"},
    ),
    "quaternion": Team(  # scalar last, of which the description says nothing
        "controller",
        _QUATERNION.format(sign=""),
        interface=_ATTITUDE,
        behaves={"R_NB": "quaternion, scalar first as last"},
        rewritten=("R_NB",),
    ),
    "inverse": Team(  # the same, of the rotation from N to B
        "controller",
        _QUATERNION.format(sign="-"),
        interface=_ATTITUDE,
        behaves={"R_NB": "quaternion, scalar first as last, inverse"},
        rewritten=("R_NB",),
    ),
    "other law": Team(  # a rate of the opposite sign, and a gain that grows with the torque, which no cause explains
        "controller",
        "for (int i = 0; i < 3; ++i) { in.omega_B[i] = -u->omega_B[i]; }",
        "const double *t = y->tau_cmd_B, size = t[0] * t[0] + t[1] * t[1] + t[2] * t[2];\n"
        "const double gain = 0.5 + 3e7 * size;\n"
        "for (int i = 0; i < 3; ++i) { y->tau_cmd_B[i] *= gain; }",
    ),
    "waits": Team("allocator", "static int calls; if (++calls > 60) { for (;;) { } }"),
    "leaves": Team("allocator", "static int calls; if (++calls > 60) { _Exit(0); }"),
}


def build(name: str, folder: Path) -> Path:
    """The FMU of a team, in a folder."""
    team = TEAMS[name]
    ours = load(team.block)
    text = re.sub(r'(?m)^name = ".*"$', 'name = "team"', ours.source, count=1)
    text = re.sub(r"(?m)^flavours *=.*\n", "", text)
    for pattern, new in team.interface:
        text, count = re.subn(pattern, new, text)
        assert count, pattern
    interface = parse(text, "team.toml")
    work = folder / f"{name}-sources"
    work.mkdir(parents=True)
    for file, content in (generated(interface) | headers(ours)).items():
        (work / file).write_text(content, "utf-8")
    copied = [v.name for v in ours.of("input") if v.name not in team.rewritten]
    (work / "team.h").write_text(_header(team.block), "utf-8")
    (work / "team.c").write_text(_source(team, copied), "utf-8")
    native = ROOT / team.block / "native"
    sources = [work / "team.c", work / "table.c", *SHELL.glob("*.c"), *native.glob("*.c")]
    library = work / f"team{fmpy.sharedLibraryExtension}"
    system = shutil.which("cc") or shutil.which("gcc")
    compiler = [system] if system else [sys.executable, "-m", "ziglang", "cc"]
    flags = [
        "-shared",
        "-fPIC",
        "-O0",
        "-w",
        "-std=c11",
        "-fvisibility=hidden",
        f"-I{work}",
        f"-I{SHELL}",
        f"-I{COMMON}",
    ]
    subprocess.run([*compiler, *flags, *map(str, sources), "-o", str(library), "-lm"], check=True)
    description = (work / "modelDescription.xml").read_text("utf-8")
    return write(folder / f"{name}.fmu", description, library.read_bytes(), stem="team")


def _header(block: str) -> str:
    Block = block.capitalize()
    lines = ['#include "team_ports.h"', f'#include "{(ROOT / block / "native" / f"{block}.h").as_posix()}"']
    lines += [f"typedef {Block}State TeamState;", f"typedef {Block}Law TeamLaw;"]
    lines += [
        "bool team_check(const TeamParameters *p, Fault *f);",
        "void team_prepare(const TeamParameters *p, TeamLaw *law);",
        "bool team_start(const TeamLaw *law, const TeamInputs *u, TeamState *x, Fault *f);",
        "bool team_outputs(const TeamLaw *law, const TeamState *x, const TeamInputs *u, TeamOutputs *y, Fault *f);",
        "bool team_step(const TeamLaw *law, TeamState *x, const TeamInputs *u, double h, TeamOutputs *y, Fault *f);",
    ]
    return "\n".join(["#ifndef TEAM_H", "#define TEAM_H", '#include "fault.h"', *lines, "#endif", ""])


def _source(team: Team, copied: list[str]) -> str:
    block, Block = team.block, team.block.capitalize()
    copies = "\n".join(f"memcpy(&in.{name}, &u->{name}, sizeof in.{name});" for name in copied)
    return f"""
#include "team.h"
#include <stdlib.h>
#include <string.h>
static {Block}Inputs read_inputs(const TeamInputs *u)
{{
    {Block}Inputs in;
    {copies}
    {team.inputs}
    return in;
}}
static bool give(bool ok, const {Block}Outputs *ours, TeamOutputs *y)
{{
    memcpy(y, ours, sizeof *y);
    {team.outputs}
    return ok;
}}
bool team_check(const TeamParameters *p, Fault *f) {{ return {block}_check((const {Block}Parameters *)p, f); }}
void team_prepare(const TeamParameters *p, TeamLaw *law) {{ {block}_prepare((const {Block}Parameters *)p, law); }}
bool team_start(const TeamLaw *law, const TeamInputs *u, TeamState *x, Fault *f)
{{
    const {Block}Inputs in = read_inputs(u);
    return {block}_start(law, &in, x, f);
}}
bool team_outputs(const TeamLaw *law, const TeamState *x, const TeamInputs *u, TeamOutputs *y, Fault *f)
{{
    const {Block}Inputs in = read_inputs(u);
    {Block}Outputs out;
    memset(&out, 0, sizeof out);
    return give({block}_outputs(law, x, &in, &out, f), &out, y);
}}
bool team_step(const TeamLaw *law, TeamState *x, const TeamInputs *u, double h, TeamOutputs *y, Fault *f)
{{
    const {Block}Inputs in = read_inputs(u);
    {Block}Outputs out;
    memset(&out, 0, sizeof out);
    return give({block}_step(law, x, &in, h, &out, f), &out, y);
}}
"""
