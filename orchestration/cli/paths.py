"""Holds the type of options and arguments that are paths. Tests: tests/orchestration/cli/test_options.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import InputError
from ..paths import located


class _PathType(click.Path):
    """A path that is no empty text and that the system can look up."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        try:
            return located(str(value))
        except InputError as error:
            option = f"{max(param.opts, key=len)}: " if isinstance(param, click.Option) else ""
            raise InputError(f"{option}{error}") from None


PATH = _PathType(path_type=Path)
