"""What friction does to a fixed wheel that may slip sideways (`legs.*.slip_max`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.context import PlanContext
from rollgait.ocp.friction import pyramid
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import INPUT, Data, FootConstraint, Mask, Phase, Place, Role
from rollgait.scenario.scenario import Scenario

KINETIC = 0.9
"""Share of the friction that forces may use which a sliding wheel has: sliding friction is less than that of
sticking, and the rest is room for the wheel's turn within an interval, in which its force is constant."""
SOFT = 0.1
"""ε in parts of `slip_max`: below it friction grows with the slip, as that of a creeping tyre does."""


class Skid(FootConstraint):
    """f_lat = −0.9 μ f_z s / √(s² + ε²): Coulomb's law, made smooth, in the middle of the interval.

    s is the slip to the left, f_lat the force to the left. An equality, as an inequality f_lat s ≤ 0 would
    let wheels slide for nothing. In the last interval wheels stand, and stick: any force inside the cone.
    """

    name = "skid"
    role = Role.PHYSICS
    sentence = "friction would have to be another than that of a wheel that slips sideways"
    places = INPUT
    phase = Phase.STANCE
    lower = upper = 0.0
    unit = "N"
    by_weight = True

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        legs = range(len(scenario.body.leg_list))
        return (cls(),) if any(scenario.slip_max(leg) for leg in legs) else ()

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.scenario.slip_max(leg) > 0.0

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        # a foot without slip has no rows, but its numbers are read
        soft = SOFT * (problem.scenario.slip_max(leg) or 1.0)
        return {"mu": KINETIC * pyramid(problem, leg)[None, :], "soft": [soft]}

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        stance = super().holds(problem, place, leg).copy()
        stance[-1] = False
        return stance

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        along, left, normal = foot.force_contact[0], foot.force_contact[1], foot.force_contact[2]
        to_the_middle = 0.5 * x.body.interval * foot.heading_rate
        s = foot.lateral_speed
        share = s / ca.sqrt(s**2 + d.soft**2)
        force: ca.SX = left - to_the_middle * along + d.mu * normal * share
        return force
