"""What the help of the commands has in common."""

from __future__ import annotations


def examples(*commands: str) -> str:
    """The end of a command's help: commands that can be typed as they stand, each on a line."""
    return "\n".join(["\b", "Examples:", *(f"  {command}" for command in commands)])
