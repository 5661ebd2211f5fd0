"""Who is above: what is asked for, whether anybody is there, and whether the robot may move at all."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Final

from rollgait.errors import RollgaitError
from rollgait.hardware.measured import NORM_MIN
from rollgait.hardware.topics import COMMANDS, ENABLE, GOAL, HEIGHTS, VELOCITY, decoded, types
from rollgait.hardware.transports.transport import Transport
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.ros.messages import Fields
from rollgait.ros.topics import Topic
from rollgait.terrain.map_file import Source
from rollgait.terrain.readers.grid_map import placed
from rollgait.terrain.terrain import Terrain

COMMAND_TIMEOUT: Final = 0.3
"""Who has said nothing for so long is gone, s."""
STAND: Final = "stand"
"""The gait in which nothing moves."""

Note = Callable[[str], None]


class Operator:
    """Commands as they come, and a dead man's switch.

    Any message of an operator says that somebody is there. The last of velocity and goal counts. `/enable`
    is a switch: only its way from false to true starts anything.

    Args:
        transport: where commands come from.
        clock: seconds that only go on.
        note: hears what could not be used.
        timeout: s.
        takes: topics that are read.
    """

    def __init__(
        self,
        transport: Transport,
        clock: Callable[[], float],
        note: Note,
        timeout: float = COMMAND_TIMEOUT,
        takes: Collection[Topic] = COMMANDS,
    ) -> None:
        self._clock, self._note, self._timeout = clock, note, timeout
        self._heard = -math.inf
        self._switch: bool | None = None
        self._edges: deque[bool] = deque(maxlen=8)
        self._command: VelocityCommand | PoseCommand = VelocityCommand()
        self._refused = ""
        self._map: bytes | None = None
        for topic, take in (
            (VELOCITY, self._take_velocity),
            (GOAL, self._take_goal),
            (ENABLE, self._take_enable),
        ):
            if topic in takes:
                transport.subscribe(topic, self._guarded(topic, take))
        if HEIGHTS in takes:
            transport.subscribe(HEIGHTS, self._take_map)

    @property
    def silent(self) -> bool:
        """Whether nobody is there."""
        return self._clock() - self._heard > self._timeout

    @property
    def presence(self) -> str:
        """The same, for a person."""
        return "silent" if self.silent else "there"

    def command(self, gait: str | None) -> VelocityCommand | PoseCommand:
        """What is asked for now, in a gait; to stand if nobody is there."""
        if self.silent:
            return VelocityCommand(gait=STAND)
        return self._command.model_copy(update={"gait": gait})

    def edge(self) -> bool | None:
        """The next turn of the switch that nobody has asked for yet; None if there was none."""
        return self._edges.popleft() if self._edges else None

    def leave(self) -> None:
        """Whoever gave commands has said good-bye: as if silent for long."""
        self._heard, self._command = -math.inf, VelocityCommand()

    def ground(self) -> Terrain | None:
        """The ground of the last map that nobody has asked for yet; None if no usable one came."""
        data, self._map = self._map, None
        if data is None:
            return None
        try:
            return terrain_from(data)
        except RollgaitError as error:
            self._refuse(HEIGHTS.name, str(error))
        except Exception:  # of bytes from anywhere: what the decoder meets
            self._refuse(HEIGHTS.name, "is not a message of its type")
        return None

    def forget(self) -> None:
        """What was asked for counts no more; it must be asked for anew."""
        self._command = VelocityCommand()

    def _guarded(self, topic: Topic, take: Callable[[Fields], None]) -> Callable[[bytes], None]:
        """A subscriber that nothing in a message can end."""

        def receive(data: bytes) -> None:
            try:
                take(decoded(topic, data))
            except RollgaitError as error:
                self._refuse(topic.name, str(error))
            except Exception:  # of bytes from anywhere: what the decoder meets
                self._refuse(topic.name, "is not a message of its type")

        return receive

    def _refuse(self, topic: str, why: str) -> None:
        """Notes it, once for each kind."""
        sentence = f"a message on {topic} was refused: {why}"
        if sentence != self._refused:
            self._note(sentence)
        self._refused = sentence

    def _take_velocity(self, message: Fields) -> None:
        linear, angular = message["linear"], message["angular"]
        self._command = VelocityCommand(forward=linear["x"], lateral=linear["y"], turn_rate=angular["z"])
        self._heard = self._clock()

    def _take_goal(self, message: Fields) -> None:
        place = message["pose"]["position"]
        x, y, z, w = (message["pose"]["orientation"][axis] for axis in "xyzw")
        if not math.hypot(x, y, z, w) > NORM_MIN:
            self._refuse(GOAL.name, "its orientation is no quaternion")
            return
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y**2 + z**2))
        self._command = PoseCommand(x=place["x"], y=place["y"], yaw_deg=math.degrees(yaw))
        self._heard = self._clock()

    def _take_enable(self, message: Fields) -> None:
        switch = bool(message["data"])
        if self._switch is not None and switch != self._switch:
            self._edges.append(switch)
        self._switch = switch
        if switch:
            self._heard = self._clock()

    def _take_map(self, data: bytes) -> None:
        self._map = data  # its noise is taken out when it is needed: that takes its time


def terrain_from(data: bytes) -> Terrain:
    """The ground of a GridMap: its layer `elevation`, without its noise.

    Raises:
        FileError, InputError: it has no such layer, or contradicts itself.
    """
    source = Source(Path(HEIGHTS.name), HEIGHTS.name)
    raw = placed(source, types().deserialize_cdr(data, HEIGHTS.type))
    origin = (0.0, 0.0) if raw.origin is None else raw.origin
    return Terrain.from_map(raw.values, raw.resolution or 0.0, origin, yaw=raw.yaw, noise="auto")
