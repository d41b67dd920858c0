"""Values that a user writes for a variable."""

from __future__ import annotations

import pytest

from orchestration.quantities import QuantityError, parse_unit
from orchestration.system.values import scalar

from ..mocks import real


@pytest.mark.parametrize(
    ("value", "found"),
    [
        ("20 kW", "20 kW"),
        ("20.0kW ", "20 kW"),
        ("20", "20 kW"),
        (20, "20 kW"),
        ("2e4 W", "20 kW (2e4 W)"),
    ],
)
def test_a_value_beyond_the_limits_is_said_as_written_only_where_that_differs(value, found):
    gain = real("gain", "parameter", unit=parse_unit("kW"), maxima=(10.0,))
    with pytest.raises(QuantityError) as info:
        scalar(gain, 0, value)
    assert str(info.value) == f"expected at most 10 kW, found {found}"
