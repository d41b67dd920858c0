"""The kernels, loaded by their meta-kernel and read by SPICE, which has its own precession, TDB and clock."""

import numpy as np
import pytest
import spiceypy as spice
from astropy.time import Time

from formats.convert import convert
from formats.frames import from_N
from formats.instants import Instants
from orchestration import InputError

from .conftest import EPOCH, RATE, attitude

BODY, CLOCK = -9999000, -9999
FROZEN = """FRAME_MOE = 1400000
FRAME_1400000_NAME = 'MOE'
FRAME_1400000_CLASS = 5
FRAME_1400000_CLASS_ID = 1400000
FRAME_1400000_CENTER = 399
FRAME_1400000_RELATIVE = 'J2000'
FRAME_1400000_DEF_STYLE = 'PARAMETERIZED'
FRAME_1400000_FAMILY = 'MEAN_EQUATOR_AND_EQUINOX_OF_DATE'
FRAME_1400000_PREC_MODEL = 'EARTH_IAU_1976'
FRAME_1400000_FREEZE_EPOCH = @2017-01-01T00:00:58.184"""


@pytest.fixture(params=["EME2000", "N"])
def loaded(request, flown, tmp_path, monkeypatch):
    convert(flown, "ck", tmp_path / "kernels", frame=request.param)
    monkeypatch.chdir(tmp_path / "kernels")
    spice.kclear()
    spice.furnsh("spin.tm")
    yield request.param
    spice.kclear()


def test_spice_gives_attitude_and_rate_at_the_ticks_of_the_clock(loaded, flown):
    base = "J2000" if loaded == "EME2000" else "SPIN_N"
    turn = from_N(loaded, Instants(EPOCH, flown.time).tt0)
    for t in flown.time:
        to_body, rate, _ = spice.ckgpav(BODY, t * 1e6, 0.0, base)
        R = turn @ attitude(t).as_matrix()
        assert to_body @ R == pytest.approx(np.eye(3), abs=1e-9)
        assert rate == pytest.approx(R @ RATE, abs=1e-12)


def test_spice_gives_attitude_in_j2000_at_its_own_time(loaded, flown):
    """A double of SPICE's time is 6e-8 s coarse, in which this body turns by 7e-9 rad."""
    turn = from_N("EME2000", Instants(EPOCH, flown.time).tt0)
    for t in (0.25, 10.25, 33.3):  # between two samples the rotation is constant, as SPICE interpolates
        to_body = spice.pxform("J2000", "SPIN_BODY", spice.sct2e(CLOCK, t * 1e6))
        assert to_body @ turn @ attitude(t).as_matrix() == pytest.approx(np.eye(3), abs=2e-8)


@pytest.mark.parametrize("loaded", ["N"], indirect=True)
def test_the_frame_of_N_is_that_of_spices_own_precession(loaded):
    spice.lmpool(FROZEN.split("\n"))
    assert spice.pxform("MOE", "SPIN_N", 0.0) == pytest.approx(np.eye(3), abs=1e-11)


@pytest.mark.parametrize("date", ["2009-08-10T00:00:00", "2016-12-31T23:59:60.5", "2026-03-01T12:00:00"])
@pytest.mark.parametrize("loaded", ["N"], indirect=True)
def test_the_leap_seconds_give_the_tdb_of_astropy(loaded, date):
    t = Time(date, scale="utc").tdb
    assert spice.str2et(date) == pytest.approx(((t.jd1 - 2451545.0) + t.jd2) * 86400.0, abs=5e-5)


@pytest.mark.parametrize("loaded", ["N"], indirect=True)
def test_the_clock_begins_at_the_epoch_of_the_run(loaded):
    assert spice.scs2e(CLOCK, "1/0000000000:000000") == pytest.approx(spice.str2et(EPOCH.rstrip("Z")), abs=1e-6)


def test_a_number_that_is_no_spacecraft_is_refused(flown, tmp_path):
    with pytest.raises(InputError, match=r"--naif-id: expected a negative number of six digits at most, found 399"):
        convert(flown, "ck", tmp_path / "ck", naif_id=399)
