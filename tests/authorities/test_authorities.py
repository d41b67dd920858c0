"""Every authority of docs/evidence/verification.md, each within its tolerance."""

from __future__ import annotations

import pytest

from tests.authorities import load

AUTHORITIES = load()


@pytest.mark.parametrize("authority", AUTHORITIES, ids=lambda authority: authority.name)
def test_the_plant_agrees_with_the_authority(authority):
    if not authority.quick:
        pytest.skip("heavy: run by `make authorities`")
    if not authority.available:
        pytest.skip(f"needs {authority.needs}")
    figure = authority.measure()
    assert authority.agrees(figure), (
        f"{authority.what}: {figure:.3g} {authority.unit}, expected {authority.expected:g} within {authority.tolerance:g}"
    )


def test_the_page_lists_every_authority():
    from tests.authorities.__main__ import PAGE

    page = PAGE.read_text("utf-8")
    missing = [authority.what for authority in AUTHORITIES if f"| {authority.what} |" not in page]
    assert not missing, f"docs/evidence/verification.md is out of date, run `make authorities`: {missing}"
