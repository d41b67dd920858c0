"""Fixtures that several test packages share, and the markers that a test has by its folder."""

from __future__ import annotations

import os
import re
import signal
import sys
from functools import cache
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest

from fmus.build import blocks_of, ensure
from tests.machine import require_c_compiler

# Each of the hundreds of processes that the tests start would otherwise compile all that it imports.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# pytest imports readline, which states a terminal of 80 columns, also for other processes.
os.environ.pop("COLUMNS", None)
os.unsetenv("COLUMNS")
# A shell lets what it starts in the background ignore Ctrl-C, and nohup a terminal that is closed; so would the tests
# that send these.
for name, handler in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) is signal.SIG_IGN:
        signal.signal(getattr(signal, name), handler)

HERE = Path(__file__).parent
MARKERS = {
    "compile": (
        "controller/planned",
        "fmus/contents",
        "fmus/kit",
        "fmus/link",
        "fmus/python",
        "fmus/test_build.py",
        "fmus/test_dependencies.py",
        "fmus/test_nested.py",
        "fmus/test_no_attitude.py",
        "fmus/test_rules.py",
        "native",
        "orchestration/export/test_container_sanitized.py",
        "orchestration/master/test_compiled.py",
        "packaging",
    ),
    "isolate": ("orchestration/instances", "orchestration/system/test_optional.py"),
    "fly": (
        "authorities",
        "design",
        "docs/test_notebooks.py",
        "estimator",
        "evidence",
        "inflight/test_bank.py",
        "inflight/test_commands.py",
        "orchestration/acceptance/test_frames.py",
        "orchestration/acceptance/test_polarity.py",
        "orchestration/acceptance/test_vector.py",
        "orchestration/campaign/test_engine.py",
        "orchestration/campaign/test_replay.py",
        "orchestration/cli/test_margins.py",
        "orchestration/margins",
        "orchestration/scenario/test_changed_at_random.py",
        "plant/sensors/test_loop.py",
        "plant/test_gravity_gradient.py",
        "plant/test_invariants.py",
        "supervisor/test_flight.py",
        "tools/test_foreign_ssp.py",
    ),
    "thorough": (
        "authorities",
        "controller/planned/test_failures.py",
        "controller/planned/test_failures_estimated.py",
        "controller/planned/test_identification.py",
        "controller/planned/test_outputs.py",
        "controller/planned/test_steering.py",
        "controller/planned/test_strained.py",
        "design/review/test_review.py",
        "design/test_floquet.py",
        "design/test_margins.py",
        "docs/test_site.py",
        "evidence/flight/test_page.py",
        "evidence/flight/test_rival.py",
        "evidence/satellites/test_classes.py",
        "evidence/test_hold_bound.py",
        "fmus/kit/test_device_kit.py",
        "fmus/kit/test_example.py",
        "fmus/kit/test_flight.py",
        "fmus/kit/test_kit.py",
        "fmus/link/test_answers.py",
        "fmus/link/test_emulated.py",
        "fmus/link/test_strangers.py",
        "fmus/test_dependencies.py",
        "fmus/test_nested.py",
        "inflight/test_coverage.py",
        "inflight/test_nutation.py",
        "native/test_carried.py",
        "native/test_linking.py",
        "native/test_sanitizers.py",
        "orchestration/acceptance/test_page.py",
        "orchestration/campaign/flying/test_checks.py",
        "orchestration/campaign/flying/test_cluster.py",
        "orchestration/campaign/report/test_page.py",
        "orchestration/instances/test_isolation.py",
        "orchestration/instances/test_surroundings.py",
        "orchestration/live/test_live.py",
        "orchestration/margins/test_kinds.py",
        "orchestration/results/test_browser.py",
        "orchestration/results/test_endings.py",
        "orchestration/results/test_outputs.py",
        "orchestration/session/test_priority.py",
        "orchestration/swap/test_own_claims.py",
        "orchestration/system/test_optional.py",
        "orchestration/test_broken.py",
        "packaging/test_wheel.py",
        "release",
        "test_continuous_integration.py",
        "test_vendors.py",
    ),
}
"""What the tests of a folder or file do that takes long. A single test elsewhere has its marker at its head."""


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """A file whose markers `-m "not ..."` leaves out is not even imported, which takes seconds for some."""
    left_out = re.fullmatch(r"not \(?([a-z]+(?: or [a-z]+)*)\)?", config.option.markexpr)
    is_left_out = left_out and not set(left_out[1].split(" or ")).isdisjoint(markers_of(collection_path))
    return True if is_left_out else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    missing = [place for places in MARKERS.values() for place in places if not (HERE / place).exists()]
    if missing:
        raise pytest.UsageError(
            f"tests/conftest.py: MARKERS: there is no tests/{missing[0]}; expected a folder or file"
        )
    for item in items:
        for marker in markers_of(item.path):
            item.add_marker(marker)


@cache
def markers_of(path: Path) -> list[str]:
    """The markers of the tests in a file."""
    place = path.relative_to(HERE)
    return [marker for marker, places in MARKERS.items() if any(place.is_relative_to(p) for p in places)]


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """Random numbers of one test alone, the same whichever tests ran before it."""
    return np.random.default_rng(crc32(request.node.name.encode()))


@pytest.fixture(scope="session")
def c_compiler() -> None:
    """For tests that build a C kit."""
    require_c_compiler()


@pytest.fixture(scope="session")
def built_fmus() -> dict[str, Path]:
    """This project's FMUs in the Python flavour, by block; built once for all processes of the tests."""
    return {block: ensure(block, "python") for block in blocks_of("python")}
