"""Steps of a motion that it may do without, by geometry alone: its feet could roll there, or stand on.

Looked at is the motion with its base as it is. A wheel that can be steered rolls where the ground between
lift-off and touch-down is free; on flat ground it steps for the sake of its steering. A fixed wheel rolls on
abreast of its nominal place, a point foot stands on; both must stay in their boxes until their next step, and
be near their nominal places where there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from rollgait.discover.steps import Step, Steps, steps_of
from rollgait.footing.carried import SETTLED, WIDER_REACH, used_boxes, utility_of
from rollgait.footing.footing import Array
from rollgait.footing.on_terrain import regions_for
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.robot.robot import LEG_NAMES
from rollgait.terrain.regions import Regions

LOOK: Final = 0.01
"""Distance of the places between lift-off and touch-down at which the ground is looked up, m."""


def needless_steps(plan: Plan) -> Steps:
    """The steps without which the feet of a plan may get to its end; feet that step together are one step.

    Args:
        plan: a motion that was found, with its steps.
    """
    steps = steps_of(plan.scenario)
    if not steps:
        return ()
    judge = _Judge(plan)
    needless = {(leg, step) for leg in range(len(LEG_NAMES)) for step in judge.needless(leg, steps)}
    return tuple(s for s in steps if all((LEG_NAMES.index(name), s) in needless for name in s.legs))


class _Judge:
    def __init__(self, plan: Plan) -> None:
        self.scenario, self.robot = plan.scenario, plan.scenario.body
        self.times = plan.schedule.node_times
        self.motion: Samples = plan.sample(self.times)
        self.boxes = used_boxes(self.robot, self.scenario.bounds.box, WIDER_REACH)
        self.is_flat = self.scenario.ground.kind == "flat"
        self.regions: Sequence[Regions] = () if self.is_flat else regions_for(self.scenario)

    def needless(self, leg: int, steps: Steps) -> list[Step]:
        """Those of a foot, the first ones first: where one is left out, the foot has been there longer."""
        own = [step for step in steps if LEG_NAMES[leg] in step.legs]
        following = [*(self._node(step.begin) for step in own[1:]), len(self.times) - 1]
        result, since = list[Step](), -1
        for step, until in zip(own, following, strict=False):
            lift_off = self._node(step.begin)
            since = lift_off if since < 0 else since
            if self._does_without(leg, since, self._node(step.end), until, is_last=step is own[-1]):
                result.append(step)
            else:
                since = -1
        return result

    def _node(self, time: float) -> int:
        return int(np.argmin(np.abs(self.times - time)))

    def _does_without(self, leg: int, since: int, touch_down: int, until: int, is_last: bool) -> bool:
        """Whether a foot that has been where it was at one node may stay on the ground up to another."""
        kind, feet = self.robot.leg_list[leg].foot, self.motion.foot_position[:, leg, :2]
        if kind == "steerable":
            return not self.is_flat and self._is_free(leg, _between(feet[since], feet[touch_down]))
        own = slice(since, until + 1)
        offsets = self._standing(leg, own) if kind == "point" else self._rolling(leg, own)
        utility = utility_of(offsets, self.boxes[leg])
        if utility.min() < 0.0 or (is_last and utility[-1] < SETTLED):
            return False
        return kind == "point" or self.is_flat or self._is_free(leg, self._seen_from_world(leg, offsets, own))

    def _standing(self, leg: int, own: slice) -> Array:
        """Places in its box, (n, 2), m, base-yaw axes, of a foot that stays where it is at first."""
        x, y = (self.motion.foot_position[own.start, leg, :2] - self.motion.com_position[own, :2]).T
        c, s = self._yaw(own)
        return np.stack([c * x + s * y, c * y - s * x], axis=-1) - self.robot.stance[leg, :2]

    def _rolling(self, leg: int, own: slice) -> Array:
        """The same of a fixed wheel that rolls from there, in the end abreast of its nominal place."""
        heading = self.robot.leg_list[leg].heading
        normal = np.array([-np.sin(heading), np.cos(heading)])
        first = float(self._standing(leg, slice(own.start, own.start + 1))[0] @ normal)
        nominal = self._seen_from_world(leg, np.zeros((1, 2)), own)
        ways = np.diff(nominal, axis=0)
        yaw = self.motion.euler[own, 0] + heading
        middle = 0.5 * (yaw[1:] + yaw[:-1])
        across = ways[:, 1] * np.cos(middle) - ways[:, 0] * np.sin(middle)
        return np.asarray((first - np.append(0.0, np.cumsum(across)))[:, None] * normal)

    def _seen_from_world(self, leg: int, offsets: Array, own: slice) -> Array:
        x, y = (self.robot.stance[leg, :2] + offsets).T
        c, s = self._yaw(own)
        turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)
        return np.asarray(self.motion.com_position[own, :2] + turned)

    def _yaw(self, own: slice) -> tuple[Array, Array]:
        yaw = self.motion.euler[own, 0]
        return np.cos(yaw), np.sin(yaw)

    def _is_free(self, leg: int, places: Array) -> bool:
        """Whether all places lie on one piece of ground that the foot can roll over."""
        labels = self.regions[leg].label(places)
        return bool(labels[0] >= 0 and (labels == labels[0]).all())


def _between(a: Array, b: Array) -> Array:
    count = max(2, 1 + int(np.ceil(float(np.linalg.norm(b - a)) / LOOK)))
    return np.asarray(a + np.linspace(0.0, 1.0, count)[:, None] * (b - a))
