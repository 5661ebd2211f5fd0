"""The costs of the controller: terms like the planner's, about references that move.

Their numbers are filled in by name before each solve (`mpc/filling.py`), so `data` gives only their sizes.
What the planner demands of states, the controller asks for by a cost beyond the limits: a disturbed robot
may be outside, and an interior-point method has no answer then. `Soft` makes such a cost of any constraint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any, Final

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.errors import InputError
from rollgait.ocp.context import PlanContext
from rollgait.ocp.costs import Acceleration, Tilt
from rollgait.ocp.instant import Instant
from rollgait.ocp.limb import JointSteering, Reach
from rollgait.ocp.limits import Box, sides
from rollgait.ocp.support import ComMargin, corners_of
from rollgait.ocp.term import Constraint, Cost, Data, FootConstraint, Limits, Place, Term
from rollgait.robot.robot import LEG_NAMES

HINGE: Final = 1e-3
"""Width over which the cost beyond a limit sets in, m or rad: without it its slope would have a corner."""
OPEN: Final = 10.0
"""Limit in place of none, in any unit that occurs here: far enough not to be felt."""


class PoseReference(Cost):
    """‖(x, y, yaw) − reference‖²; `pose` is (r, yaw)."""

    name = "goal"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"pose": np.zeros(4)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(ca.vertcat(x.r[:2] - d.pose[:2], x.theta[0] - d.pose[3]))


class HeightReference(Cost):
    """(z − reference)² of the CoM."""

    name = "height"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"z": np.zeros(1)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(x.r[2] - d.z)


class VelocityReference(Cost):
    """‖ṙ − reference‖²."""

    name = "velocity"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"rate": np.zeros(3)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(x.dr - d.rate)


class RotationReference(Cost):
    """‖θ̇ − (yaw rate of the reference, 0, 0)‖²."""

    name = "rotation"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"yaw_rate": np.zeros(1)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(x.dtheta - ca.vertcat(d.yaw_rate, 0, 0))


class FeetInPlane(Cost):
    """Σ‖Rzᵀ (p_i − r) − p̄_i‖² in the ground plane: heights are known."""

    name = "feet"

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(ca.vertcat(*(foot.p_body[:2] - x.body.stance[:2, foot.index] for foot in x.feet)))


class HeadingReference(Cost):
    """Σ (σ_i − reference)² of the steerable wheels."""

    name = "heading"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"sigma": np.zeros(4)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        steered = [foot.heading - d.sigma[foot.index] for foot in x.feet if foot.kind == "steerable"]
        return ca.SX(ca.vertcat(*steered))


class KeepOff(Cost):
    """Σ by what normal · p_i ≥ offset is missed, squared: feet keep off edges of the ground."""

    name = "foothold"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"normal": np.zeros(8), "offset": np.zeros(4), "counts": np.zeros(4)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        parts = []
        for i, foot in enumerate(x.feet):
            missing = d.offset[i] - ca.dot(d.normal[2 * i : 2 * i + 2], foot.p[:2])
            parts.append(d.counts[i] * _hinge(missing))
        return ca.SX(ca.vertcat(*parts))


class OverFeet(Cost):
    """Σ by what the CoM is nearer than a margin to an edge of the three feet that stand, squared."""

    name = "support"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        corners = corners_of(np.ones((len(LEG_NAMES), 1), dtype=bool))
        return {"corners": corners, "margin": np.zeros(1), "counts": np.zeros(1)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(d.counts * _hinge(d.margin - ComMargin().expression(x, d)))


class Soft(Cost):
    """A constraint as a cost: the square of what its limits are exceeded by, leg by leg.

    Raises:
        InputError: the constraint is about the end of the horizon, which a controller never reaches.
    """

    name = "soft"

    def __init__(self, term: Constraint | FootConstraint, weight: float) -> None:
        super().__init__(weight)
        if not term.places & {Place.NODE, Place.INTERVAL_END}:
            rule = "is a constraint of the end or of heights, which a controller does not have"
            raise InputError("terms", term.name, rule)
        self.term = term
        self.name = f"soft_{term.name}"  # type: ignore[misc]
        self.structure = (type(term).__module__, type(term).__qualname__, term.structure)

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        result: dict[str, ArrayLike] = {}
        for leg in self._legs(problem):
            own, limits, holds = self._numbers(problem, leg)
            name = "" if leg is None else f"_{LEG_NAMES[leg]}"
            result |= {f"{key}{name}": value for key, value in own.items()}
            low, high = (np.atleast_2d(np.asarray(limit, dtype=float)) for limit in limits)
            rows, low, high = (
                max(low.shape[0], high.shape[0]),
                np.clip(low, -OPEN, OPEN),
                np.clip(high, -OPEN, OPEN),
            )
            result[f"low{name}"], result[f"high{name}"] = (
                np.broadcast_to(limit, (rows, limit.shape[1])) for limit in (low, high)
            )
            result[f"holds{name}"] = holds[None, :].astype(float)
        return result

    def residual(self, x: Instant, d: Data) -> ca.SX:
        parts = [ca.SX(0, 1)]
        names = vars(d)
        for leg in (None, *range(len(LEG_NAMES))):
            suffix = "" if leg is None else f"_{LEG_NAMES[leg]}"
            if f"low{suffix}" not in names:
                continue
            own = {key.removesuffix(suffix): value for key, value in names.items() if key.endswith(suffix)}
            data = SimpleNamespace(**own)
            if isinstance(self.term, FootConstraint):
                assert leg is not None
                value = self.term.expression(x, x.feet[leg], data)
            else:
                value = self.term.expression(x, data)
            parts += [data.holds * _hinge(data.low - value), data.holds * _hinge(value - data.high)]
        return ca.SX(ca.vertcat(*parts))

    def _legs(self, problem: PlanContext) -> Sequence[int | None]:
        if isinstance(self.term, FootConstraint):
            return [leg for leg in range(len(LEG_NAMES)) if self.term.applies(problem, leg)]
        return [None]

    def _numbers(self, problem: PlanContext, leg: int | None) -> tuple[Mapping[str, ArrayLike], Limits, Any]:
        term = self.term
        place = Place.NODE if Place.NODE in term.places else Place.INTERVAL_END
        if isinstance(term, FootConstraint):
            assert leg is not None
            return term.data(problem, leg), term.limits(problem, leg), term.holds(problem, place, leg)
        return term.data(problem), term.limits(problem), term.holds(problem, place)


class BoxInPlane(Box):
    """The box in the ground plane: heights are known."""

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        low, high = sides(problem, leg)
        return low[:2], high[:2]

    def expression(self, x: Instant, foot: Any, d: Data) -> ca.SX:
        return ca.SX(super().expression(x, foot, d)[:2])


def standard_costs(workspace: bool, terrain: bool = False) -> list[Cost]:
    """The controller's costs of motion; their weights are filled in later.

    Args:
        workspace: whether feet keep where the legs can follow.
        terrain: whether the ground has edges to keep off.
    """
    costs: list[Cost] = [
        PoseReference(),
        HeightReference(),
        Tilt(),
        VelocityReference(),
        RotationReference(),
        FeetInPlane(),
        HeadingReference(),
        OverFeet(),
        Acceleration(),
    ]
    return [*costs, *(WORKSPACE if workspace else ()), *((KeepOff(),) if terrain else ())]


WORKSPACE: Final = tuple(Soft(term, 1.0) for term in (BoxInPlane(), Reach(), JointSteering()))
"""What keeps the feet where the legs can follow; they share one weight."""


def as_costs(terms: Sequence[Term], weight: float) -> list[Cost]:
    """A user's terms for a controller: constraints become costs beyond their limits.

    Args:
        terms: costs and constraints.
        weight: of the constraints.

    Raises:
        InputError: a constraint that a controller cannot have, or two terms of one name.
    """
    costs = [term if isinstance(term, Cost) else Soft(term, weight) for term in terms]
    names = [cost.name for cost in standard_costs(workspace=True, terrain=True)] + [
        cost.name for cost in costs
    ]
    for cost in costs:
        if names.count(cost.name) > 1:
            raise InputError("terms", cost.name, "is the name of two terms; names must differ")
    return costs


def _hinge(x: ca.SX) -> ca.SX:
    """x where it is positive, else nothing; smooth."""
    return ca.SX(0.5 * (x + ca.sqrt(x * x + HINGE**2)))
