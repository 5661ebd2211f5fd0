"""The contact schedule: a gait put on a mesh of the horizon. Frozen data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.gait import BaseGait
from rollgait.scenario.mesh import BORDER, MAX_INTERVALS, Mesh

MIN_SWING_INTERVALS = 2
"""A swing needs a node inside it, where the foot is at its full height."""
STANDING = (0.0, 0.0, 0.0, 0.0)
"""No foot has left the ground before t = 0."""
MIDDLE_AHEAD = 0.1
"""A foot that is in the air at t = 0 need not get to its full height in less, s."""


@dataclass(frozen=True)
class SwingPhase:
    """One swing on the mesh.

    Attributes:
        leg: which foot swings, 0 … 3.
        lift_off, touch_down: nodes; the foot is in the air in the intervals lift_off … touch_down − 1.
        middle: the node nearest in time to the middle of the swing, of two the earlier; None of a swing that
            has begun before t = 0 if that is over, or too near.
        begun: for how long the foot is in the air at t = 0, s.
    """

    leg: int
    lift_off: int
    touch_down: int
    middle: int | None
    begun: float = 0.0


@dataclass(frozen=True, eq=False)
class ContactSchedule:
    """Which foot is on the ground in which interval.

    Attributes:
        contact: shape (4, N), bool; legs in the order FL, FR, HL, HR.
        mesh: the N intervals.
        begun: for how long each foot is in the air at t = 0, s; 0 if it stands, or lifts off just then.

    Raises:
        InputError: `contact` has another shape.
    """

    contact: NDArray[np.bool_]
    mesh: Mesh
    begun: tuple[float, float, float, float] = STANDING

    def __post_init__(self) -> None:
        if self.contact.shape != (wanted := (len(LEG_NAMES), self.mesh.intervals)):
            rule = f"must have the shape {wanted}: four legs and the intervals of the mesh"
            raise InputError("contact", self.contact.shape, rule)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ContactSchedule):
            return NotImplemented
        same = self.mesh == other.mesh and self.begun == other.begun
        return same and np.array_equal(self.contact, other.contact)

    def __hash__(self) -> int:
        return hash((self.contact.tobytes(), self.mesh, self.begun))

    @property
    def intervals(self) -> int:
        """N."""
        return self.mesh.intervals

    @property
    def horizon(self) -> float:
        """T, s."""
        return self.mesh.horizon

    @property
    def lengths(self) -> NDArray[np.float64]:
        """Lengths of the intervals, shape (N,), s."""
        return self.mesh.lengths

    @property
    def node_times(self) -> NDArray[np.float64]:
        """Times of the N + 1 nodes, s."""
        return self.mesh.times

    @property
    def node_contact(self) -> NDArray[np.bool_]:
        """Which foot touches the ground at a node, in the interval before or after it, shape (4, N + 1)."""
        c = self.contact
        return np.hstack([c[:, :1], c[:, :-1] | c[:, 1:], c[:, -1:]])

    @property
    def changes(self) -> NDArray[np.bool_]:
        """Before which intervals a foot lifts off or touches down, shape (N,)."""
        c = self.contact
        return np.append(False, (c[:, 1:] != c[:, :-1]).any(axis=0))

    def swings(self) -> Iterator[SwingPhase]:
        """All swings, leg by leg in the order of time."""
        for leg in range(len(LEG_NAMES)):
            padded = np.concatenate([[True], self.contact[leg], [True]]).astype(int)
            edges = np.diff(padded)
            for begin, end in zip(np.flatnonzero(edges == -1), np.flatnonzero(edges == 1), strict=True):
                begun = self.begun[leg] if begin == 0 else 0.0
                middle = self._middle_node(int(begin), int(end), begun)
                yield SwingPhase(leg, int(begin), int(end), middle, begun)

    def _middle_node(self, begin: int, end: int, begun: float) -> int | None:
        times = self.node_times[begin : end + 1]
        distance = np.abs(times - 0.5 * (times[0] - begun + times[-1]))
        tie = BORDER * (times[-1] - times[0])  # two nodes as near as each other, but for round-off
        middle = begin + int(np.argmax(distance <= distance.min() + tie))
        too_late = begun > 0.0 and not MIDDLE_AHEAD <= self.node_times[middle] < times[-1]
        return None if too_late else middle

    def refined(self, which: ArrayLike, parts: ArrayLike = 2) -> ContactSchedule:
        """The same schedule with some intervals cut into equal parts, as `Mesh.refined` does."""
        return self._on(self.mesh.refined(which, parts))

    def cut_at(self, times: ArrayLike) -> ContactSchedule:
        """The same schedule with further nodes at times (n,) within the horizon, s."""
        return self._on(self.mesh.cut_at(times))

    def _on(self, mesh: Mesh) -> ContactSchedule:
        return ContactSchedule(self.contact[:, self.mesh.interval_at(mesh.middles)], mesh, self.begun)


def intervals_of(horizon: float, interval: float) -> int:
    """N: the horizon is cut into equal intervals of about the asked length (exactly so if it divides)."""
    return max(1, round(horizon / interval))


def put_on_mesh(gait: BaseGait, horizon: float, interval: float) -> ContactSchedule:
    """The gait on the mesh: every lift-off and touch-down moves to the nearest node.

    Raises:
        InputError: the mesh is too fine or too coarse, a swing leaves the horizon or is too short for the
            mesh, or all feet are in the air at once.
    """
    nodes = getattr(gait, "nodes", None)
    if nodes is not None:
        return _put_on_nodes(gait, horizon, np.array(nodes))
    if interval > horizon:
        raise InputError("interval", interval, f"must not be longer than the horizon of {horizon} s")
    if horizon / interval > MAX_INTERVALS:
        rule = f"must cut the horizon of {horizon} s into at most {MAX_INTERVALS} intervals"
        raise InputError("interval", interval, rule)
    count = intervals_of(horizon, interval)
    return _put_on(gait, horizon, Mesh.equal(horizon, count))


def _put_on_nodes(gait: BaseGait, horizon: float, nodes: NDArray[np.float64]) -> ContactSchedule:
    if abs(nodes[-1] - horizon) > BORDER * horizon:
        raise InputError("gait.nodes", float(nodes[-1]), f"must end at the horizon of {horizon} s")
    return _put_on(gait, horizon, Mesh(np.diff(nodes)))


def _put_on(gait: BaseGait, horizon: float, mesh: Mesh) -> ContactSchedule:
    count, times = mesh.intervals, mesh.times
    contact, begun = np.ones((len(LEG_NAMES), count), dtype=bool), [0.0] * len(LEG_NAMES)
    try:
        swings = gait.swings(horizon)
    except ValueError as error:
        raise InputError("gait", gait.model_dump().get("kind"), str(error)) from None
    for leg, name in enumerate(LEG_NAMES):
        for begin, end in swings[name]:
            first, last = (_nearest(mesh, time) for time in (max(begin, 0.0), end))
            if end > horizon + 1e-9 or last > count:
                raise InputError(
                    f"gait.{name}", [begin, end], f"must touch down within the horizon of {horizon} s"
                )
            if begin < 0.0:
                begun[leg] = -begin
            if last - first < (MIN_SWING_INTERVALS if begin >= 0.0 else 1):
                raise InputError(
                    f"gait.{name}",
                    [begin, end],
                    f"must last at least {MIN_SWING_INTERVALS} intervals{_of_length(mesh)}",
                )
            contact[leg, first:last] = False
    flying = np.flatnonzero(~contact.any(axis=0))
    if flying.size:
        raise InputError(
            "gait",
            f"t = {times[flying[0]]:.3g} s",
            "has all four feet in the air: at least one must be on the ground",
        )
    fl, fr, hl, hr = begun
    return ContactSchedule(contact, mesh, (fl, fr, hl, hr))


def _nearest(mesh: Mesh, time: float) -> int:
    """Number of the node nearest to a time, of equal ones also beyond the horizon."""
    if mesh.is_equal:
        return round(time / float(mesh.lengths[0]))
    return int(np.argmin(np.abs(mesh.times - time)))


def _of_length(mesh: Mesh) -> str:
    return f" of {float(mesh.lengths[0]):.4g} s" if mesh.is_equal else ""
