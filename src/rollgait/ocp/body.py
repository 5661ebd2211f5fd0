"""Trunk, hips and thighs stay off the ground, where that is not flat and stands up to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.dynamics.rotations import R_z
from rollgait.footing.beneath import NUMBERS, ROWS
from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import Data, FootConstraint, Limits, Mask, Place
from rollgait.scenario.scenario import Scenario


class BodyClearance(FootConstraint):
    """n · q ≥ b: points of trunk, hips and thighs stay above the ground or beside what is too high.

    A point goes with the base by the share w, with the foot by the rest: q = w r + R (w c) + (1 − w) p +
    Rz (1 − w) (c − p̄). Which points come near the ground, and on which side of what they stay, is known
    before (`footing/beneath.py`); where none does there is no such row.
    """

    name = "body_clearance"
    keys = ("body_clearance",)
    sentence = "trunk, hip or thigh would have to touch the ground, or come nearer to it"
    places = frozenset({Place.NODE, Place.TERMINAL})
    left_out_at_first = True
    unit = "m"

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        if scenario.ground.kind == "flat" or not scenario.body.underside.known:
            return ()
        return () if scenario.value_of("bounds", cls.name) is None else (cls(),)

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return bool(problem.beneath.near[leg].any())

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        numbers = problem.beneath.numbers[leg]
        return {"points": numbers.reshape(len(numbers), -1).T}

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        return problem.beneath.bound[leg].T, np.inf

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        return np.asarray(problem.beneath.near[leg])

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        R, upright = x.R_world_base, R_z(x.theta[0])
        rows = []
        for numbers in ca.vertsplit(d.points, NUMBERS):
            w, with_base, with_foot, n = numbers[0], numbers[1:4], numbers[4:7], numbers[7:]
            q = w * x.r + R @ with_base + (ca.SX(1) - w) * foot.p + upright @ with_foot
            rows.append(ca.dot(n, q))
        assert len(rows) == ROWS
        return ca.SX(ca.vertcat(*rows))
