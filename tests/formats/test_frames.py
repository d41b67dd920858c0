"""N to EME2000 and GCRF. Orekit's MOD of IAU 1976 is compared in tests/authorities/orekit.py."""

import brahe
import numpy as np
import pytest

from formats.frames import from_N, named
from formats.instants import Instants
from orchestration import InputError

TT = Instants("2009-08-10T00:00:00Z", np.zeros(1)).tt0


def test_the_frame_bias_is_that_of_brahe():
    bias = from_N("GCRF", TT) @ from_N("EME2000", TT).T
    assert bias == pytest.approx(brahe.rotation_eme2000_to_gcrf(), abs=1e-11)


def test_the_pole_of_N_moves_by_20_arcseconds_a_year():
    """The general rate of precession in declination, 20.0431 arcseconds a year at J2000 (Explanatory Supplement)."""
    pole = from_N("EME2000", TT)[:, 2]
    years = (TT[0] - 2451545.0 + TT[1]) / 365.25
    assert np.degrees(np.arccos(pole[2])) * 3600 / years == pytest.approx(20.0431, abs=3e-3)
    assert pole[0] > 0.0  # towards the equinox of J2000


def test_names_of_other_tools_are_understood_or_refused():
    assert (named("ICRF", "x"), named("GCRF2", "x"), named("MOE_EARTH", "x")) == ("GCRF", "GCRF", "N")
    with pytest.raises(InputError, match=r"x.aem: expected one of EME2000, .* found TEMEOFDATE"):
        named("TEMEOFDATE", "x.aem")
