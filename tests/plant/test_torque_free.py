"""Torque-free motion in closed form. The comparison itself is an authority; here the closed form is checked too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from evidence.verification.rk4 import angle_between, pack, truth
from tests.authorities.free_body import FreeBody
from tests.plant.motion import FULL_INERTIA, bare, measured_order, no_moment


@pytest.mark.parametrize("Omega", [[0.09, -0.02, 0.01], [-0.02, 0.03, 0.1], [0.01, 0.06, -0.09]])
def test_the_closed_form_is_what_quadrature_and_dop853_give(Omega):
    Omega, R0 = np.array(Omega), Rotation.random(random_state=7).as_matrix()
    body = FreeBody(FULL_INERTIA, Omega, R0)
    by_quadrature, _ = quad(body.precession_rate, 0.0, 90.0, epsabs=1e-12, epsrel=1e-13, limit=400)
    assert body.precession(90.0) == pytest.approx(by_quadrature, abs=1e-11)
    y = truth(pack(R0, Omega, 0.0), 0.0, 90.0, FULL_INERTIA, no_moment, lambda l_w: 0.0)
    assert body.rate(90.0) == pytest.approx(y[9:12], abs=1e-13)
    assert angle_between(body.attitude(90.0), y[:9].reshape(3, 3)) < 1e-12


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_attitudes_order_shows_against_the_closed_form(order):
    Omega = np.array([0.08, -0.1, 0.07])
    exact = FreeBody(FULL_INERTIA, Omega).attitude(20.0)
    errors = {
        h: angle_between(bare(order, h, round(20.0 / h), np.eye(3), Omega, FULL_INERTIA)[0], exact)
        for h in (2.0, 1.0, 0.5)
    }
    assert measured_order(errors) == pytest.approx(order, abs=0.2)
