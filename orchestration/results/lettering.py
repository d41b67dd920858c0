"""Text in figures: between two `$` Matplotlib draws mathematics."""

from __future__ import annotations


def undrawn(text: str) -> str:
    """Returns why Matplotlib cannot draw a text; "" where it can."""
    from matplotlib.cbook import is_math_text  # optional, and slow to import  # noqa: PLC0415
    from matplotlib.mathtext import MathTextParser  # optional, and slow to import  # noqa: PLC0415

    try:
        if is_math_text(text):
            MathTextParser("path").parse(text)
    except ValueError as error:
        reason = str(error).strip().splitlines()[-1].removeprefix("ParseSyntaxException: ")
        return f"'{text}' cannot be drawn as mathematics: {reason}; remedy: mend it, or write \\$ for a dollar"
    return ""


def plain(text: str) -> str:
    """Returns text of others, in which a dollar is a dollar."""
    return text.replace("$", r"\$")
