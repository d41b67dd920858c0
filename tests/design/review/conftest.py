"""A satellite for the tests of its review: the 3U of the template, on a CubeSat's sensors."""

from pathlib import Path

import pytest

from design import new_satellite
from design.review import facts as of
from orchestration.cli.overrides import settings

DATA = (
    *("mass=4 kg", "body_width=10 cm", "body_length=34 cm", "body_axis=z", "dipole_max=0.3 A.m2"),
    *("wheel_torque_max=0.3 mN.m", "wheel_momentum_max=2 mN.m.s", "altitude=500 km", "inclination=97.4 deg"),
)


@pytest.fixture(scope="session")
def satellite(tmp_path_factory) -> Path:
    """Its scenario, with a wheel, wheels in a pyramid on a star tracker, and rods alone beside it."""
    folder = tmp_path_factory.mktemp("satellites")
    found = new_satellite.templates()
    new_satellite.fill(found, folder / "one", settings(DATA))
    new_satellite.fill(found, folder / "none", {**settings((*DATA[:5], *DATA[7:])), "wheels": "none"})
    new_satellite.fill(found, folder / "four", settings((*DATA, "wheels=pyramid 35 deg", "sensors=star tracker")))
    return folder / "one" / "tumble.yaml"


@pytest.fixture(scope="session")
def four_wheels(satellite: Path) -> Path:
    return satellite.parents[1] / "four" / "tumble.yaml"


@pytest.fixture(scope="session")
def unmeasured(four_wheels: Path) -> Path:
    """The same without telemetry: the law has the true momenta, the estimator none."""
    path = four_wheels.with_name("unmeasured.yaml")
    path.write_text(
        four_wheels.read_text("utf-8")
        .replace("  - allocator.h_w_estimate -> estimator.h_w\n", "")
        .replace("allocator.h_w_estimate -> controller.h_w", "plant.h_w -> controller.h_w")
        .replace("sensors.h_w_measured ->", "plant.h_w ->"),
        "utf-8",
    )
    return path


@pytest.fixture(scope="session")
def facts(satellite: Path) -> of.Facts:
    return of.facts(satellite, 4.0)
