"""What hands want: from joystick and keys to velocities, and nothing once the hands are gone.

Shares run from −1 to 1: forward, to the left, turning to the left.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final

from rollgait.mpc.command import VelocityCommand

DEAD_ZONE: Final = 0.12
"""Part of the way of the joystick that does nothing: a finger never rests at its very middle."""
PATIENCE: Final = 0.3
"""A browser that holds something and is silent for so long has let go, s: it speaks every 0.1 s, so that two
words may be late, and a robot that was let go of goes half as far as it would in half a second."""
KEYS: Final[Mapping[str, tuple[int, int, int]]] = {
    "w": (1, 0, 0),
    "s": (-1, 0, 0),
    "a": (0, 1, 0),
    "d": (0, -1, 0),
    "q": (0, 0, 1),
    "e": (0, 0, -1),
}
"""Forward, left and turn of each key."""


@dataclass(frozen=True)
class Wish:
    """Shares of the largest velocities, −1 … 1; (forward, lateral) lie within the unit circle."""

    forward: float = 0.0
    lateral: float = 0.0
    turn: float = 0.0

    @property
    def rests(self) -> bool:
        """Whether nothing is wanted."""
        return self == REST

    def velocity(self, speed: float, turn_rate: float, **more: Any) -> VelocityCommand:
        """The command with these largest velocities, m/s and rad/s; `more` is what else it says."""
        return VelocityCommand(
            forward=speed * self.forward,
            lateral=speed * self.lateral,
            turn_rate=turn_rate * self.turn,
            **more,
        )


REST: Final = Wish()


def wish_of(right: float, up: float, turn_right: float, keys: Collection[str] = ()) -> Wish:
    """What a joystick, a turning lever and keys want together.

    Args:
        right, up: of the joystick, −1 … 1; beyond the unit circle it is on the circle.
        turn_right: of the lever, −1 … 1.
        keys: of `KEYS` that are held; others mean nothing.
    """
    held = [KEYS[key] for key in set(keys) & KEYS.keys()]
    x, y = _alive(up, -right)
    (z,) = _alive(-turn_right)
    forward, lateral = _within_one(x + sum(key[0] for key in held), y + sum(key[1] for key in held))
    (turn,) = _within_one(z + sum(key[2] for key in held))
    return Wish(forward, lateral, turn)


def wish_from(message: Any) -> Wish:
    """What a message of the page says; what cannot be read wants nothing."""
    try:
        right, up = (float(value) for value in message["stick"])
        turn = float(message["turn"])
        keys = [str(key) for key in message["keys"]]
    except (KeyError, TypeError, ValueError):
        return REST
    return wish_of(right, up, turn, keys) if all(map(math.isfinite, (right, up, turn))) else REST


def _alive(*way: float) -> tuple[float, ...]:
    """Without the dead zone: 0 within, from there on growing evenly to 1."""
    length = math.hypot(*way)
    if length <= DEAD_ZONE:
        return (0.0,) * len(way)
    share = min(1.0, (length - DEAD_ZONE) / (1.0 - DEAD_ZONE)) / length
    return tuple(share * part for part in way)


def _within_one(*way: float) -> tuple[float, ...]:
    """In the same direction, at most 1 long; without a negative zero."""
    length = max(1.0, math.hypot(*way))
    return tuple(part / length + 0.0 for part in way)


class Hands:
    """All who hold a joystick. Who moved last has the robot; a dead man's switch for each.

    Args:
        patience: how long a silent one is believed, s.
        clock: seconds that only go on.

    Attributes:
        stops: how often somebody has pressed stop.
    """

    def __init__(self, patience: float = PATIENCE, clock: Callable[[], float] = time.monotonic) -> None:
        self._patience, self._clock = patience, clock
        self._held: dict[Any, tuple[float, Wish]] = {}
        self._stopped: set[Any] = set()
        self._lock = threading.Lock()
        self.stops = 0

    def report(self, who: Any, wish: Wish) -> None:
        """What somebody wants now."""
        with self._lock:
            if wish.rests:
                self._held.pop(who, None)
                self._stopped.discard(who)
            elif who not in self._stopped:
                self._held.pop(who, None)  # last of the dictionary: the one that moved last
                self._held[who] = self._clock(), wish

    def leave(self, who: Any) -> None:
        """Somebody is gone."""
        self.report(who, REST)

    def stop(self) -> None:
        """Nothing is wanted any more; who holds something must let go of it first."""
        with self._lock:
            self.stops += 1
            self._stopped |= self._held.keys()
            self._held.clear()

    @property
    def wish(self) -> Wish:
        """What is wanted now."""
        with self._lock:
            now = self._clock()
            fresh = [wish for at, wish in self._held.values() if now - at <= self._patience]
            return fresh[-1] if fresh else REST
