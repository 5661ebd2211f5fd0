"""Robot and bridge in two processes, over DDS: a peer that is lost leaves a robot that stands.

In slow motion, as nobody knows how busy the machine is.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from rollgait.hardware.topics import ENABLE, TRUTH, VELOCITY, decoded, encoded
from rollgait.mpc.mpc import Mpc
from rollgait.ros.messages import vector

pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
from rollgait.hardware.bridge import Bridge, BridgeSettings
from rollgait.hardware.postures import RiseSettings
from rollgait.hardware.robot_process import RobotProcess, RobotSetup
from rollgait.hardware.transports.dds import DdsTransport
from rollgait.hardware.transports.transport import Slowed
from tests.domain import DOMAIN

SLOW = 10.0
WITHIN = 30.0
"""s of the robot's time."""
ROWS = 30
"""Of the truth, 0.01 s apart, in which a robot that stands is at rest."""
STILL = 0.1
"""rad/s, of joints that are told to rest."""

pytestmark = pytest.mark.slow


class Pair:
    """A bridge here, a robot there, and an operator who sees the truth."""

    def __init__(self, mpc: Mpc) -> None:
        self.robot = RobotProcess(RobotSetup("centauro", DOMAIN, tells_truth=True, slow=SLOW, stands=True))
        self.transport = Slowed(DdsTransport(DOMAIN), SLOW)
        settings = BridgeSettings(rise=RiseSettings(settle=0.1))
        self.bridge = Bridge(mpc, self.transport, clock=self.transport.clock, settings=settings)
        self.hand = DdsTransport(DOMAIN)
        self.hand.advertise([ENABLE, VELOCITY])
        self.truth: list[Any] = []
        self.hand.subscribe(TRUTH, lambda data: self.truth.append(np.asarray(decoded(TRUTH, data)["data"])))

    def until(self, done: Callable[[], bool], say: Callable[[], None] | None = None) -> None:
        """Steps of the bridge until something is so."""
        end = self.transport.clock() + WITHIN
        while not done():
            assert self.transport.clock() < end, list(self.bridge.events)
            if say is not None:
                say()
            self.bridge.step()
            self.hand.receive(0.0)

    def drive(self) -> None:
        """Forward."""
        self.hand.publish(VELOCITY, encoded(VELOCITY, {"linear": vector([0.3, 0.0, 0.0])}))

    def up(self) -> None:
        """Enables the robot and drives it until it moves."""
        self.until(lambda: self.bridge.plant.sensors.age < 0.1)
        for on in (False, True):
            for _ in range(20):
                self.hand.publish(ENABLE, encoded(ENABLE, {"data": on}))
                self.bridge.step()
        self.until(lambda: self.bridge.phase == "active")
        self.until(lambda: bool(self.truth) and self.truth[-1][18] > 0.15, self.drive)

    def close(self) -> None:
        self.hand.close()
        self.transport.close()
        self.robot.close()


@pytest.fixture
def pair(mpc: Mpc) -> Iterator[Pair]:
    made = Pair(mpc)
    yield made
    made.close()


def test_a_robot_that_is_lost_stops_the_bridge(pair: Pair) -> None:
    pair.up()
    pair.robot.kill()
    pair.until(lambda: pair.bridge.phase == "stopped", pair.drive)
    stage = pair.bridge.plant.stage
    before = stage.target.position
    pair.until(lambda: np.abs(stage.target.velocity).max() < STILL, pair.drive)
    assert pair.bridge.phase == "stopped"
    assert np.abs(stage.target.position - before).max() < 2.0  # rad, of wheels that brake


def test_a_bridge_that_is_lost_leaves_a_robot_that_stands(pair: Pair) -> None:
    pair.up()
    pair.transport.close()  # not a word more
    pair.truth.clear()
    end = time.monotonic() + SLOW * WITHIN
    truth = np.full((ROWS, 25), np.inf)
    while time.monotonic() < end and not np.abs(truth[:, 18:21]).max() < 0.03:  # it sways at first
        pair.hand.receive(0.1)
        truth = np.array(pair.truth[-ROWS:]) if len(pair.truth) >= ROWS else truth
    assert np.abs(truth[:, 18:21]).max() < 0.03
    assert np.abs(truth[:, 4:6]).max() < np.radians(5.0)
    assert truth[:, 21:].all()
