"""Where a loop may be opened, and what is said where it may not."""

import numpy as np
import pytest

from orchestration.errors import InputError
from orchestration.margins.site import site

from .loops import Flights, law, linear

PLANT = np.eye(2), np.eye(2), np.eye(2)


@pytest.fixture
def plan():
    return Flights(lambda: [linear(*PLANT), law(lambda y: -y, 2, 2)], law={"every": 2}).opened.plan


def test_a_port_has_a_channel_for_each_element_and_an_output_reaches_its_receivers(plan):
    whole, one = site(plan, ["plant.y"]), site(plan, ["law.u[2]"])
    assert whole.labels == ["plant.y[1]", "plant.y[2]"]
    assert one.labels == ["law.u[2]"]
    assert whole.channels[1].receivers == one.channels[0].receivers
    assert (whole.hold, whole.channels[0].receivers[0].behind) == (2, 0)
    assert site(plan, ["plant.u"]).channels[0].receivers[0].behind == 1  # the plant is stepped before the law


@pytest.mark.parametrize(
    ("ports", "message"),
    [
        (["plant"], "--at plant: expected block.port, found 'plant'"),
        (["plan.u"], "--at plan.u: there is no block 'plan'"),
        (["plant.z"], "--at plant.z: plant has no input or output 'z'"),
        (["plant.y", "plant.y[1]"], "a channel is named twice"),
        ([], "expected --at block.port, found none"),
    ],
)
def test_a_wrong_port_is_refused_with_its_place(plan, ports, message):
    with pytest.raises(InputError, match=message.replace("[", r"\[").replace("?", r"\?")):
        site(plan, ports)
