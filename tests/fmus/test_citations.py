"""A number in brackets is a citation, and whoever shows one names the paper."""

from __future__ import annotations

import pytest

from fmus.interface import BLOCKS, SOURCE, citations, cites, load
from fmus.kit.fill import filled
from fmus.native.generate import ports_header


@pytest.mark.parametrize("text", ["law [8] on the plan", "[14]-[24]", "m of [24], or the held value"])
def test_a_number_in_brackets_is_a_citation(text):
    assert cites(text)


@pytest.mark.parametrize("text", ["omega_B[1]", "R_NB[1][2]", "[-1, 1]", "[m]", "from [0, 10]"])
def test_an_element_or_an_interval_is_none(text):
    assert not cites(text)


@pytest.mark.parametrize("block", BLOCKS)
def test_a_file_made_from_an_interface_that_cites_names_the_paper(block):
    interface = load(block)
    cited = citations(interface) == SOURCE
    assert (SOURCE in interface.source) == cited
    texts = [*ports_header(interface).values()]
    texts += [filled(name, interface) for name in ("block.h.template", "block.py.template", "device.py.template")]
    for text in texts:
        assert ("AIAA 2009-5902" in text) == cited
