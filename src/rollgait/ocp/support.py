"""Steps that a robot can carry out: the CoM stays over the feet that stand while one of four swings.

A contact force may pull nothing, and that alone keeps a rigid body from falling on paper even where its CoM
is outside the feet that stand, as long as it moves fast enough. A disturbed robot cannot count on that. With
two feet down there is no support to stay in; trot and pace are not constrained.

Which three feet stand is data, so that one kernel serves all schedules. Only x and y count: on uneven ground
the support is that of the feet seen from above.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Instant
from rollgait.ocp.term import Constraint, Data, Limits, Mask, Place
from rollgait.robot.robot import GRAVITY, LEG_NAMES
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]

AROUND: Final = tuple(LEG_NAMES.index(name) for name in ("FL", "HL", "HR", "FR"))
"""The legs counterclockwise, seen from above: the support lies to the left of each edge."""
CORNERS: Final = 3
"""Of the support while one foot swings."""
_SQUARE_MIN: Final = 1e-4
"""m²: smooths the height of the CoM where it is not above the feet (infeasible, but a solver may try it)."""


class _Support(Constraint):
    """A point stays inside the triangle of the three feet that stand, this far from each of its edges."""

    places = frozenset({Place.NODE, Place.POINTS, Place.INTERVAL_END})
    left_out_at_first = True
    unit = "m"

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        return () if scenario.value_of("bounds", cls.name) is None else (cls(),)

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"corners": corners(problem.schedule)}

    def limits(self, problem: PlanContext) -> Limits:
        return problem.bound(self.name), np.inf

    def holds(self, problem: PlanContext, place: Place) -> Mask:
        """The end of an interval is the node after it, but where other feet stand there or wheels roll."""
        here = one_swings(problem.schedule)
        if place is not Place.INTERVAL_END or self._reads_wheels(problem):
            return here
        contact = problem.schedule.contact
        changes = np.append((contact[:, 1:] != contact[:, :-1]).any(axis=0), True)
        return np.asarray(here & changes)

    def _reads_wheels(self, problem: PlanContext) -> bool:
        """Whether the point depends on the speeds of wheels, which jump from one interval to the next."""
        return False

    def expression(self, x: Instant, d: Data) -> ca.SX:
        feet = ca.horzcat(*(foot.p[:2] for foot in x.feet))
        p = feet @ ca.reshape(d.corners, len(LEG_NAMES), CORNERS)
        point = self.point(x, d)
        following = [*range(1, CORNERS), 0]
        rows = []
        for i, j in enumerate(following):
            edge, to_point = p[:, j] - p[:, i], point - p[:, i]
            across = edge[0] * to_point[1] - edge[1] * to_point[0]
            rows.append(across / ca.norm_2(edge))
        return ca.SX(ca.vertcat(*rows))

    def point(self, x: Instant, d: Data) -> ca.SX:
        """What has to stay inside, (2,), world, m."""
        raise NotImplementedError


class ComMargin(_Support):
    """The CoM is inside the support of the standing feet by `com_margin` (executable)."""

    name = "com_margin"
    sentence = "the CoM would have to come nearer to the edge of the feet that stand, or leave them"
    curvature = 1.0  # m/s²: of a CoM that turns back at an edge; the judge's tolerance covers 0.8 more

    def point(self, x: Instant, d: Data) -> ca.SX:
        return x.r[:2]


class CaptureMargin(_Support):
    """The capture point is inside the support of the standing feet by `capture_margin` (executable).

    It is where the CoM would come to rest over its support, r + (ṙ − v) √(z / g), with v the common velocity
    of the wheels that stand and z the height of the CoM above them.
    """

    name = "capture_margin"
    sentence = "the CoM would have to move too fast to come to rest over the feet that stand"
    curvature = 1.0  # m/s²: the CoM's own; its velocity changes evenly within an interval

    def _reads_wheels(self, problem: PlanContext) -> bool:
        return any(leg.foot != "point" for leg in problem.robot.leg_list)

    def point(self, x: Instant, d: Data) -> ca.SX:
        stands = ca.sum2(ca.reshape(d.corners, len(LEG_NAMES), CORNERS)) / CORNERS
        height = x.r[2] - sum(stands[foot.index] * foot.p[2] for foot in x.feet)
        height = 0.5 * (height + ca.sqrt(height**2 + _SQUARE_MIN))
        common = sum((stands[foot.index] * foot.velocity[:2] for foot in x.feet), start=ca.SX.zeros(2))
        return ca.SX(x.r[:2] + (x.dr[:2] - common) * ca.sqrt(height / GRAVITY))


def one_swings(schedule: ContactSchedule) -> Mask:
    """In which intervals exactly one foot is in the air, (N,)."""
    return np.asarray(schedule.contact.sum(axis=0) == CORNERS)


def corners(schedule: ContactSchedule) -> Array:
    """`corners_of` of a schedule."""
    return corners_of(schedule.contact)


def corners_of(contact: Mask) -> Array:
    """Which foot is at which corner of the support in each interval, (12, N): 1 at 4 · corner + leg, else 0.

    Counterclockwise. Where not exactly one foot swings it is the triangle of some three feet.

    Args:
        contact: which foot stands, (4, N).
    """
    swinging = np.where(contact.sum(axis=0) == CORNERS, (~contact).argmax(axis=0), 0)
    return np.asarray(_TRIANGLES[swinging].T)


def _triangle_without(leg: int) -> Array:
    """Which foot is at which corner where one foot swings, (12,)."""
    result = np.zeros((CORNERS, len(LEG_NAMES)))
    result[range(CORNERS), [other for other in AROUND if other != leg]] = 1.0
    return result.ravel()


_TRIANGLES = np.array([_triangle_without(leg) for leg in range(len(LEG_NAMES))])
