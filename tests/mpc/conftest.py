"""One controller for all tests: it is built once, and begins anew for each."""

from collections.abc import Iterator

import pytest

from rollgait.mpc.mpc import Mpc
from rollgait.mpc.settings import MpcSettings

PATIENT = MpcSettings(deadline=60.0)
"""So that the load of the machine changes nothing."""


@pytest.fixture(scope="session")
def built() -> Mpc:
    """Without compiled kernels: the numbers are the same, and no compiler is needed."""
    return Mpc("centauro", PATIENT, kernels=False)


@pytest.fixture
def mpc(built: Mpc) -> Iterator[Mpc]:
    """The controller as if it were new."""
    robot = built.robot
    built.reset("drive")
    built.events.clear()
    yield built
    built.set_mass(robot.mass)
    built.set_weights(**built.settings.weights.model_dump())
    built.set_ground(0.0)
