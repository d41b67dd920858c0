"""What `orchestrate margins` writes and prints of a linear model. Tests: tests/orchestration/cli/test_margins.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import writing
from ..margins.block import BlockModel
from ..margins.linear import Linear
from .console import complain, notes, say, say_json
from .status import EXPECTATION_FAILED


def tell_model(found: BlockModel, when: float, folder: Path, json_: bool) -> int:
    """Writes and prints the linear model of a block; the status is 1 where it has none."""
    model = found.model
    if json_:
        say_json(data_of(found))
    else:
        notes(found.notes)
    if found.refused:
        complain(f"no linear model: {found.refused}")
        return EXPECTATION_FAILED
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    save(model, folder)
    if not json_:
        sizes = f"{len(model.inputs)} inputs, {len(model.outputs)} outputs, {len(model.A)} states"
        say(f"linear model at {when:g} s, each {model.step:g} s: {sizes}", bold=True)
        if model.states:
            say(f"states: {', '.join(model.states)}")
            say("eigenvalues of A: " + ", ".join(f"{value:.6g}" for value in model.eigenvalues))
        say(model.verdict)
        say(f"written to {folder / 'model.npz'} and model.mat")
    return 0


def data_of(found: BlockModel) -> dict[str, Any]:
    model = found.model
    matrices = {name: getattr(model, name).tolist() for name in "ABCD"}
    names = {"inputs": model.inputs, "outputs": model.outputs, "states": model.states}
    said = {"sample": model.step, "error": model.error, "verdict": model.verdict, "notes": found.notes}
    return {**names, **matrices, **said, "refused": found.refused or None}


def told_of_loop(model: Linear, name: str) -> str:
    """Returns what is told of the closed loop."""
    sizes = ", ".join(f"{abs(value):.6g}" for value in model.eigenvalues)
    return f"Closed loop from sample to sample, |eigenvalues| {sizes}; {model.verdict}; written to {name}.npz and .mat"


def save(model: Linear, folder: Path, name: str = "model") -> None:
    for suffix in ("npz", "mat"):
        model.save(folder / f"{name}.{suffix}")
