"""Helper inputs of scenarios, as an interface states them: an altitude that gives the radius of an orbit, for one."""

import pytest

from fmus.interface import InterfaceError, parse

from .toy import INTERFACE


def test_a_helper_input_names_the_parameter_that_it_gives():
    helper = '[helpers.size]\nunit = "m"\ndescription = "how large"\ngives = "{}"\n'
    helpers = parse(INTERFACE + helper.format("offset")).helpers
    assert (helpers["size"].gives, helpers["size"].description) == ("offset", "how large: gives offset")
    for wrong in ("rate", "nothing"):
        with pytest.raises(InterfaceError, match=f"helpers.size: gives: expected a parameter, found '{wrong}'"):
            parse(INTERFACE + helper.format(wrong))
