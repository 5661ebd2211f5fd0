"""What the feet of a robot can do in a gait: which of them roll where, and how far steps carry the others.

A foot that stands and does not roll into some direction falls behind the robot in it, and makes up for that
by its steps. In a stance it may go from one side of its box to the other: that bounds the velocity.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.mpc.gaits import GAITS, CyclicGait
from rollgait.robot.robot import FootKind, Robot

Array = NDArray[np.float64]
Twist = tuple[float, float, float]
"""Forward, lateral (m/s, base-yaw frame), yaw rate (rad/s)."""

STRIDE_SHARE: Final = 0.6
"""Share of a foot's box that strides use where feet step one by one; the rest is for the sway of the CoM."""
STRIDE_SHARE_OF_PAIRS: Final = 0.85
"""The same where feet step in pairs, so that the CoM hardly sways."""
FELT: Final = 1e-6
"""Speed across from which on a foot counts as dragged, m/s for 1 m/s or 1 rad/s."""
STEPPING: Final = "trot"
"""Gait of a robot whose feet cannot do what is asked for by rolling."""


class Footwork:
    """The feet of a robot, and what they can do.

    Args:
        robot: whose feet.
    """

    def __init__(self, robot: Robot) -> None:
        legs = robot.leg_list
        kinds = self._kinds = [leg.foot for leg in legs]
        self.steers: NDArray[np.bool_] = np.array([kind == "steerable" for kind in kinds])
        """Which feet are wheels that steer, (4,)."""
        self._is_fixed = np.array([kind == "fixed" for kind in kinds])
        self._pinned = {locked: _pinned(kinds, locked) for locked in (False, True)}
        stance = robot.stance[:, :2]
        heading = np.array([leg.heading for leg in legs])
        along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        self._axes: Array = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)
        one_by_one = np.zeros((4, 2, 3))
        one_by_one[:, 0, 0] = one_by_one[:, 1, 1] = 1.0
        one_by_one[:, 0, 2], one_by_one[:, 1, 2] = -stance[:, 1], stance[:, 0]
        self._velocity: Array = self._axes @ one_by_one
        boxes = robot.foot_boxes()[:, :, :2]
        side = np.minimum(-boxes[:, 0], boxes[:, 1])
        self._side: Array = (side[:, None] / np.maximum(np.abs(self._axes), FELT)).min(axis=2)

    def pinned(self, locked: bool = False) -> NDArray[np.bool_]:
        """Along which of its axes, heading and left of it, a foot that stands does not move, (4, 2)."""
        return self._pinned[locked]

    def dragged(self, velocity: Array, locked: bool = False) -> Array:
        """The part of the velocities of nominal places that feet which stand cannot follow.

        Args:
            velocity: base-yaw frame, (2, 4, n), m/s.
            locked: whether wheels stand still.

        Returns:
            The same shape.
        """
        pinned = self.pinned(locked)
        if not pinned.any():
            return np.zeros_like(velocity)
        own = np.einsum("lad,dln->lan", self._axes, velocity) * pinned[..., None]
        return np.asarray(np.einsum("lad,lan->dln", self._axes, own))

    def rolling(self, velocity: Array) -> Array:
        """Of velocities (2, 4, n) of wheels that do not steer the part along their headings, (4, n), m/s.

        0 for all other feet.
        """
        if not self._is_fixed.any():
            return np.zeros(velocity.shape[1:])
        return np.asarray(np.einsum("ld,dln->ln", self._axes[:, 0], velocity) * self._is_fixed[:, None])

    def within(self, gait: CyclicGait, twist: Sequence[float]) -> Twist:
        """A velocity cut to what the feet can follow: what takes steps is less, what rolls stays."""
        held = self.pinned(gait.wheels == "locked")
        if not held.any():
            return twist[0], twist[1], twist[2]
        pinned = held[..., None] * self._velocity
        takes_steps = np.abs(pinned).max(axis=(0, 1)) > FELT
        wanted = np.array(twist, dtype=float)
        speed = np.abs(pinned @ wanted)
        stance = gait.period - gait.swing
        room = 2.0 * stride_share(gait) * self._side / stance if gait.swing > 0.0 else np.zeros((4, 2))
        moving = speed > FELT * max(1.0, float(np.abs(wanted).max()))
        share = float(np.min(room[moving] / speed[moving], initial=1.0))
        forward, lateral, turn = np.where(takes_steps, share * wanted, wanted).tolist()
        return forward, lateral, turn

    def note(self, gait: CyclicGait, twist: Sequence[float]) -> str:
        """What of a velocity the feet cannot follow in a gait, in words; empty if they can."""
        if gait.brakes:
            return ""
        cut = self.within(gait, twist)
        names = ("forward", "m/s"), ("lateral", "m/s"), ("turn rate", "rad/s")
        parts = [
            f"{name} {before:.3g} {unit} is cut to {after:.3g} {unit}"
            for (name, unit), before, after in zip(names, twist, cut, strict=True)
            if abs(after - before) > 1e-3 * abs(before)
        ]
        if not parts:
            return ""
        return f"{'; '.join(parts)}: {self._why(gait)}"

    def _why(self, gait: CyclicGait) -> str:
        kinds = set(self._kinds)
        feet = "point feet do not roll" if "point" in kinds else "wheels that do not steer only roll ahead"
        if gait.wheels == "locked" and "point" not in kinds:
            feet = "locked wheels stand still"
        if gait.swing > 0.0:
            return f"{feet}, and steps of the gait {gait.name!r} carry no farther"
        return f"{feet}; a gait that steps can do more ({', '.join(_steps())})"

    def fitting(self, twists: ArrayLike) -> str:
        """The gait to begin with: rolling where all of these velocities (n, 3) can be rolled, else steps."""
        drive = GAITS["drive"]
        return STEPPING if any(self.note(drive, twist) for twist in np.atleast_2d(twists)) else drive.name


def _pinned(kinds: Sequence[FootKind], locked: bool) -> NDArray[np.bool_]:
    held = {"steerable": (locked, locked), "fixed": (locked, True), "point": (True, True)}
    return np.array([held[kind] for kind in kinds])


def stride_share(gait: CyclicGait) -> float:
    """Share of a foot's box that the strides of a gait use."""
    return STRIDE_SHARE if len(set(gait.phase)) == len(gait.phase) else STRIDE_SHARE_OF_PAIRS


def _steps() -> list[str]:
    return [gait.name for gait in GAITS.values() if gait.swing > 0.0]
