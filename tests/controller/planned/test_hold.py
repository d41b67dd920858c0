"""When a hold begins and is left; and holds that are hard to keep, judged by the plant's truth."""

import numpy as np
import pytest

from .hold import flown, holding, turned


def test_a_1U_under_all_errors_keeps_its_hold_while_the_field_stands_across_the_wheel():
    """From 4850 s to 5700 s the field's part along the wheel's axis is small; with a horizon of 30 T alone it is lost
    there."""
    time, error, field, phase = flown("1U", 8, True, 5800.0, ["plant.b_B", "controller.phase"])
    held = time > 1000.0
    assert np.abs(field[held, 0] / np.linalg.norm(field[held], axis=1)).min() < 0.01
    assert (phase[held] == 3).all()
    assert error[held].max() < 1.0


@pytest.mark.parametrize(("degrees", "phase"), [(4.5, 3), (5.5, 2)])
def test_a_hold_is_left_beyond_five_degrees_and_not_before(degrees, phase):
    with holding() as (it, step):
        it.set("R_NB", turned(degrees))
        seen = step(40)
        assert np.degrees(it.get("attitude_error")) > 0.9 * degrees
    assert set(seen) == {3} if phase == 3 else 2 in seen
