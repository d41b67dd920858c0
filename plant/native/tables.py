"""C tables of the numbers from outside: field models and density terms, from `plant.tables` at build time.
Tests: tests/plant/test_field.py."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .. import tables
from ..geomagnetic import FieldModel
from ..tables import field_models

_HEADER = "/* Written by plant/native/tables.py from the packages and files that plant/tables names. */\n"


def generated() -> dict[str, str]:
    """C sources by file name."""
    return {"field_models.c": _field_models(), "density_terms.c": _density_terms()}


def _field_models() -> str:
    parts = [_HEADER, '#include "geomagnetic.h"\n']
    rows = []
    for name in field_models.NAMES:
        model = tables.field_model(name)
        parts.append(f"static const double {name}_years[] = {_list(model.epochs)};")
        for key in ("g", "h"):
            sets = ",\n".join(_list(_terms(values)) for values in getattr(model, key))
            parts.append(f"static const double {name}_{key}[][FIELD_TERMS] = {{\n{sets}}};")
            parts.append(f"static const double {name}_{key}_rate[] = {_list(_terms(getattr(model, key + '_dot')))};")
        rows.append(_model(name, model))
    parts.append("const FieldModel plant_field_models[] = {\n" + ",\n".join(rows) + "\n};\n")
    return "\n".join(parts)


def _model(name: str, model: FieldModel) -> str:
    arrays = ", ".join(f"{name}_{part}" for part in ("g", "h", "g_rate", "h_rate"))
    covered = f"a date that {name} covers, {model.epochs[0]:.1f} to {model.valid_until:.1f}, or field_extrapolate"
    return f'    {{{len(model.epochs)}, {name}_years, {model.valid_until!r}, "{covered}", {arrays}}}'


def _terms(square: np.ndarray) -> list[float]:
    """n = 1 to 13, m = 0 to n."""
    return [float(square[n, m]) for n in range(1, 14) for m in range(n + 1)]


def _density_terms() -> str:
    model = tables.density_model()
    rows = ",\n".join(
        f"    {{{', '.join(str(int(i)) for i in place)}, {_list(values)}}}"
        for place, values in zip(model.terms, model.coefficients, strict=True)
    )
    shape = ", ".join(_list(row) for row in model.ap_shape)
    return (
        f'{_HEADER}#include "atmosphere.h"\n\nconst int plant_density_term_count = {len(model.terms)};\n'
        f"const double plant_density_ap_shape[2][QUANTITIES] = {{{shape}}};\n"
        f"const DensityTerm plant_density_terms[] = {{\n{rows}\n}};\n"
    )


def _list(values: Iterable[float]) -> str:
    return "{" + ", ".join(repr(float(value)) for value in values) + "}"
