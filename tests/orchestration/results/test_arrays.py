"""The numbers of a page: thinned out without the loss of a spike, and packed."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.results import arrays

from .swing import unpacked


def test_of_a_long_run_few_rows_stay_and_every_spike():
    generator = np.random.default_rng(1)
    values = generator.normal(size=(200_003, 3))
    spikes = [(3, 0, 50.0), (77_777, 1, -60.0), (200_001, 2, 70.0)]
    for row, column, value in spikes:
        values[row, column] = value
    rows = arrays.kept(values, 5000)
    assert 3000 < len(rows) <= 5200
    assert {0, 200_002, 3, 77_777, 200_001} <= set(rows.tolist())
    assert (np.diff(rows) > 0).all()


def test_a_short_run_is_shown_whole():
    assert len(arrays.kept(np.zeros((5000, 4)), 5000)) == 5000


def test_gaps_survive_thinning_out():
    values = np.zeros((100_000, 1))
    values[54_321] = np.nan
    assert 54_321 in arrays.kept(values, 1000)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        (np.array([0.0, 1.0, -3.5]), "f4"),
        (np.array([1000.0, 1000.0001]), "f8"),
        (np.array([True, False]), "u1"),
        (np.array([np.nan, np.inf, 1e300, 2.0]), "f4"),
        (np.array([5e-324, 0.0]), "f4"),
        (np.array([np.nan]), "f4"),
    ],
)
def test_numbers_take_as_few_bytes_as_a_plot_allows(values, kind):
    packed = arrays.Arrays()
    assert packed.add(values) == packed.add(values.copy()) == 0
    assert packed.items[0]["type"] == kind
    back, drawn = unpacked(packed.items[0]), np.abs(values.astype(float)) <= 1e30
    assert np.isnan(back[~drawn]).all()
    np.testing.assert_allclose(back[drawn], values[drawn].astype(float), rtol=1e-7, atol=1e-30)


def test_spans_too_many_to_see_are_joined():
    spans = [(float(i), i + 0.5) for i in range(100_000)]
    few = arrays.few(spans)
    assert len(few) <= arrays.MARKS + 1
    assert (few[0][0], few[-1][1]) == (0.0, 99_999.5)
