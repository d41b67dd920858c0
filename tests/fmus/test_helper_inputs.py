"""Helper inputs of scenarios, as an interface states them: an altitude that gives the radius of an orbit, for one."""

import pytest

from fmus.interface import InterfaceError, parse

BLOCK = """
[block]
name = "small"
description = "with a parameter"
[experiment]
stop = 1.0
step = 0.1
[variables.vector]
causality = "input"
shape = [2]
description = "in"
start = [0.0, 0.0]
[variables.width]
causality = "parameter"
variability = "fixed"
unit = "m"
description = "of the body"
start = 1.0
"""


def test_a_helper_input_names_the_parameter_that_it_gives():
    helper = '[helpers.size]\nunit = "m"\ndescription = "how large"\ngives = "{}"\n'
    helpers = parse(BLOCK + helper.format("width")).helpers
    assert (helpers["size"].gives, helpers["size"].description) == ("width", "how large: gives width")
    for wrong in ("vector", "nothing"):
        with pytest.raises(InterfaceError, match=f"helpers.size: gives: expected a parameter, found '{wrong}'"):
            parse(BLOCK + helper.format(wrong))
