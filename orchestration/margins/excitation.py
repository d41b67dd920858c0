"""The multisine that is injected, and the response at any frequency from what comes back of it.

It has every line from 0 to half of the sampling frequency. An answer that dies out within a period is thereby known
sample by sample, and so is its spectrum between the lines.

Tests: tests/orchestration/margins/test_excitation.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import Floats

POINTS = 400
"""Frequencies of a response, by equal ratios from a quarter of the lowest line to half of the sampling frequency."""
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Multisine:
    """Sines of equal size that repeat after `samples`, an even number, with Schroeder's phases, which keep the peak
    low."""

    samples: int

    def signal(self, lead: int, periods: int) -> Floats:
        """Returns its samples, of largest size 1: `lead` of them for the loop to settle, then whole periods."""
        k = np.arange(self.samples // 2 + 1)
        phases = -np.pi * k * (k - 1) / len(k)
        phases[-1] = 0.0  # the last line is real
        one = np.fft.irfft(np.exp(1j * phases), self.samples)
        whole = np.tile(one / np.abs(one).max(), periods + -(-lead // self.samples))
        return np.asarray(whole[len(whole) - periods * self.samples - lead :])

    def spectrum(self, signal: Floats) -> Complex:
        """Returns the lines of each whole period of a signal (samples, channels): (periods, lines, channels)."""
        return np.asarray(np.fft.rfft(signal.reshape(-1, self.samples, signal.shape[1]), axis=1))

    def frequencies(self, step: float) -> Floats:
        """Returns the frequencies of a response in rad/s, for samples each `step` seconds."""
        return np.asarray(np.geomspace(np.pi / (2 * self.samples), np.pi, POINTS) / step)

    def pulse(self, response: Complex) -> Floats:
        """Returns the answer to a pulse of 1 (samples, ...) of a response (lines, ...)."""
        return np.asarray(np.fft.irfft(response, self.samples, axis=0))

    def between(self, pulse: Floats) -> Complex:
        """Returns the response whose answer to a pulse this is at the frequencies of `frequencies`."""
        turns = np.outer(self.frequencies(1.0), np.arange(self.samples))
        return np.asarray(np.tensordot(np.exp(-1j * turns), pulse, 1))
