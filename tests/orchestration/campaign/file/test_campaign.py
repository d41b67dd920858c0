"""The format of campaign files."""

from __future__ import annotations

from orchestration.campaign.file.campaign import schema

from ..toy import ROOT


def test_the_published_schema_is_that_of_the_models():
    assert (ROOT / "docs/campaign.schema.json").read_text("utf-8") == schema()
