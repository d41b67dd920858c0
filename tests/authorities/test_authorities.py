"""Every authority of docs/evidence/verification.md, each within its tolerance."""

from __future__ import annotations

import pytest

from evidence import files
from evidence.verification.page import FILE, Line, row
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
        f"{authority.what}: {figure:.3g} {authority.unit}, expected {authority.expected:g} within "
        f"{authority.tolerance:g}"
    )


def test_the_page_has_every_authority_as_it_is_here():
    kept = {line.what: line for line in files.load(Line, FILE, "make authorities")}
    assert list(kept) == [authority.what for authority in AUTHORITIES]
    page = FILE.with_suffix(".md").read_text("utf-8")
    for authority in AUTHORITIES:
        found = kept[authority.what]
        assert (found.expected, found.tolerance) == pytest.approx((authority.expected, authority.tolerance), rel=1e-4)
    for subject in {line.subject for line in kept.values()}:
        assert f"| {' | '.join(row(subject, [x for x in kept.values() if x.subject == subject]))} |" in page
