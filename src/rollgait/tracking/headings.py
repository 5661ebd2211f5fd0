"""Headings at which wheels are held that the plan takes for point feet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.robot.urdf_model import WholeBodyModel

Array = NDArray[np.float64]


def held_headings(plan: Plan, samples: Samples, model: WholeBodyModel) -> Array:
    """Headings of all wheels, (n, 4), rad.

    Those of the plan where it has any. A wheel that is planned as a point foot is locked: in stance its
    heading stays, so that it does not scrub; in swing it turns to where the base will point at touch-down.
    """
    headings = samples.heading.copy()
    for leg, (planned, chain) in enumerate(zip(plan.robot.leg_list, model.legs, strict=True)):
        if planned.foot == "point" and chain.wheel is not None:
            headings[:, leg] = _held(plan, leg, samples.time)
    return headings


def _held(plan: Plan, leg: int, time: Array) -> Array:
    """σ of one locked wheel, (n,): constant in stance, a smooth step in each swing."""
    nodes = plan.schedule.node_times
    heading = np.full(len(time), float(plan.sample(0.0).euler[0]))
    for swing in plan.schedule.swings():
        if swing.leg != leg:
            continue
        begin, end = nodes[[swing.lift_off, swing.touch_down]]
        goal = float(plan.sample(min(end, plan.horizon)).euler[0])
        phase = np.clip((time - begin) / (end - begin), 0.0, 1.0)
        after = time > begin
        start = heading[-1]  # where the stance before this swing holds it
        heading[after] = start + (goal - start) * (3.0 * phase**2 - 2.0 * phase**3)[after]
    return heading
