"""All cases of the study, made once: it takes a second."""

import pytest

from studies.flight.tried import all_cases


@pytest.fixture(scope="session")
def every_case():
    return all_cases(1000)
