"""Maps of docs/evidence/reproduction.md: which claims are met over two constants that the paper does not give."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap

from ..paper import TITLES, Array
from ..plots import AMBER, GREEN, RED, SKY, legend_below, name_axes, panels, patches
from . import sweep
from .claims import CLAIMS, OUTCOMES, all_hold, outcome

_OUTCOME_COLOURS = (GREEN, "#b3e2cd", AMBER, RED, "#5b2000")


def draw(ax: Any, code: Array, x: Array, y: Array, colours: tuple[str, ...]) -> None:
    """Codes (y, x) as coloured cells."""
    ax.grid(False)
    ax.pcolormesh(x, y, code, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(colours) - 0.5, shading="nearest")


def _both(done: dict[str, Any], key: str, shape: tuple[int, int]) -> Array:
    """0 where V.B and V.C keep every claim, 1 where V.B alone, 2 where V.C alone, 3 where neither."""
    b, c = (all_hold(w, done[f"{w}: {key}"]).reshape(shape) for w in CLAIMS)
    return np.select([b & c, b, c], [0, 1, 2], 3)


_BOTH = ("both", "V.B only", "V.C only", "neither")
_BOTH_COLOURS = (GREEN, SKY, AMBER, "#eeeeee")


def _maps(
    done: dict[str, Any], key: str, x: Array, y: Array, labels: tuple[str, str], nominal: tuple[float, float]
) -> Any:
    figure, axes = panels(1, 3, 4.6, 4.0, sharey=True)
    shape = (len(y), len(x))
    codes = [outcome(which, done[f"{which}: {key}"]).reshape(shape) for which in CLAIMS]
    for ax, which, code in zip(axes[0][:2], CLAIMS, codes, strict=True):
        draw(ax, code, x, y, _OUTCOME_COLOURS)
        name_axes(ax, labels[0], labels[1] if which == "V.B" else "", TITLES[which])
    draw(axes[0][2], _both(done, key, shape), x, y, _BOTH_COLOURS)
    name_axes(axes[0][2], labels[0], "", "every claim met in")
    for ax in axes[0]:
        ax.plot(*nominal, marker="+", color="black", markersize=10, markeredgewidth=1.5)
    axes[0][2].legend(handles=patches(_BOTH, _BOTH_COLOURS), fontsize=8, loc="upper right", framealpha=0.9)
    legend_below(figure, patches(OUTCOMES, _OUTCOME_COLOURS, np.array(codes)))
    return figure


def nodes(done: dict[str, Any]) -> Any:
    """Node longitude against the scale of K0."""
    return _maps(
        done,
        "node and K0",
        sweep.NODES,
        sweep.K_SCALES,
        ("node longitude, °E", "scale of K₀, N m (before /50)"),
        (158.0, 0.65),
    )
