"""What a cost and a constraint are.

A term describes one instant; where it holds it says by `places` and `phase`, and the transcription does
the rest. Numbers that a term needs (limits, weights, goals) are data: `data` returns them by name, and
`expression` gets symbols of the same names. So a problem with other numbers needs no new derivatives.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping, Sequence
from enum import Enum, auto
from types import SimpleNamespace
from typing import Any, ClassVar, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.scenario.scenario import Scenario

Array = NDArray[np.float64]

Data = SimpleNamespace
"""The symbols of a term's data, by name."""
Limits = tuple[ArrayLike, ArrayLike]
"""(lower, upper), each broadcast to (rows, N)."""
Mask = NDArray[np.bool_]


class Place(Enum):
    """Instants at which a constraint can hold."""

    NODE = auto()
    """The beginning of each interval, with that interval's inputs."""
    POINTS = auto()
    """The collocation points of each interval."""
    INTERVAL_END = auto()
    """The end of each interval, still with that interval's inputs."""
    HEIGHT_POINTS = auto()
    """The collocation points of the foot heights (only the height is to be read there)."""
    TERMINAL = auto()
    """The end of the horizon; there are no inputs."""


class Role(Enum):
    """What a constraint is to the motion, for whoever asks which one stands in its way."""

    PHYSICS = auto()
    """To give it up would not be a motion of this robot on this ground."""
    LIMIT = auto()
    """A limit of robot, ground or scenario."""
    END = auto()
    """How the motion ends."""
    GOAL = auto()
    """Where it ends."""


class Phase(Enum):
    """When a foot's constraint holds."""

    ALWAYS = auto()
    STANCE = auto()
    SWING = auto()


STATE = frozenset({Place.NODE, Place.POINTS, Place.TERMINAL})
"""A constraint on states: at nodes and collocation points."""
INPUT = frozenset({Place.NODE})
"""A constraint on inputs alone: they are constant in an interval, so once."""
ENDS = frozenset({Place.NODE, Place.INTERVAL_END})
"""A constraint on both: at the end, too, where the state is of the next interval but the input is not."""
END = frozenset({Place.TERMINAL})
"""At the end of the horizon."""


class Cost(ABC):
    """A cost: its expression times its weight, integrated over the horizon (or taken at the end).

    A subclass gives its `residual`, whose square the cost is, or its `expression` if it is no square.

    Attributes:
        name: of the term, unique in a problem.
        weight: factor; a cost of weight 0 is left out.
        terminal: take it at the end of the horizon instead of integrating it.
        structure: what its expression depends on besides `data`; of the package's own terms only, as those of
            others are told apart by their expressions.
    """

    name: ClassVar[str]
    terminal: ClassVar[bool] = False
    structure: tuple[Hashable, ...] = ()

    def __new__(cls, *_: Any, **__: Any) -> Self:
        # not as the class is made: one of a script is made in a worker before it has its methods
        if cls.residual is Cost.residual and cls.expression is Cost.expression:
            raise TypeError(f"{cls.__name__} must define residual or expression")
        return super().__new__(cls)

    def __init__(self, weight: float = 1.0) -> None:
        self.weight = float(weight)

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        """Numbers that `expression` reads, by name: shape (n,) for all the horizon or (n, N) by interval."""
        return {}

    def residual(self, x: Instant, d: Data) -> ca.SX | None:
        """The column whose square is the cost at one instant, without its weight; None if it is no square.

        The planner uses the exact Hessian of its square; the controller needs it, for a Hessian that is never
        indefinite (Gauss-Newton).
        """
        return None

    def expression(self, x: Instant, d: Data) -> ca.SX:
        """The cost at one instant, without its weight."""
        residual = self.residual(x, d)
        assert residual is not None, "a cost has one or the other"
        square: ca.SX = ca.sumsqr(residual)
        return square


