"""Constraints of contact: what a foot does on the ground, and how it leaves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import ENDS, INPUT, Data, FootConstraint, Limits, Mask, Phase, Place, Role
from rollgait.scenario.scenario import Scenario


class StanceHeight(FootConstraint):
    """ζ = 0 and ζ̇ = 0 in stance: at every node that touches the ground, and at the height points.

    ζ is the height above the ground, whatever that is: all of these fix single variables, so that they leave
    the problem instead of filling it with rows of which some would be redundant (redundant rows break
    solvers).
    """

    name = "stance_height"
    role = Role.PHYSICS
    places = frozenset({Place.NODE, Place.HEIGHT_POINTS, Place.TERMINAL})
    phase = Phase.STANCE
    lower = upper = 0.0
    unit = "m"

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        schedule = problem.schedule
        if place is Place.NODE:
            return np.asarray(schedule.node_contact[leg, :-1])
        return np.asarray(schedule.contact[leg])

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        if foot.height_point is None:
            return foot.height
        return ca.vertcat(foot.height, foot.lift_rate[foot.height_point])


class StanceMotion(FootConstraint):
    """A point foot stands still in stance, a fixed wheel does not slip sideways. (A steerable one cannot.)

    A fixed wheel with a `slip_max` slips no faster than that, and not at all in the last interval.
    """

    name = "stance_motion"
    role = Role.PHYSICS
    places = INPUT
    phase = Phase.STANCE
    lower = upper = 0.0
    unit = "m/s"

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot != "steerable"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        slip = np.full((1, problem.schedule.intervals), problem.scenario.slip_max(leg))
        slip[:, -1] = 0.0
        return -slip, slip

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.motion if foot.kind == "point" else foot.lateral_speed


class SwingForce(FootConstraint):
    """f_i = 0 in swing."""

    name = "swing_force"
    role = Role.PHYSICS
    places = INPUT
    phase = Phase.SWING
    lower = upper = 0.0
    unit = "N"
    by_weight = True

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.force


MODEL_RESERVE: Final = 2.0e-3
"""So much higher than asked point feet swing over ground that is not flat, m: in mid-swing the model of the
ground where they land, if that is beside a bend, was found to be too low by 1.8 mm."""


class Clearance(FootConstraint):
    """ζ = z_fly at the node nearest to the middle of the swing, above what the foot goes over, if it does."""

    name = "clearance"
    role = Role.PHYSICS
    places = INPUT
    unit = "m"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        scenario = problem.scenario
        is_model = scenario.ground.kind != "flat" and problem.robot.leg_list[leg].foot == "point"
        reserve = MODEL_RESERVE if is_model else 0.0
        z_fly = np.full((1, problem.schedule.intervals), scenario.clearance + reserve)
        for swing in problem.footing.swings:
            if swing.leg == leg and swing.over:
                z_fly[0, swing.lift_off : swing.touch_down] = scenario.clearance_over
        return z_fly, z_fly

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        middle = np.zeros(problem.schedule.intervals, dtype=bool)
        swings = (swing for swing in problem.schedule.swings() if swing.leg == leg)
        middle[[swing.middle for swing in swings if swing.middle is not None]] = True
        return middle

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.height


class Foothold(FootConstraint):
    """A p ≤ b: a foot that is on the ground, or near it, stays in its region, away from edges.

    In the air it is in the region that it leaves until it is above what it goes over, and in the one where it
    lands from then on: that is kept at both ends of an interval, so it holds between them.
    """

    name = "foothold"
    role = Role.PHYSICS
    sentence = "the foot would have to stand on an edge, or on ground where none can"
    places = ENDS
    upper = 0.0
    unit = "m"

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        return (cls(),) if scenario.ground.kind != "flat" else ()

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        footing = problem.footing
        return {
            "normals": np.moveaxis(footing.A[leg], 0, -1).reshape(-1, footing.count),
            "offsets": footing.b[leg].T,
        }

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        A, b = problem.footing.A[leg], problem.footing.b[leg]
        restricts = A.any(axis=(1, 2))
        if place is Place.NODE:
            return np.asarray(restricts)
        # the next interval's node has these very rows where its region is the same
        same = (A[:-1] == A[1:]).all(axis=(1, 2)) & (b[:-1] == b[1:]).all(axis=1)
        return np.asarray(restricts & ~np.append(same, False))

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        sides = d.offsets.numel()
        return ca.SX(ca.mtimes(ca.reshape(d.normals, 2, sides).T, foot.p[:2]) - d.offsets)


class AboveGround(FootConstraint):
    """p_z ≥ terrain in swing, everywhere, and above what the foot goes over.

    A parabola stays above the ground if its three Bézier points do: the height at both nodes and, between,
    that at which the first tangent ends, ζ + h ζ̇ / 2.
    """

    name = "ground"
    role = Role.PHYSICS
    places = INPUT
    phase = Phase.SWING
    unit = "m"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        return problem.footing.floor[leg].T, np.inf

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return ca.vertcat(foot.height, foot.height + 0.5 * x.body.interval * foot.height_rate)


class TouchdownSpeed(FootConstraint):
    """|ṗz| ≤ touchdown_speed at the end of the swing: the foot is set down, not dropped (executable)."""

    name = "touchdown_speed"
    keys = ("touchdown_speed",)
    sentence = "the foot would have to be set down faster"
    bound = ("touchdown_speed", "faster touch-downs")
    left_out_at_first = True
    places = frozenset({Place.INTERVAL_END})
    unit = "m/s"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limit = problem.bound(self.name)
        return -limit, limit

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        contact = problem.schedule.contact[leg]
        return np.asarray(~contact & np.concatenate([contact[1:], [True]]))

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.height_rate


class TouchdownDrift(FootConstraint):
    """|ṗx|, |ṗy| ≤ touchdown_drift of a point foot in the last interval of a swing.

    (Wheels roll on.)
    """

    name = "touchdown_drift"
    keys = ("touchdown_drift",)
    sentence = "the foot would have to be set down while it moves faster over the ground"
    bound = ("touchdown_drift", "faster touch-downs")
    left_out_at_first = True
    places = INPUT
    unit = "m/s"

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot == "point"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limit = problem.bound(self.name)
        return -limit, limit

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        return TouchdownSpeed().holds(problem, place, leg)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.motion
