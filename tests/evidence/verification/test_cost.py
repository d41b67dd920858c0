"""The integrators that docs/evidence/verification.md compares: each flies the same motion, and the page is that of
its file."""

import numpy as np
import pytest

from evidence import files
from evidence.verification import cost
from evidence.verification.page import FILE, Line
from evidence.verification.rk4 import angle_between, environment, pack, truth


@pytest.mark.parametrize(("order", "step", "error"), [(2, 0.1, 3e-4), (4, 0.5, 3e-5), (6, 0.5, 3e-6), (0, 0.5, 1e-6)])
def test_each_method_flies_the_motion_of_the_equations_in_the_body_rate(order, step, error):
    p = cost.parameters((10.0, -8.0, 6.0))
    y = pack(p.R_NB0, p.omega_B0, cost.MOMENTUM)
    true = truth(y, 0.0, 60.0, p.J_B, environment(p, p.residual_dipole_B), lambda l_w: 0.0)[:9].reshape(3, 3)
    *_, end = cost.motion(order, step, 60.0, p)
    assert end.t == pytest.approx(60.0)
    assert 1e-12 < angle_between(end.R, true) < error


def test_an_error_between_two_costs_lies_on_the_line_of_their_logarithms():
    points = [(100.0, 1e-2), (400.0, 1e-2 / 256.0)]  # of fourth order
    assert cost.at(points, 200.0) == pytest.approx(1e-2 / 16.0)


def test_what_is_found_is_within_its_tolerance():
    lines = files.load(Line, FILE, "make authorities")
    assert all(np.abs(line.found - line.expected) <= line.tolerance for line in lines)
