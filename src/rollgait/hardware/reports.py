"""What is said of a robot that is controlled: where it is, what it plans, how it goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from rollgait.hardware.topics import DIAGNOSTICS, PLAN, encoded
from rollgait.hardware.transports.transport import Transport
from rollgait.mpc.prediction import Prediction
from rollgait.plant.state import Array, RobotState
from rollgait.robot.robot import LEG_NAMES
from rollgait.ros.markers import force_marker
from rollgait.ros.messages import Fields, Pose, header, path, transforms
from rollgait.ros.topics import BASE_LINK, LEGS, MARKERS, ODOM, TF, contact_frame

if TYPE_CHECKING:
    from rollgait.simulation.physics import Pose as BodyPose

PICTURE_PERIOD: Final = 0.05
"""Between two pictures for people: tf, plan and markers, s."""
HEALTH_PERIOD: Final = 0.5
"""Between two diagnostics, s."""
IDENTITY: Final = np.array([0.0, 0.0, 0.0, 1.0])
OK: Final = b"\x00"
WARN: Final = b"\x01"
ERROR: Final = b"\x02"
"""Levels of `diagnostic_msgs/DiagnosticStatus`."""


@dataclass(frozen=True)
class Health:
    """How it goes, for `/diagnostics`.

    Attributes:
        level: `OK`, `WARN` or `ERROR`.
        name: of what reports.
        message: what happened last.
        robot: its name.
        values: what else there is to know.
    """

    level: bytes
    name: str
    message: str
    robot: str
    values: Mapping[str, Any]


class SeenPlant(Protocol):
    """What is seen of a robot: as estimated, or as it is.

    Attributes:
        state: of the robot.
        pose: of its base link and joints; None until it is known.
        contact_force: of the ground on its feet, (4, 3), N.
    """

    @property
    def state(self) -> RobotState: ...
    @property
    def pose(self) -> BodyPose | None: ...
    @property
    def contact_force(self) -> Array: ...


class Reported(Protocol):
    """What is reported on: a bridge, or a run.

    Attributes:
        plant: the robot.
        prediction: of the controller; None while it has made none.
    """

    @property
    def plant(self) -> SeenPlant: ...
    @property
    def prediction(self) -> Prediction | None: ...
    def health(self) -> Health:
        """How it goes."""


class Reports:
    """Publishes how a robot is doing; one message at most in a period, to spread the work.

    Args:
        transport: where to.
        clock: seconds that only go on; their stamps are of it.
    """

    def __init__(self, transport: Transport, clock: Callable[[], float]) -> None:
        self._transport, self._clock = transport, clock
        self._picture = self._health = clock()
        self._turn = 0

    def after(self, seen: Reported) -> None:
        """A period has passed."""
        now = self._clock()
        stamp = round(1e9 * now)
        if now >= self._health:
            self._health = now + HEALTH_PERIOD
            self._transport.publish(DIAGNOSTICS, encoded(DIAGNOSTICS, diagnostics(seen.health(), stamp)))
        elif now >= self._picture:
            self._picture = now + PICTURE_PERIOD / 3.0
            self._turn = (self._turn + 1) % 3
            topic, make = ((TF, frames), (PLAN, plan), (MARKERS, forces))[self._turn]
            if (fields := make(seen, stamp)) is not None:
                self._transport.publish(topic, encoded(topic, fields))


def frames(seen: Reported, stamp: int) -> Fields | None:
    """`tf2_msgs/TFMessage`: the base link and the contact points in the world."""
    pose = seen.plant.pose
    if pose is None:
        return None
    feet = seen.plant.state.foot_position
    found = [Pose(ODOM, BASE_LINK, pose.base_position, pose.base_quaternion)]
    found += [Pose(ODOM, contact_frame(leg), feet[k], IDENTITY) for k, leg in enumerate(LEGS)]
    return transforms(stamp, found)


def plan(seen: Reported, stamp: int) -> Fields | None:
    """`nav_msgs/Path`: the CoM over the horizon of the controller; its axes are those of the world."""
    prediction = seen.prediction
    if prediction is None:
        return None
    places = prediction.com_position
    times = [stamp + round(1e9 * float(t)) for t in prediction.time - prediction.time[0]]
    return path(times, ODOM, places, np.tile(IDENTITY, (len(places), 1)))


def forces(seen: Reported, stamp: int) -> Fields:
    """`visualization_msgs/MarkerArray`: the forces on the feet."""
    plant = seen.plant
    places, found = plant.state.foot_position, plant.contact_force
    return {
        "markers": [force_marker(stamp, ODOM, leg, places[leg], found[leg]) for leg in range(len(LEG_NAMES))]
    }


def diagnostics(health: Health, stamp: int) -> Fields:
    """`diagnostic_msgs/DiagnosticArray`."""
    status = {
        "level": health.level[0],
        "name": health.name,
        "message": health.message,
        "hardware_id": health.robot,
        "values": [{"key": key, "value": str(value)} for key, value in health.values.items()],
    }
    return {"header": header(stamp), "status": [status]}
