"""The ground as numbers: what each foot has under it in each interval.

Height above the ground, ζ, is what a problem reckons with: it is 0 in stance whatever the ground, so that
heights in stance leave the problem as constants. Where the surface of one interval is not that of the next
(a foot in the air goes from one level to another) ζ changes by their difference, a `leave`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import MODEL_SIZE, FootGround
from rollgait.terrain.convex_region import SIDES
from rollgait.terrain.references import BaseReference

Array = NDArray[np.float64]
Index = NDArray[np.intp]

FEET: Final = 4
LEAVE_SIZE: Final = 6
"""Numbers of a difference of two models about the first one's place: h, gx, gy, Hxx, Hxy, Hyy."""
PARAMETERS: Final[Mapping[str, int]] = {
    "ground_model": FEET * MODEL_SIZE,
    "ground_leave": FEET * LEAVE_SIZE,
    "contact_slope": FEET * 2,
    "foot_radius": FEET,
    "base_tilt": 4,
}
"""Names and sizes of what a stage must know of ground that is not flat."""


@dataclass(frozen=True)
class SwingOver:
    """How high a swing goes.

    Attributes:
        leg, lift_off, touch_down: as of `SwingPhase`.
        before, top, after: height of the ground where the foot leaves it, of what it goes over, and where it
            lands, m.
        over: whether there is something to go over: else the foot keeps to its local ground.
        clearance: z_fly above it, m.
    """

    leg: int
    lift_off: int
    touch_down: int
    before: float
    top: float
    after: float
    over: bool
    clearance: float


@dataclass(frozen=True, eq=False)
class Footing:
    """The ground under the feet of a motion with N intervals. Legs in the order FL, FR, HL, HR.

    Attributes:
        model: surface of the lowest rim point, `LocalModel.numbers()`, (4, N, 8).
        leave: model less that of the next interval, about the first one's place, (4, N, 6); 0 in stance.
        contact_slope: gradient where a foot stands, (4, N, 2); 0 in swing.
        friction: μ, (4, N).
        A, b: half-planes A p ≤ b in which the lowest rim point stays, (4, N, 8, 2) and (4, N, 8); rows of
            zeros where there are fewer.
        floor: least height above the model at the beginning of an interval and after it, (4, N, 2), m.
        swings: how high each swing goes.
        base: mean ground under the feet, pitch and roll wanted of the base, at the N + 1 nodes, (N + 1, 3).
        radius: R of the wheels or of the balls of point feet, (4,), m.
        is_flat: one level plane, the same μ everywhere.
        is_curved: a stance has ground whose slope changes: another motion would have other models.
        is_sloped: a stance has a slope: another motion may have other heights, and another tilt of the base.
    """

    model: Array
    leave: Array
    contact_slope: Array
    friction: Array
    A: Array
    b: Array
    floor: Array
    swings: tuple[SwingOver, ...]
    base: Array
    radius: Array
    is_flat: bool = False
    is_curved: bool = False
    is_sloped: bool = False

    @classmethod
    def flat(cls, level: float, friction: float, count: int) -> Footing:
        """Level ground.

        Args:
            level: its height, m.
            friction: μ.
            count: N.
        """
        model = np.zeros((FEET, count, MODEL_SIZE))
        model[..., 2] = level
        base = np.zeros((count + 1, 3))
        base[:, 0] = level
        return cls(
            model=model,
            leave=np.zeros((FEET, count, LEAVE_SIZE)),
            contact_slope=np.zeros((FEET, count, 2)),
            friction=np.full((FEET, count), friction),
            A=np.zeros((FEET, count, SIDES, 2)),
            b=np.ones((FEET, count, SIDES)),
            floor=np.zeros((FEET, count, 2)),
            swings=(),
            base=base,
            radius=np.zeros(FEET),
            is_flat=True,
        )

    @property
    def count(self) -> int:
        """N."""
        return int(self.model.shape[1])

    @property
    def level(self) -> float:
        """Height of flat ground, m."""
        return float(self.model[0, 0, 2])

    @property
    def end(self) -> BaseReference:
        """What the ground asks of the base at the end."""
        ground, pitch, roll = self.base[-1]
        return BaseReference(float(ground), float(pitch), float(roll))

    @property
    def may_differ(self) -> bool:
        """Whether another motion might have other ground under its feet than level planes."""
        return self.is_curved or self.is_sloped

    def foot_ground(self, leg: int, intervals: Index) -> FootGround:
        """The ground of a foot in some intervals (n,), for arithmetic with arrays (n,)."""
        model, slope = self.model[leg, intervals].T, self.contact_slope[leg, intervals].T
        return FootGround(list(model), list(slope), self.radius[leg])

    def height(self, intervals: Index, xy: Array) -> Array:
        """z of the ground under places (n, 4, 2) of the feet, each row in its interval (n,): (n, 4), m."""
        columns = [self.foot_ground(leg, intervals).height(xy[:, leg].T) for leg in range(FEET)]
        return np.stack(columns, axis=-1)

    def climb(self, intervals: Index, xy: Array, velocity: Array) -> Array:
        """How fast the ground rises under feet at places that move, both (n, 4, 2): (n, 4), m/s."""
        columns = []
        for leg in range(FEET):
            gx, gy = self.foot_ground(leg, intervals).slope(xy[:, leg].T)
            columns.append(gx * velocity[:, leg, 0] + gy * velocity[:, leg, 1])
        return np.stack(columns, axis=-1)

    def deviation(self, origin: Index, other: Footing, contact: NDArray[np.bool_], xy: Array) -> float:
        """By how much the heights of another footing differ from these where feet stand, at most, m.

        Args:
            origin: in which interval of this one each of the other lies, (M,).
            other: of the same contacts, with M intervals.
            contact: which foot stands in which interval of the other, (4, M).
            xy: places of the feet at its nodes, (M + 1, 4, 2), m.
        """
        intervals = np.arange(other.count)
        apart = [
            np.abs(self.height(origin, places) - other.height(intervals, places))
            for places in (xy[:-1], xy[1:])
        ]
        return float(np.where(contact.T, np.maximum(*apart), 0.0).max())

    def tilt_deviation(self, times: Array, other: Footing, other_times: Array) -> float:
        """By how much another footing differs in the tilts that it wants of the base, at most, rad.

        Args:
            times: of the N + 1 nodes, s.
            other, other_times: another one with M intervals, and the times of its nodes, s.
        """
        tilts = [np.interp(other_times, times, column) for column in self.base[:, 1:].T]
        return float(np.abs(np.stack(tilts, axis=-1) - other.base[:, 1:]).max())

    def numbers(self) -> Array:
        """What a trajectory must keep: model and slope of the contact, (N, 4, 10)."""
        return np.concatenate([self.model, self.contact_slope], axis=-1).swapaxes(0, 1).copy()

    def parameters(self) -> dict[str, Array]:
        """The parameters of a stage, by the names of `PARAMETERS`, (size, N)."""

        def stacked(values: Array) -> Array:
            return np.asarray(np.moveaxis(values, 1, -1).reshape(-1, self.count))

        return {
            "ground_model": stacked(self.model),
            "ground_leave": stacked(self.leave),
            "contact_slope": stacked(self.contact_slope),
            "foot_radius": np.repeat(self.radius[:, None], self.count, axis=1),
            "base_tilt": np.hstack([self.base[:-1, 1:], self.base[1:, 1:]]).T,
        }
