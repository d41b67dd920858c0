"""What stands below a figure: each thing once, in full, and on the page."""

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from orchestration.results.keys import Keys, below

COLOUR = {"color": "#0072b2", "alpha": 0.16, "linewidth": 0.0}


@pytest.fixture
def keys():
    keys = Keys()
    for panel in ("attitude error", "wheel momentum"):  # every panel tells the same
        keys.line("limits", panel)
        keys.fault("plant.disturbance_torque_B = [2e-3, -1.5e-3, 2e-3] N.m, from 41992 s to 42052 s, " * 3)
        for phase in ("nadir", "_own"):
            keys.phase(phase, COLOUR)
        for crossing in range(8):
            keys.mark("allocator.b_wheel", float(crossing))
    return keys


def test_each_thing_is_told_once(keys):
    kinds = [kind for kind, _ in keys.texts()]
    assert kinds == ["line", "mark"]
    assert len(keys.faults) == 1
    assert keys.texts()[0] == ("line", "limits")
    assert keys.texts()[1][1].endswith("5.00 s and 2 more")


def test_each_fault_has_a_bar_and_a_colour_of_its_own_in_all_panels():
    keys = Keys()
    first, second = keys.fault("one"), keys.fault("another")
    assert (first[0], second[0]) == (0, 1)
    assert first[1] != second[1]
    assert (keys.fault("one"), keys.fault("another")) == (first, second)


def test_lines_of_two_kinds_name_their_panels(keys):
    keys.line("true values", "gyro bias")
    assert [text for kind, text in keys.texts() if kind == "line"] == [
        "limits (attitude error, wheel momentum)",
        "true values (gyro bias)",
    ]


@pytest.mark.parametrize("width", [5.2, 10.4])
def test_what_is_told_lies_within_the_figure_and_below_its_panels(keys, width):
    figure = Figure(figsize=(width, 3.4), dpi=100, layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel("time, s")
    below(figure, keys)
    figure.draw_without_rendering()
    edges = [legend.get_window_extent() for legend in figure.artists]
    assert len(edges) == 2
    assert min(edge.x0 for edge in edges) >= 0
    assert max(edge.x1 for edge in edges) <= figure.bbox.x1
    assert min(edge.y0 for edge in edges) >= 0
    assert max(edge.y1 for edge in edges) <= axes.get_tightbbox().y0
    assert edges[0].y1 <= edges[1].y0
    assert [text.get_text() for text in figure.artists[1].findobj(Text) if text.get_text()] == ["nadir", " _own"]


def test_a_figure_without_anything_to_tell_keeps_its_size():
    figure = Figure(figsize=(5.2, 3.4), layout="constrained")
    below(figure, Keys())
    assert figure.get_size_inches().tolist() == [5.2, 3.4]
