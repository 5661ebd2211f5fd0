"""What a robot's sensors say, out of messages that may be wrong, old or lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.hardware.topics import IMU, SENSORS, decoded, nanoseconds_of
from rollgait.hardware.transports.transport import Transport
from rollgait.ros.messages import Fields
from rollgait.ros.topics import BASE_LINK, JOINT_STATES, ODOMETRY, Topic

Array = NDArray[np.float64]

GAP: Final = 1.5
"""So many usual distances between two stamps count as a lost message."""
LEAP_BACK: Final = 5 * 10**9
"""A stamp so much older than the last is that of a clock that was set, or of a robot that began anew, ns."""
BASE_FRAMES: Final = ("", BASE_LINK)
"""Frames in which an IMU and an odometry may say how the base moves; none is taken for that of the base."""
NORM_MIN: Final = 0.5
"""A quaternion shorter than that is one that nobody set."""


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints in the order that they were asked for: (n_j,), rad, rad/s, N m; `time` of arrival, s."""

    time: float
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, eq=False)
class Imu:
    """Orientation of the base link in the world (x, y, z, w), angular velocity in its axes, (3,), rad/s."""

    time: float
    quaternion: Array
    angular_velocity: Array


@dataclass(frozen=True, eq=False)
class Odometry:
    """Base link in the world: (3,) m and (x, y, z, w); its linear velocity in its own axes, (3,), m/s."""

    time: float
    position: Array
    quaternion: Array
    velocity: Array


class Stream:
    """Messages of one sensor: which are used, and how many never came.

    Attributes:
        count: messages that were used.
        lost: that are missing between those.
        refused: that could not be used.
        fault: why the last of these could not; empty if none.
    """

    def __init__(self, period: float) -> None:
        self._period = round(1e9 * period)
        self._stamp: int | None = None
        self.count = self.lost = self.refused = 0
        self.fault = ""

    def admits(self, stamp: int) -> bool:
        """Whether a message of this stamp, ns, is newer than the last; counts the gap before it."""
        gap = None if self._stamp is None else stamp - self._stamp
        if gap is not None and -LEAP_BACK < gap <= 0:
            self.refuse("a message is no newer than the one before")
            return False
        if gap is not None and gap > GAP * self._period:
            self.lost += round(gap / self._period) - 1
        self._stamp = stamp
        self.count += 1
        return True

    def refuse(self, why: str) -> None:
        """A message cannot be used."""
        self.refused += 1
        self.fault = why


class Sensors:
    """The last of what each sensor said.

    Args:
        transport: that it comes over.
        joint_names: order of the joints.
        clock: seconds that only go on.
        period: at which messages come, s: longer gaps between their stamps are losses.
        base: name of the base link, if it is not `base_link`.

    Attributes:
        joints, imu, odometry: the last of each; None if none has come.
        streams: of the three, by topic.
    """

    def __init__(
        self,
        transport: Transport,
        joint_names: Sequence[str],
        clock: Callable[[], float],
        period: float,
        base: str = BASE_LINK,
    ) -> None:
        self._frames = (*BASE_FRAMES, base)
        self._names, self._clock = tuple(joint_names), clock
        self._order: tuple[tuple[str, ...], list[int]] = ((), [])
        self.joints: Joints | None = None
        self.imu: Imu | None = None
        self.odometry: Odometry | None = None
        self.streams = {topic.name: Stream(period) for topic in SENSORS}
        for topic, take in (
            (JOINT_STATES, self._take_joints),
            (IMU, self._take_imu),
            (ODOMETRY, self._take_odometry),
        ):
            transport.subscribe(topic, self._guarded(topic, take))

    @property
    def age(self) -> float:
        """Of the oldest of the three, s; infinite until all have come."""
        times = [
            each.time if each is not None else -np.inf for each in (self.joints, self.imu, self.odometry)
        ]
        return float(self._clock() - min(times))

    def silent(self, timeout: float) -> str:
        """Which of them say nothing of now, and why that is if it is known; empty if all speak.

        Args:
            timeout: after which one is silent, s.
        """
        found = []
        last = {JOINT_STATES: self.joints, IMU: self.imu, ODOMETRY: self.odometry}
        for topic, each in last.items():
            if each is None or self._clock() - each.time > timeout:
                stream = self.streams[topic.name]
                why = f" that can be used: {stream.fault}" if stream.fault else ""
                found.append(f"nothing comes on {topic.name}{why}")
        return "; ".join(found)

    @property
    def lost(self) -> int:
        """Messages that never came."""
        return sum(stream.lost for stream in self.streams.values())

    def _guarded(self, topic: Topic, take: Callable[[Fields], str]) -> Callable[[bytes], None]:
        """A subscriber that nothing in a message can end."""
        stream = self.streams[topic.name]

        def receive(data: bytes) -> None:
            try:
                message = decoded(topic, data)
                stamp = nanoseconds_of(message["header"])
            except Exception:  # of bytes from anywhere: what the decoder meets
                stream.refuse("a message is not of its type")
                return
            if why := take(message) if stream.admits(stamp) else "":
                stream.refuse(why)

        return receive

    def _take_joints(self, message: Fields) -> str:
        names = tuple(message["name"])
        if names != self._order[0]:
            missing = [name for name in self._names if name not in names]
            if missing:
                return f"the joint {missing[0]} is not among those that are measured"
            place = {name: k for k, name in enumerate(names)}
            self._order = names, [place[name] for name in self._names]
        order = self._order[1]
        rows = []
        for part in ("position", "velocity", "effort"):
            values = message[part]
            if len(values) != len(names):
                return f"{part} has {len(values)} numbers for {len(names)} joints"
            rows.append(np.asarray(values, dtype=float)[order])
        if not all(np.isfinite(row).all() for row in rows):
            return "a joint's value is not a number"
        self.joints = Joints(self._clock(), *rows)
        return ""

    def _take_imu(self, message: Fields) -> str:
        quaternion, omega = _quaternion(message["orientation"]), _vector(message["angular_velocity"])
        if quaternion is None or not np.isfinite(omega).all():
            return "the IMU says no orientation, or what is not a number"
        if (frame := message["header"]["frame_id"]) not in self._frames:
            return f"the IMU speaks in the frame {frame!r}, which must be that of the base link"
        self.imu = Imu(self._clock(), quaternion, omega)
        return ""

    def _take_odometry(self, message: Fields) -> str:
        pose, twist = message["pose"]["pose"], message["twist"]["twist"]
        quaternion = _quaternion(pose["orientation"])
        place, velocity = _vector(pose["position"]), _vector(twist["linear"])
        if quaternion is None or not (np.isfinite(place).all() and np.isfinite(velocity).all()):
            return "the odometry says no orientation, or what is not a number"
        if (frame := message["child_frame_id"]) not in self._frames:
            return f"the odometry is that of the frame {frame!r}, which must be the base link"
        self.odometry = Odometry(self._clock(), place, quaternion, velocity)
        return ""


def _vector(v: Fields) -> Array:
    return np.array([v["x"], v["y"], v["z"]], dtype=float)


def _quaternion(q: Fields) -> Array | None:
    """(x, y, z, w) of length 1; None if it is none."""
    values = np.array([q["x"], q["y"], q["z"], q["w"]], dtype=float)
    norm = float(np.linalg.norm(values))
    return values / norm if norm > NORM_MIN and np.isfinite(norm) else None
