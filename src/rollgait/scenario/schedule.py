"""The contact schedule: a gait put on the mesh of the horizon. Frozen data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.gait import BaseGait

MIN_SWING_INTERVALS = 2
"""A swing needs a node inside it, where the foot is at its full height."""

MAX_INTERVALS = 10_000
"""More than any planner here can hold in memory: a slip of the pen, not a wish."""


@dataclass(frozen=True)
class SwingPhase:
    """One swing on the mesh: `leg` is in the air in the intervals lift_off … touch_down − 1 (nodes)."""

    leg: int
    lift_off: int
    touch_down: int

    @property
    def middle(self) -> int:
        """The node nearest to the middle of the swing."""
        return (self.lift_off + self.touch_down) // 2


@dataclass(frozen=True, eq=False)
class ContactSchedule:
    """Which foot is on the ground in which interval.

    Attributes:
        contact: shape (4, N), bool; legs in the order FL, FR, HL, HR.
        interval: length h of an interval, s.
    """

    contact: NDArray[np.bool_]
    interval: float

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ContactSchedule):
            return NotImplemented
        return self.interval == other.interval and np.array_equal(self.contact, other.contact)

    def __hash__(self) -> int:
        return hash((self.contact.tobytes(), self.interval))

    @property
    def intervals(self) -> int:
        """N."""
        return int(self.contact.shape[1])

    @property
    def horizon(self) -> float:
        """T = N h, s."""
        return self.intervals * self.interval

    @property
    def node_times(self) -> NDArray[np.float64]:
        """Times of the N + 1 nodes, s."""
        return np.asarray(np.arange(self.intervals + 1) * self.interval, dtype=np.float64)

    @property
    def node_contact(self) -> NDArray[np.bool_]:
        """Which foot touches the ground at a node, in the interval before or after it, shape (4, N + 1)."""
        c = self.contact
        return np.hstack([c[:, :1], c[:, :-1] | c[:, 1:], c[:, -1:]])

    def swings(self) -> Iterator[SwingPhase]:
        """All swings, leg by leg in the order of time."""
        for leg in range(len(LEG_NAMES)):
            padded = np.concatenate([[True], self.contact[leg], [True]]).astype(int)
            edges = np.diff(padded)
            for begin, end in zip(np.flatnonzero(edges == -1), np.flatnonzero(edges == 1), strict=True):
                yield SwingPhase(leg, int(begin), int(end))


def intervals_of(horizon: float, interval: float) -> int:
    """N: the horizon is cut into equal intervals of about the asked length (exactly so if it divides)."""
    return max(1, round(horizon / interval))


def put_on_mesh(gait: BaseGait, horizon: float, interval: float) -> ContactSchedule:
    """The gait on the mesh: every lift-off and touch-down moves to the nearest node.

    Raises:
        InputError: the mesh is too fine or too coarse, a swing leaves the horizon or is too short for the
            mesh, or all feet are in the air at once.
    """
    if interval > horizon:
        raise InputError("interval", interval, f"must not be longer than the horizon of {horizon} s")
    if horizon / interval > MAX_INTERVALS:
        rule = f"must cut the horizon of {horizon} s into at most {MAX_INTERVALS} intervals"
        raise InputError("interval", interval, rule)
    count = intervals_of(horizon, interval)
    step = horizon / count
    contact = np.ones((len(LEG_NAMES), count), dtype=bool)
    try:
        swings = gait.swings(horizon)
    except ValueError as error:
        raise InputError("gait", gait.model_dump().get("kind"), str(error)) from None
    for leg, name in enumerate(LEG_NAMES):
        for begin, end in swings[name]:
            first, last = round(begin / step), round(end / step)
            if end > horizon + 1e-9 or last > count:
                raise InputError(
                    f"gait.{name}", [begin, end], f"must touch down within the horizon of {horizon} s"
                )
            if last - first < MIN_SWING_INTERVALS:
                raise InputError(
                    f"gait.{name}",
                    [begin, end],
                    f"must last at least {MIN_SWING_INTERVALS} intervals of {step:.4g} s",
                )
            contact[leg, first:last] = False
    flying = np.flatnonzero(~contact.any(axis=0))
    if flying.size:
        raise InputError(
            "gait",
            f"t = {flying[0] * step:.3g} s",
            "has all four feet in the air: at least one must be on the ground",
        )
    return ContactSchedule(contact, step)
