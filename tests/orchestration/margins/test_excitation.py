"""The multisine and the response between its lines."""

import numpy as np
import pytest

from orchestration.margins.excitation import Multisine


def test_all_lines_have_the_same_size_and_the_peak_is_low():
    sine = Multisine(256)
    signal = sine.signal(100, 2)
    assert len(signal) == 100 + 2 * 256
    assert np.abs(signal).max() == pytest.approx(1)
    assert np.sqrt(np.mean(signal**2)) > 0.5  # a pulse has 0.06, a sine 0.7
    lines = np.abs(sine.spectrum(signal[100:, None]))
    np.testing.assert_allclose(lines, lines.max())
    np.testing.assert_array_equal(signal[:100], signal[256:356])


def test_the_response_between_the_lines_is_that_of_the_pulse():
    sine, pole = Multisine(128), 0.8
    at = np.exp(2j * np.pi * np.arange(65) / 128)
    z = np.exp(1j * sine.frequencies(1.0))
    found = sine.between(sine.pulse((1 / (at - pole))[:, None]))[:, 0]
    np.testing.assert_allclose(found, 1 / (z - pole), rtol=1e-9)
    assert sine.frequencies(0.5)[-1] == pytest.approx(2 * np.pi)
