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
ANYWHERE: Final = (1.0, 1.0, 1.0)
"""A twist of which nothing can be left out: m/s and rad/s."""
SLIGHT: Final = 0.02
"""Speed of a foot below which a robot does not get anywhere, in lengths of its body per second."""
SWAY: Final = 0.02
"""Least way that all feet have to either side, in heights of the robot, for the body to sway over steps."""
ABILITIES: Final = ("go ahead", "go sideways", "turn")
"""What each part of a twist is, in words."""


_ONLY_AHEAD: Final = "wheels that do not steer only roll ahead"


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
        up_down = robot.foot_boxes()[:, :, 2]
        self._lowest, self._highest = -float(up_down[:, 1].min()), -float(up_down[:, 0].max())
        self._side: Array = (side[:, None] / np.maximum(np.abs(self._axes), FELT)).min(axis=2)
        self._least_way = side.min(axis=0)
        self._sways = bool(self._least_way[1] >= SWAY * robot.height)
        slight = SLIGHT * float(np.ptp(stance[:, 0]))
        self._slight = np.array([slight, slight, slight / float(np.linalg.norm(stance, axis=1).max())])

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
        feet = "point feet do not roll" if "point" in kinds else _ONLY_AHEAD
        if gait.wheels == "locked" and "point" not in kinds:
            feet = "locked wheels stand still"
        if gait.swing > 0.0:
            return f"{feet}, and steps of the gait {gait.name!r} carry no farther"
        more = [name for name, other in GAITS.items() if self.carried(other).swing > 0.0]
        return f"{feet}; a gait that steps can do more ({', '.join(more)})" if more else feet

    def fitting(self, twists: ArrayLike) -> str:
        """The gait to begin with: rolling where all of these velocities (n, 3) can be rolled, else steps.

        Steps that would carry the robot no farther than rolling does are not taken.
        """
        drive, steps = GAITS["drive"], GAITS[STEPPING]
        is_rolled = not any(self.note(drive, twist) for twist in np.atleast_2d(twists))
        return drive.name if is_rolled or self.able(steps) == self.able(drive) else steps.name

    def carried(self, gait: CyclicGait) -> CyclicGait:
        """A gait, or one without steps in its place where the feet that stand would not carry the robot.

        While a foot is in the air the body sways over those that stand, and who tips is caught by a foot
        farther out. Legs that only move ahead and back, over feet that do not slip sideways, can do neither.
        """
        if gait.swing == 0.0 or self._sways:
            return gait
        return GAITS["stand" if gait.wheels == "locked" else "drive"]

    def within_height(self, change: float) -> float:
        """A change of the height of the CoM, m, cut to what the legs allow while all feet stand."""
        return float(min(max(change, self._lowest), self._highest))

    def able(self, gait: CyclicGait) -> tuple[bool, bool, bool]:
        """Whether the robot can go ahead, go sideways and turn in a gait, so that it is seen to."""
        largest = (self.within(gait, tuple(row)) for row in np.diag(ANYWHERE))
        ahead, aside, turn = (np.abs(np.sum(list(largest), axis=0)) > self._slight).tolist()
        return ahead, aside, turn

    def unfit(self) -> str:
        """What the robot can do in no gait, in one sentence; empty if it can do everything."""
        gaits = [self.carried(gait) for gait in GAITS.values() if not gait.brakes]
        able = np.any([self.able(gait) for gait in gaits], axis=0)
        if able.all():
            return ""
        lacking = " or ".join(name for name, can in zip(ABILITIES, able, strict=True) if not can)
        x, y = (f"{1e3 * way:.0f} mm" for way in self._least_way)
        feet = "point feet do not roll" if "point" in self._kinds else _ONLY_AHEAD
        return (
            f"the robot cannot {lacking} in any gait: {feet}, and legs reach {x} ahead or back and {y} aside"
        )


def _pinned(kinds: Sequence[FootKind], locked: bool) -> NDArray[np.bool_]:
    held = {"steerable": (locked, locked), "fixed": (locked, True), "point": (True, True)}
    return np.array([held[kind] for kind in kinds])


def stride_share(gait: CyclicGait) -> float:
    """Share of a foot's box that the strides of a gait use."""
    return STRIDE_SHARE if len(set(gait.phase)) == len(gait.phase) else STRIDE_SHARE_OF_PAIRS
