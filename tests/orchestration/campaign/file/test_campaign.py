"""The format of campaign files."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from orchestration.campaign.file.campaign import Campaign, Keep, schema

from ..toy import ROOT


def test_the_published_schema_is_that_of_the_models():
    assert (ROOT / "docs/campaign.schema.json").read_text("utf-8") == schema()


@pytest.mark.parametrize(
    ("model", "field", "value"),
    [
        (Campaign, "seed", "1"),
        (Campaign, "seed", True),
        (Keep, "runs", ["1"]),
        (Keep, "failed", "1"),
        (Keep, "not_met", True),
    ],
)
def test_a_whole_number_is_no_text_and_no_flag(model, field, value):
    with pytest.raises(ValidationError) as caught:
        model.model_validate({field: value})
    assert field in {error["loc"][0] for error in caught.value.errors()}


def test_a_campaign_needs_metrics_or_requirements_and_not_both():
    given = {"name": "a", "scenario": "a.yaml", "vary": {"a.b": {"uniform": [0.0, 1.0]}}}
    metric = {"metrics": [{"name": "m", "signal": "a.x", "statistic": "final"}]}
    for more, told in (({}, True), (metric, False)):
        try:
            Campaign.model_validate(given | more)
            errors = ""
        except ValidationError as error:
            errors = str(error)
        assert ("expected metrics or requirements" in errors) is told, errors
        assert bool(errors) is told
