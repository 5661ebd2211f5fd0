"""What the tests of the bridge drive: all in one process, in a time of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rollgait.hardware.bridge import Bridge, BridgeSettings
from rollgait.hardware.postures import RiseSettings, rise_of
from rollgait.hardware.simulated import SimulatedRobot
from rollgait.hardware.topics import ENABLE, JOINT_COMMANDS, VELOCITY, decoded, encoded
from rollgait.hardware.transports.loopback import Loopback
from rollgait.mpc.mpc import Mpc
from rollgait.robot.urdf_model import load_model
from rollgait.robot.whole_body import find_whole_body
from rollgait.ros.messages import vector
from rollgait.terrain.terrain import Terrain

SETTLE = 0.1


class Rig:
    """Robot, bridge and operator on a loopback.

    Attributes:
        told: joint commands that went over the wire.
    """

    def __init__(
        self,
        mpc: Mpc,
        *,
        lowest: bool = False,
        posture: Any = None,
        terrain: Terrain | None = None,
        **options: Any,
    ) -> None:
        self.loopback = Loopback()
        self.cable = self.loopback.end()
        rise = rise_of(load_model(find_whole_body(mpc.robot)), mpc.robot)
        if posture is None:
            posture = rise.postures[0 if lowest else -1]
        self.robot = SimulatedRobot(mpc.robot, self.cable, seed=3, posture=posture, terrain=terrain)
        self.loopback.each_tick(lambda _: self.robot.tick())
        self.hand = self.loopback.end()
        self.told: list[dict[str, Any]] = []
        self.hand.subscribe(JOINT_COMMANDS, lambda data: self.told.append(decoded(JOINT_COMMANDS, data)))
        settings = BridgeSettings(rise=RiseSettings(settle=SETTLE))
        self.bridge = Bridge(
            mpc, self.loopback.end(), clock=lambda: self.loopback.time, settings=settings, **options
        )

    # -- the operator --

    def switch(self, on: bool) -> None:
        self.hand.publish(ENABLE, encoded(ENABLE, {"data": on}))

    def enable(self) -> None:
        """Off, then on, as an operator does it once sensors are heard."""
        self.run(0.05)
        self.switch(False)
        self.run(0.02)
        self.switch(True)
        self.run(0.02)

    def drive(self, forward: float) -> None:
        fields = {"linear": vector([forward, 0.0, 0.0]), "angular": vector([0.0, 0.0, 0.0])}
        self.hand.publish(VELOCITY, encoded(VELOCITY, fields))

    # -- time --

    def run(self, seconds: float, each: Callable[[], None] | None = None) -> None:
        """So long, with something done in each period."""
        end = self.loopback.time + seconds
        while self.loopback.time < end - 1e-9:
            if each is not None:
                each()
            self.bridge.step()
            self.hand.receive(0.0)

    def until(self, phase: str, at_most: float, each: Callable[[], None] | None = None) -> float:
        """Until the bridge is in a phase; how long that took, s."""
        begin = self.loopback.time
        while self.bridge.phase != phase:
            assert self.loopback.time - begin < at_most, (self.bridge.phase, list(self.bridge.events))
            self.run(0.01, each)
        return self.loopback.time - begin

    @property
    def speed(self) -> float:
        """True speed of the CoM, m/s."""
        return float(np.linalg.norm(self.robot.truth.com_velocity))

    def stands(self) -> bool:
        """Whether the true robot is upright on four feet, at rest."""
        truth = self.robot.truth
        upright = bool(np.abs(truth.euler[1:]).max() < np.radians(5.0)) and not self.robot.has_fallen
        return upright and self.speed < 0.03 and bool(self.robot.touching.all())
