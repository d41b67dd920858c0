"""The satellite that the controller measures in the other tests."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from .truth import turned


@pytest.mark.parametrize("angle", [0.0, 1e-9, 9e-5, 2e-4, 1.3, np.pi])
def test_a_turn_is_scipys(angle):
    z = angle * np.array([0.48, -0.6, 0.64])
    assert np.abs(turned(z) - Rotation.from_rotvec(z).as_matrix()).max() < 1e-15
