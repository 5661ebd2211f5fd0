"""Drive the robot in MuJoCo as hardware would be driven: from another process, over the topics of ROS 2.

python examples/hardware.py [--quick] [--slow FACTOR]

A simulated robot runs in a process of its own; joint states, IMU and odometry with noise and 5 ms late, and
joint commands, are all that crosses. It is enabled, driven by `cmd_vel`, carries out a plan, and lies down.
How far the estimate is from the truth is reported; the truth crosses on a topic of its own, for that alone.
On a machine that cannot keep up, everything goes in slow motion: `--slow 4`.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np

import rollgait as rg
from rollgait.hardware.bridge import Bridge
from rollgait.hardware.reports import Reports
from rollgait.hardware.robot_process import RobotProcess, RobotSetup
from rollgait.hardware.running import run
from rollgait.hardware.simulated import as_numbers
from rollgait.hardware.topics import ENABLE, TRUTH, VELOCITY, decoded, encoded
from rollgait.hardware.transports.dds import DdsTransport
from rollgait.hardware.transports.transport import Slowed
from rollgait.mpc.mpc import Mpc
from rollgait.ros.messages import vector

DOMAIN = 42
EVERY = 0.05
UP_WITHIN = 20.0


class Example:
    """An operator, and an eye on the truth, in the process of the bridge for once.

    Args:
        bridge: that drives the robot.
        plans: whether it carries out plans: then `/enable` is repeated in place of `cmd_vel`.
        duration: of the drive, s.
    """

    def __init__(self, bridge: Bridge, clock: Callable[[], float], plans: bool, duration: float) -> None:
        self._bridge, self._clock, self._plans, self._duration = bridge, clock, plans, duration
        self._hand = DdsTransport(DOMAIN)
        self._hand.advertise([ENABLE, VELOCITY])
        self._hand.subscribe(TRUTH, self._compare)
        self._begin = clock()
        self._next = 0.0
        self._active_at: float | None = None
        self.errors: list[np.ndarray] = []

    def ends(self) -> bool:
        """Says what is due; whether the drive is over."""
        now = self._clock() - self._begin
        self._hand.receive(0.0)
        if now >= self._next:
            self._next = now + EVERY
            self._say(now)
        if self._active_at is None and self._bridge.phase == "active":
            self._active_at = now
        if self._active_at is None:
            return now > UP_WITHIN
        return now - self._active_at > self._duration

    def _say(self, now: float) -> None:
        if self._active_at is None or self._plans:
            self._hand.publish(ENABLE, encoded(ENABLE, {"data": now > 1.0}))
        else:
            fields = {"linear": vector([0.3, 0.0, 0.0]), "angular": vector([0.0, 0.0, 0.2])}
            self._hand.publish(VELOCITY, encoded(VELOCITY, fields))

    def _compare(self, data: bytes) -> None:
        plant = self._bridge.plant
        if self._bridge.phase == "active":
            truth = np.asarray(decoded(TRUTH, data)["data"])
            self.errors.append(as_numbers(plant.state, plant.touching) - truth)

    def report(self) -> None:
        """Says how far the estimate was from the truth."""
        error = np.array(self.errors)
        rms = np.sqrt(np.mean(error**2, axis=0))
        print(
            f"  CoM within {1e3 * rms[:3].max():.1f} mm (rms), base within {np.degrees(rms[3:6].max()):.2f}°,"
        )
        print(
            f"  feet within {1e3 * rms[6:18].max():.1f} mm, CoM's velocity {1e3 * rms[18:21].max():.0f} mm/s,"
        )
        print(f"  contacts wrong in {100.0 * np.mean(np.abs(error[:, 21:])):.1f} % of the time")
        plant = self._bridge.plant
        print(f"  {plant.sensors.lost} messages lost, {plant.stalls} periods missed")

    def close(self) -> None:
        """Leaves the domain."""
        self._hand.close()


def drive(mpc: Mpc, plans: list[rg.Plan], duration: float, slow: float) -> bool:
    """From a lying robot to a lying robot; whether all went as it should."""
    robot = RobotProcess(RobotSetup(mpc.robot.name, DOMAIN, seed=1, tells_truth=True, slow=slow))
    transport = Slowed(DdsTransport(DOMAIN), slow)
    bridge = Bridge(mpc, transport, clock=transport.clock, plans=plans)
    example = Example(bridge, transport.clock, bool(plans), duration)
    try:
        run(
            bridge,
            Reports(transport, transport.clock),
            example.ends,
            lambda event: print(f"  {event.time:6.2f} s  {event.text}"),
        )
        example.report()
    finally:
        example.close()
        transport.close()
        robot.close()
    return bridge.phase == "off"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true", help="only drive, and not for long")
    parser.add_argument("--slow", type=float, default=1.0, help="slow motion, so many times")
    arguments = parser.parse_args()
    quick, slow = arguments.quick, arguments.slow
    mpc = Mpc("centauro")
    print("driven by cmd_vel")
    passed = drive(mpc, [], 3.0 if quick else 8.0, slow)
    if not quick:
        print("carries out the plan hybrid-forward")
        plan = rg.plan("hybrid-forward")
        passed &= drive(mpc, [plan], plan.horizon + 4.0, slow)
    print("the robot lies, as it did at first" if passed else "the robot had to stand")


if __name__ == "__main__":
    main()
