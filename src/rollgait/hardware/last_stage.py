"""The last stage before the drives: bounds on what joints are told, whatever came from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.config import Config, Positive
from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.tracking.follower import JointTarget

Array = NDArray[np.float64]

COMMAND_AGE_MAX: Final = 0.1
"""Drives that have not heard anything for so long hold, s."""
PERIODS_MAX: Final = 2.0
"""However long nothing was told, a joint steps no farther than in so many periods; in one at least: who is
late once is early then."""


class StageLimits(Config):
    """Bounds of the last stage, as shares of what the URDF allows."""

    speed_share: Positive = 1.0
    """Of a joint's velocity limit: bounds the step from one target to the next."""
    torque_share: Positive = 1.0
    """Of a joint's effort limit: bounds the feed-forward torque."""
    lead: Positive = 0.3
    """Farthest that a target may be from where the joint is measured, rad (or m); wheels excepted: what pulls
    at a joint that is stuck grows no further."""
    speed_max: Positive = 10.0
    """Of joints whose limit is not known, rad/s."""
    torque_max: Positive = 50.0
    """Of joints whose limit is not known, N m."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """What `StageLimits` mean for a robot's joints, each (n_j,)."""

    position_low: Array
    position_high: Array
    speed: Array
    torque: Array
    lead: Array


def bounds_of(model: WholeBodyModel, limits: StageLimits | None = None) -> Bounds:
    """The bounds of a robot's joints."""
    given = limits or StageLimits()
    wheels = [leg.wheel - BASE_V for leg in model.legs if leg.wheel is not None]
    lead = np.full(len(model.joint_names), given.lead)
    lead[wheels] = np.inf
    speed = np.where(np.isfinite(model.velocity_max), model.velocity_max, given.speed_max)
    torque = np.where(np.isfinite(model.effort_max), model.effort_max, given.torque_max)
    return Bounds(
        model.position_lower,
        model.position_upper,
        given.speed_share * speed,
        given.torque_share * torque,
        lead,
    )


class LastStage:
    """Cuts targets to the bounds. Knows nothing of who made them.

    Args:
        names: of the n_j joints, for what it says.
        bounds: of them.
        period: at which targets come, s.

    Attributes:
        cut: which bound cut the last target, and at which joint; empty if none did.
        cuts: how many targets were cut.
    """

    def __init__(self, names: Sequence[str], bounds: Bounds, period: float) -> None:
        self._names, self._bounds, self._period = tuple(names), bounds, period
        self.cuts = 0
        self.cut = ""
        self._last: JointTarget | None = None
        self._at = 0.0

    def begin(self, position: Array, time: float) -> None:
        """Where the joints are now, (n_j,), rad: the first target begins there."""
        still = np.zeros_like(position)
        self._last, self._at = JointTarget(position.copy(), still, still), time

    def release(self) -> None:
        """Nothing is told any more; it must `begin` anew."""
        self._last = None

    @property
    def target(self) -> JointTarget:
        """The last that was let through. Raises `RuntimeError` before `begin`."""
        if self._last is None:
            raise RuntimeError("the last stage has not begun: nobody said where the joints are")
        return self._last

    def hold(self, time: float) -> JointTarget:
        """The joints where they were told to be, at rest, with the torques that carry them."""
        last = self.target
        self._last, self._at = JointTarget(last.position, np.zeros_like(last.position), last.torque), time
        return self._last

    def let_through(self, target: JointTarget, measured: Array | None, time: float) -> JointTarget:
        """A target within the bounds, as near to the given one as they allow.

        Args:
            target: what is wanted.
            measured: where the joints are, (n_j,), rad; None if that is not known.
            time: s.
        """
        last, bounds = self.target, self._bounds
        parts = (target.position, target.velocity, target.torque)
        if not all(part.shape == last.position.shape and np.isfinite(part).all() for part in parts):
            self.cut, self.cuts = "what is no number", self.cuts + 1
            return self.hold(time)
        elapsed = min(max(time - self._at, self._period), PERIODS_MAX * self._period)
        self.cut = ""
        position = np.clip(target.position, bounds.position_low, bounds.position_high)
        self._say("range", position, target.position)
        if measured is not None:
            led = np.clip(position, measured - bounds.lead, measured + bounds.lead)
            self._say("lead", led, position)
            position = led
        reach = bounds.speed * elapsed
        near = np.clip(position, last.position - reach, last.position + reach)
        self._say("step", near, position)
        velocity = np.clip(target.velocity, -bounds.speed, bounds.speed)
        torque = np.clip(target.torque, -bounds.torque, bounds.torque)
        self._say("torque", torque, target.torque)
        self.cuts += bool(self.cut)
        self._last, self._at = JointTarget(near, velocity, torque), time
        return self._last

    def _say(self, bound: str, cut: Array, wanted: Array) -> None:
        gap = np.abs(cut - wanted)
        if not self.cut and gap.max(initial=0.0) > 1e-9:
            self.cut = f"{bound} of {self._names[int(gap.argmax())]}"
