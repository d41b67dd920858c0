"""The flight code with `float` in the place of `double`: a translation of the C as it stands, made at the build.

Every type, constant and elementary function is single precision. What is read once, from text, keeps double precision:
the date of the parameter `epoch` (APART); days that estimator and planners make of it do not.

Tests: tests/evidence/single/test_single.py.
"""

from __future__ import annotations

import re
from pathlib import Path

from fmus.block import Block, natives
from fmus.native import COMMON, generated_sources
from fmus.native.toolchain import FREESTANDING

APART = ("epoch.h",)
"""Files that are not translated: days since 2000 have no second left in 24 bits."""
LEAST, MOST = 1.17549435e-38, 3.40282346e38
_TOKEN = re.compile(
    r'"(?:\\.|[^"\\])*"|/\*.*?\*/|//[^\n]*'
    r"|\bdouble\b|\bDBL_(?=[A-Z])"
    r"|(?<![\w.])(?:\d+\.\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+|0[xX][\da-fA-F.]+[pP][+-]?\d+)(?![\w.])",
    re.DOTALL,
)
_ELEMENTARY = {
    "6755399441055744.0": "12582912.0",  # 1.5 * 2^23
    "* 2^52": "* 2^23",
    # pi/2 and ln 2 in parts whose products with small integers are exact: fdlibm's for single precision (Sun, 1993).
    "1.57079632673412561417e+00": "1.5703125",
    "6.07710050630396597660e-11": "4.837512969970703125e-4",
    "2.02226624879595063154e-21": "7.549789948768648e-8",
    "3.14159265358979311600, pi_rest = 1.22464679914735317720e-16": "3.14159274, pi_rest = -8.74227766e-8",
    "6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10": "0.693138123, ln2_low = 9.05800061e-6",
    "2.2250738585072014e-308": "1.17549435e-38",
    "x > 709.782712893384 || x < -708.39": "x > 88.72283 || x < -87.33",
    "x > 709.782712893384 || x < -40.0": "x > 88.72283 || x < -18.0",
    "uint64_t bits": "uint32_t bits",
    "(uint64_t)(1023 + k) << 52": "(uint32_t)(127 + k) << 23",
    "(int)(bits >> 52) - 1023": "(int)(bits >> 23) - 127",
}
"""Of elementary.c and math.h: where they know how a number is made up."""


def translated(text: str) -> str:
    """C text with float numbers; texts and comments stay."""
    return _TOKEN.sub(lambda found: _token(found[0]), text)


def _token(token: str) -> str:
    if token[0] in '"/':
        return token
    if token in ("double", "DBL_"):
        return {"double": "float", "DBL_": "FLT_"}[token]
    value = float.fromhex(token) if token[:2] in ("0x", "0X") else float(token)
    if value != 0.0 and value < LEAST:
        return f"{LEAST!r}f"  # what keeps a quotient from nothing has to be something
    return f"{MOST!r}f" if value > MOST else f"{token}f"


def write(block: Block, folder: Path) -> tuple[list[Path], list[Path]]:
    """Writes the block's C, translated, with its headers and the elementary functions. Returns sources and folders of
    headers."""
    folders = []
    for number, origin in enumerate((*natives(block.folder), COMMON, FREESTANDING)):
        into = folder / f"{number}_{origin.parent.name}"
        for path in sorted(origin.rglob("*.[ch]")):
            if path.name != "memory.c":
                _put(into / path.relative_to(origin), path.read_text("utf-8"), origin == FREESTANDING)
        folders.append(into)
    for name, text in generated_sources(block.interface, block.folder).items():
        _put(folder / "generated" / name, text)
    folders.insert(0, folder / "generated")
    return [path for origin in folders for path in sorted(origin.rglob("*.c"))], folders


def _put(path: Path, text: str, elementary: bool = False) -> None:
    if elementary:
        for before, after in _ELEMENTARY.items():
            text = text.replace(before, after)
        text = re.sub(r"__builtin_(sqrt|fabs|copysign|inf|nan)\b", r"__builtin_\1f", text).replace(
            "portable_", "single_"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text if path.name in APART else translated(text), "utf-8")
