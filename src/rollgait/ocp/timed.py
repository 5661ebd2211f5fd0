"""A problem whose timing is not given: how long each phase lasts is a variable, their order is not.

A *phase* is what lies between two changes of contacts or goals; its intervals have one length. What a term
says of the length of an interval it must say by a symbol here, not by a number.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field, fields, replace
from typing import Any, Final, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp import costs, friction, limits
from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Cost, Data, Limits, Term

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

PRICE_REF: Final = 10.0
"""1/s; a higher price of time than this scales the other costs down instead: solvers want moderate costs."""


@dataclass(frozen=True)
class Durations:
    """What limits the times of a problem.

    Attributes:
        first: which intervals begin a phase, (N,): there a length is chosen, the others have the one before.
        length: limits of the lengths of intervals that begin a phase, (2, N), s.
        node_time: limits of the time at the end of each interval, (2, N), s; infinite where there is none.
        clocked: which intervals belong to swings of more than one phase, (4, N): a clock times them.
        swing: limits of what that clock says at touch-down, (2,), s.
        price: of a second, in units of the cost.
        spacing: length of the intervals for which margins between nodes are reckoned, s: those of the mesh on
            which the motion is planned in the end.
    """

    first: Mask
    length: Array
    node_time: Array
    clocked: Mask
    swing: Array
    price: float
    spacing: float

    @property
    def touches_down(self) -> Mask:
        """In which intervals a swing ends that a clock times, (4, N)."""
        goes_on = np.hstack([self.clocked[:, 1:], np.zeros((len(self.clocked), 1), dtype=bool)])
        return np.asarray(self.clocked & ~goes_on)


@dataclass(frozen=True)
class TimedProblem(Problem):
    """A problem whose phases last as long as is best. Its schedule is what the times are at first."""

    durations: Durations = field(kw_only=True)
    cost_scale: float = field(default=1.0, kw_only=True)
    """By which all weights are multiplied, and the price."""

    @classmethod
    def of(cls, problem: Problem, durations: Durations) -> Self:
        """A problem with other durations than its own: its terms read lengths as variables."""
        own = {f.name: getattr(problem, f.name) for f in fields(Problem)}
        scale = min(1.0, PRICE_REF / max(durations.price, PRICE_REF))
        terms = tuple(_scaled(timed(term), scale) for term in problem.terms)
        durations = replace(durations, price=scale * durations.price)
        return cls(**own | {"terms": terms}, durations=durations, cost_scale=scale)

    @property
    def beside_nodes(self) -> Array:
        return np.full(self.schedule.intervals, self.durations.spacing)


def _scaled(term: Term, scale: float) -> Term:
    """A cost with a weight that is so many times its own."""
    if not isinstance(term, Cost) or scale == 1.0:
        return term
    other = copy(term)
    other.weight = scale * term.weight
    return other


def timed(term: Term) -> Term:
    """A term as it is where lengths of intervals are variables; most are the same."""
    kind: Any = TIMED.get(type(term))
    if kind is None:
        return term
    other = kind.__new__(kind)
    other.__dict__.update(term.__dict__)
    result: Term = other
    return result


class TimedForceChange(costs.ForceChange):
    """L_force; but where a contact changes a force jumps, and that costs what it does at h_ref.

    ‖Δf‖² / h would pay for stretching the intervals beside the jump, which changes nothing of the motion.
    """

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        counts = np.ones(problem.schedule.intervals)
        counts[0] = 0.0
        jumps = problem.schedule.changes.astype(float)
        return {"counts": counts[None, :], "jumps": jumps[None, :]}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        h_ref = costs.FORCE_INTERVAL_REF
        between = d.jumps * h_ref + (1.0 - d.jumps) * x.body.between_middles
        change = ca.vertcat(*(foot.force - foot.previous_force for foot in x.feet))
        return ca.SX(d.counts * h_ref / ca.sqrt(between * x.body.interval) * change)


class TimedLift(costs.Lift):
    """The lift has a shape; how fast it goes follows from the time that it takes."""

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        data = dict(super().data(problem))
        return data | {"rate": np.asarray(data["rate"]) * problem.schedule.lengths}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        at_speed = Data(rate=d.rate / x.body.interval, counts=d.counts)
        return super().residual(x, at_speed)


class TimedAcceleration(limits.Acceleration):
    """|v_k − v_{k−1}| / h ≤ a."""

    unit = "m/s²"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        a = self.largest(problem, leg)
        return -a, a

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return ca.SX(super().expression(x, foot, d) / x.body.between_middles)


class TimedFriction(friction.Friction):
    """Friction with the margin for wheels that turn within an interval of the mesh of the end."""

    def lengths(self, problem: PlanContext) -> Array:
        assert isinstance(problem, TimedProblem)
        return problem.beside_nodes


TIMED: Final[Mapping[type, type]] = {
    costs.ForceChange: TimedForceChange,
    costs.Lift: TimedLift,
    limits.Acceleration: TimedAcceleration,
    friction.Friction: TimedFriction,
}
"""Terms whose numbers depend on lengths of intervals, and what they are where these are variables."""
