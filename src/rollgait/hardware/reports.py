"""What the bridge says of itself: where the robot is, what it plans, how it goes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from rollgait.hardware.topics import DIAGNOSTICS, PLAN, encoded
from rollgait.hardware.transports.transport import Transport
from rollgait.mpc.prediction import Prediction
from rollgait.robot.robot import LEG_NAMES
from rollgait.ros.markers import force_marker
from rollgait.ros.messages import Fields, Pose, header, path, transforms
from rollgait.ros.topics import BASE_LINK, LEGS, MARKERS, ODOM, TF, contact_frame

if TYPE_CHECKING:
    from rollgait.hardware.bridge import Bridge

PICTURE_PERIOD: Final = 0.05
"""Between two pictures for people: tf, plan and markers, s."""
HEALTH_PERIOD: Final = 0.5
"""Between two diagnostics, s."""
IDENTITY: Final = np.array([0.0, 0.0, 0.0, 1.0])
OK: Final = b"\x00"
WARN: Final = b"\x01"
ERROR: Final = b"\x02"
"""Levels of `diagnostic_msgs/DiagnosticStatus`."""


class Reports:
    """Publishes what a bridge is doing; one message of each at most in a period, to spread the work.

    Args:
        transport: where to.
        clock: seconds that only go on; their stamps are of it.
    """

    def __init__(self, transport: Transport, clock: Callable[[], float]) -> None:
        self._transport, self._clock = transport, clock
        self._picture = self._health = clock()
        self._turn = 0

    def after(self, bridge: Bridge) -> None:
        """A period of the bridge has passed."""
        now = self._clock()
        stamp = round(1e9 * now)
        if now >= self._health:
            self._health = now + HEALTH_PERIOD
            self._transport.publish(DIAGNOSTICS, encoded(DIAGNOSTICS, diagnostics(bridge, stamp)))
        elif now >= self._picture:
            self._picture = now + PICTURE_PERIOD / 3.0
            self._turn = (self._turn + 1) % 3
            topic, make = ((TF, frames), (PLAN, plan), (MARKERS, forces))[self._turn]
            if (fields := make(bridge, stamp)) is not None:
                self._transport.publish(topic, encoded(topic, fields))


def frames(bridge: Bridge, stamp: int) -> Fields | None:
    """`tf2_msgs/TFMessage`: the base link and the contact points in the world, as estimated."""
    pose = bridge.plant.pose
    if pose is None:
        return None
    feet = bridge.plant.state.foot_position
    found = [Pose(ODOM, BASE_LINK, pose.base_position, pose.base_quaternion)]
    found += [Pose(ODOM, contact_frame(leg), feet[k], IDENTITY) for k, leg in enumerate(LEGS)]
    return transforms(stamp, found)


def plan(bridge: Bridge, stamp: int) -> Fields | None:
    """`nav_msgs/Path`: the CoM over the horizon of the controller; its axes are those of the world."""
    loop = bridge.loop
    prediction: Prediction | None = None if loop is None else loop.prediction
    if prediction is None:
        return None
    places = prediction.com_position
    times = [stamp + round(1e9 * float(t)) for t in prediction.time - prediction.time[0]]
    return path(times, ODOM, places, np.tile(IDENTITY, (len(places), 1)))


def forces(bridge: Bridge, stamp: int) -> Fields:
    """`visualization_msgs/MarkerArray`: the forces on the feet as estimated."""
    plant = bridge.plant
    places, found = plant.state.foot_position, plant.contact_force
    return {
        "markers": [force_marker(stamp, ODOM, leg, places[leg], found[leg]) for leg in range(len(LEG_NAMES))]
    }


def diagnostics(bridge: Bridge, stamp: int) -> Fields:
    """`diagnostic_msgs/DiagnosticArray`: phase, sensors, last stage, and what happened last."""
    plant, sensors = bridge.plant, bridge.plant.sensors
    age = sensors.age
    latest = [event.text for event in (*bridge.events, *bridge.mpc.events)][-1:]
    level = ERROR if bridge.phase == "stopped" else OK if age <= bridge.settings.state_timeout else WARN
    values: dict[str, Any] = {
        "phase": bridge.phase,
        "age of the oldest sensor, s": f"{age:.3f}",
        "messages lost": sensors.lost,
        "messages refused": sum(stream.refused for stream in sensors.streams.values()),
        "targets cut by the last stage": plant.stage.cuts,
        "periods missed": plant.stalls,
        "operator": "silent" if bridge.operator.silent else "there",
    }
    status = {
        "level": level[0],
        "name": "rollgait: bridge",
        "message": latest[0] if latest else bridge.phase,
        "hardware_id": bridge.mpc.robot.name,
        "values": [{"key": key, "value": str(value)} for key, value in values.items()],
    }
    return {"header": header(stamp), "status": [status]}