class SelfDescribing:
    """What a constraint says of itself, so that nothing else need know it by name.

    Attributes:
        keys: bounds of the scenario that ask for it (any of them); always asked for if there are none.
        role: what it is to the motion.
        sentence: what would have to happen for it to be kept no longer.
        bound: the key of the bound that widens it, and what a wider one means; None if no single number does.
        keeps: whether it is not to be left out where it stands in the way.
        left_out_at_first: whether an easier problem, whose solution is a start, does without it.
    """

    keys: ClassVar[tuple[str, ...]] = ()
    role: ClassVar[Role] = Role.LIMIT
    sentence: ClassVar[str] = "the constraint would have to be missed"
    bound: ClassVar[tuple[str, str] | None] = None
    keeps: ClassVar[bool] = False
    left_out_at_first: ClassVar[bool] = False

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        """The terms of this class that a scenario asks for."""
        if cls.keys and not any(scenario.value_of("bounds", key) for key in cls.keys):
            return ()
        return (cls(),)


class Constraint(SelfDescribing, ABC):
    """A constraint on the robot as a whole: lower ≤ expression ≤ upper.

    Attributes:
        name: of the term, unique in a problem.
        places: where it holds.
        lower, upper: default limits, in the unit of the expression.
        unit: of the expression, for messages: m, rad, N, m/s, …
        by_weight: whether the solver sees it divided by the robot's weight: what is in newtons must be about
            1.
        curvature: its second derivative in time, in unit/s², that must be reckoned with between nodes: where
            a transcription demands the constraint at nodes only, it is tightened by curvature · h² / 8.
        structure: what its expression depends on besides `data`; see `Cost`.
    """

    name: ClassVar[str]
    places: ClassVar[frozenset[Place]] = STATE
    lower: float = -np.inf
    upper: float = np.inf
    unit: ClassVar[str] = ""
    by_weight: ClassVar[bool] = False
    curvature: ClassVar[float] = 0.0
    structure: tuple[Hashable, ...] = ()

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        """Numbers that `expression` reads, by name: shape (n,) for all the horizon or (n, N) by interval."""
        return {}

    def limits(self, problem: PlanContext) -> Limits:
        """(lower, upper), each broadcast to (rows, N)."""
        return self.lower, self.upper

    def holds(self, problem: PlanContext, place: Place) -> Mask:
        """In which intervals it holds, shape (N,); not asked for the end of the horizon."""
        return np.ones(problem.schedule.intervals, dtype=bool)

    @abstractmethod
    def expression(self, x: Instant, d: Data) -> ca.SX:
        """The constrained quantity at one instant, a column."""


class FootConstraint(SelfDescribing, ABC):
    """A constraint on each foot: lower ≤ expression ≤ upper.

    Attributes: as of `Constraint`, and
        phase: in which phase of the foot it holds.
    """

    name: ClassVar[str]
    places: ClassVar[frozenset[Place]] = STATE
    phase: ClassVar[Phase] = Phase.ALWAYS
    lower: float = -np.inf
    upper: float = np.inf
    unit: ClassVar[str] = ""
    by_weight: ClassVar[bool] = False
    curvature: ClassVar[float] = 0.0
    structure: tuple[Hashable, ...] = ()

    def applies(self, problem: PlanContext, leg: int) -> bool:
        """Whether this foot has such a constraint at all (by its kind, say)."""
        return True

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        """Numbers that `expression` reads, by name: shape (n,) for all the horizon or (n, N) by interval."""
        return {}

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        """(lower, upper), each broadcast to (rows, N)."""
        return self.lower, self.upper

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        """In which intervals it holds, shape (N,); for the end of the horizon the last one is asked."""
        stance = problem.schedule.contact[leg]
        if self.phase is Phase.ALWAYS:
            return np.ones_like(stance)
        return np.asarray(stance if self.phase is Phase.STANCE else ~stance)

    @abstractmethod
    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        """The constrained quantity of one foot at one instant, a column."""


Term = Cost | Constraint | FootConstraint
