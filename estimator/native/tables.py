"""The C table of the onboard field models' Gauss coefficients, which the C of a block includes: gauss_models.h.
Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

from collections.abc import Iterable

from .. import tables


def generated() -> dict[str, str]:
    """C sources by file name."""
    guard = "GAUSS_MODELS_H"
    parts = [
        "/* Written by estimator/native/tables.py from the packages that estimator/tables names. */",
        f'#ifndef {guard}\n#define {guard}\n\n#include "onboard_field.h"\n',
    ]
    rows = []
    for name in tables.NAMES:
        model = tables.gauss_model(name)
        parts.append(f"static const double {name}_years[] = {_list(model.years)};")
        for letter, values, rate in (("g", model.g, model.g_rate), ("h", model.h, model.h_rate)):
            sets = ",\n".join(map(_list, values))
            parts.append(f"static const double {name}_{letter}[][ONBOARD_TERMS] = {{\n{sets}}};")
            parts.append(f"static const double {name}_{letter}_rate[] = {_list(rate)};")
        covered = f"a date that {name} covers, {model.years[0]:.1f} to {model.valid_until:.1f}"
        arrays = ", ".join(f"{name}_{part}" for part in ("g", "h", "g_rate", "h_rate"))
        rows.append(f'    {{{len(model.years)}, {name}_years, "{covered}", {model.valid_until!r}, {arrays}}}')
    parts.append("static const GaussModel gauss_models[] = {\n" + ",\n".join(rows) + "\n};\n\n#endif\n")
    return {"gauss_models.h": "\n".join(parts)}


def _list(values: Iterable[float]) -> str:
    return "{" + ", ".join(repr(float(value)) for value in values) + "}"
