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
from rollgait.ocp.term import INPUT, Data, FootConstraint, Limits, Mask, Phase, Place, Role
from rollgait.scenario.scenario import Scenario

KINETIC = 0.9
"""Share of the friction that forces may use which a sliding wheel has: sliding friction is less than that of
sticking, and the rest is room for the wheel's turn within an interval, in which its force is constant."""
SOFT = 0.1
"""ε in parts of `slip_max`: below it friction grows with the slip, as that of a creeping tyre does."""
ROUND = 0.005
"""How smoothly the room that the force along the heading leaves ends, in parts of the squared cone."""

BAND = 0.02
"""By how much the law may be missed, in parts of sliding friction: solvers need room inside a constraint."""
TINY = 1e-8
"""Of the squared weight: keeps derivatives of roots finite where there is no room, or no normal force."""


class Skid(FootConstraint):
    """f_lat = −√((0.9 μ f_z)² − f_long²) s / √(s² + ε²): Coulomb's law, made smooth, mid-interval.

    s is the slip to the left, f_lat the force to the left. A wheel that slides sideways has all of its
    friction against its slip; as its drive decides how far it also spins, any part of that may be along the
    heading, and the rest is across. It may be missed by a narrow band, not be passed on one side: f_lat s ≤ 0
    alone would let wheels slide for nothing. In the last interval wheels stand, and stick: any force inside
    the cone.
    """

    name = "skid"
    role = Role.PHYSICS
    sentence = "friction would have to be another than that of a wheel that slips sideways"
    places = INPUT
    phase = Phase.STANCE
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
        return {
            "mu": KINETIC * pyramid(problem, leg)[None, :],
            "soft": [soft],
            "weight": [problem.robot.weight],
        }

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        return 0.0, np.inf

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        stance = super().holds(problem, place, leg).copy()
        stance[-1] = False
        return stance

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        along, left, normal = foot.force_contact[0], foot.force_contact[1], foot.force_contact[2]
        turn = 0.5 * x.body.interval * foot.heading_rate
        along, left = along + turn * left, left - turn * along
        s, cone = foot.lateral_speed, d.mu * normal
        room = cone**2 - along**2
        tiny = TINY * d.weight**2
        positive = 0.5 * (room + ca.sqrt(room**2 + (ROUND * cone**2) ** 2 + tiny**2) + tiny)
        law = left + ca.sqrt(positive) * s / ca.sqrt(s**2 + d.soft**2)
        band = BAND * cone
        rows: ca.SX = ca.vertcat(band - law, band + law, cone - along, cone + along)
        return rows
