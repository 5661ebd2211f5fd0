"""A robot in MuJoCo at one end of a loopback, the bridge at another, an operator at the third."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rollgait.mpc.mpc import Mpc
from rollgait.mpc.settings import MpcSettings
from tests.hardware.rig import Rig

pytest.importorskip("mujoco", reason="the extra 'whole-body' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros' is not installed")


@pytest.fixture(scope="session")
def built() -> Mpc:
    """Patient, so that load changes nothing; without kernels, so that no compiler is needed."""
    return Mpc("centauro", MpcSettings(deadline=60.0), kernels=False)


@pytest.fixture
def mpc(built: Mpc) -> Iterator[Mpc]:
    """The controller as if it were new."""
    built.reset("drive")
    yield built
    built.reset("drive")


@pytest.fixture
def rig(mpc: Mpc) -> Rig:
    """A robot that stands in its stance, not enabled."""
    return Rig(mpc)


@pytest.fixture
def up(rig: Rig) -> Rig:
    """The same, with the controller having it."""
    rig.enable()
    rig.until("active", 3.0)
    return rig
