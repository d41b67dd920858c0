"""Writes what the help of the commands has in common. Tests: tests/orchestration/cli/test_options.py."""

from __future__ import annotations


def examples(*commands: str) -> str:
    """Returns the end of a command's help: commands that can be typed as they stand, each on a line."""
    return "\n".join(["\b", "Examples:", *(f"  {command}" for command in commands)])
