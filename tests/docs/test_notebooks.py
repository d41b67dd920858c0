"""The notebooks of docs/use/notebooks run from the first cell to the last, as a reader types them in the project's
folder."""

import ast
from pathlib import Path

import numpy as np
import pytest

NOTEBOOKS = sorted(Path("docs/use/notebooks").glob("*.ipynb"))


def shown(cell, names):
    """Runs a cell and returns the value of the expression at its end, which a notebook shows."""
    body = ast.parse(cell).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_of_a_notebook_runs_and_what_it_shows_is_right(path):
    import nbformat  # here, since it takes 3 s, and each run of any test would wait for it

    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    names = {}
    values = [shown(cell.source, names) for cell in notebook.cells if cell.cell_type == "code"]
    if path.stem == "first_run":
        assert (301, 3) in [value[0] for value in values if isinstance(value, tuple)]
        assert ("time", "row") in values
    elif path.stem == "sweep_and_checks":
        assert len(names["points"]) == 4
        assert names["fits"] is True
        assert {difference.largest for difference in names["comparison"].differences} == {0.0}
    elif path.stem == "own_law":
        J = np.diag([0.0426, 0.0608, 0.0618])
        assert names["law"] == pytest.approx(-0.05 * names["result"]["plant.omega_B"] @ J)
        slow, middle, quick = names["damped"].values()
        assert slow > middle > quick
    else:
        assert min(value for value in values if isinstance(value, float)) < 1e-12


def test_the_notebooks_are_four_and_the_page_lists_them():
    page = Path("docs/use/notebooks.md").read_text("utf-8")
    assert [path.stem for path in NOTEBOOKS] == ["first_run", "formats", "own_law", "sweep_and_checks"]
    assert all(f"(notebooks/{path.name})" in page for path in NOTEBOOKS)
