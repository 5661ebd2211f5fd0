"""What a cost and a constraint are.

A term describes one instant; where it holds it says by `places` and `phase`, and the transcription does
the rest. Numbers that a term needs (limits, weights, goals) are data: `data` returns them by name, and
`expression` gets symbols of the same names. So a problem with other numbers needs no new derivatives.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from enum import Enum, auto
from types import SimpleNamespace
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp.instant import Foot, Instant

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem

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

    Attributes:
        name: of the term, unique in a problem.
        weight: factor; a cost of weight 0 is left out.
        terminal: take it at the end of the horizon instead of integrating it.
    """

    name: ClassVar[str]
    terminal: ClassVar[bool] = False

    def __init__(self, weight: float = 1.0) -> None:
        self.weight = float(weight)

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        """Numbers that `expression` reads, by name: shape (n,) for all the horizon or (n, N) by interval."""
        return {}

    @abstractmethod
    def expression(self, x: Instant, d: Data) -> ca.SX:
        """The cost at one instant, without its weight."""


class Constraint(ABC):
    """A constraint on the robot as a whole: lower ≤ expression ≤ upper.

    Attributes:
        name: of the term, unique in a problem.
        places: where it holds.
        lower, upper: default limits, in the unit of the expression.
        unit: of the expression, for messages: m, rad, N, m/s, …
    """

    name: ClassVar[str]
    places: ClassVar[frozenset[Place]] = STATE
    lower: float = -np.inf
    upper: float = np.inf
    unit: ClassVar[str] = ""

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        """Numbers that `expression` reads, by name: shape (n,) for all the horizon or (n, N) by interval."""
        return {}

    def limits(self, problem: Problem) -> Limits:
        """(lower, upper), each broadcast to (rows, N)."""
        return self.lower, self.upper

    def holds(self, problem: Problem, place: Place) -> Mask:
        """In which intervals it holds, shape (N,); not asked for the end of the horizon."""
        return np.ones(problem.schedule.intervals, dtype=bool)

    @abstractmethod
    def expression(self, x: Instant, d: Data) -> ca.SX:
        """The constrained quantity at one instant, a column."""


class FootConstraint(ABC):
    """A constraint on each foot: lower ≤ expression ≤ upper.

    Attributes: as of `Constraint`, and
        phase: in which phase of the foot it holds.
        curvature: its second derivative in time, in unit/s², that must be reckoned with between nodes: where
            a transcription demands the constraint at nodes only, it is tightened by curvature · h² / 8.
    """

    name: ClassVar[str]
    places: ClassVar[frozenset[Place]] = STATE
    phase: ClassVar[Phase] = Phase.ALWAYS
    lower: float = -np.inf
    upper: float = np.inf
    unit: ClassVar[str] = ""
    curvature: ClassVar[float] = 0.0

    def applies(self, problem: Problem, leg: int) -> bool:
        """Whether this foot has such a constraint at all (by its kind, say)."""
        return True

    def data(self, problem: Problem, leg: int) -> Mapping[str, ArrayLike]:
        """Numbers that `expression` reads, by name: shape (n,) for all the horizon or (n, N) by interval."""
        return {}

    def limits(self, problem: Problem, leg: int) -> Limits:
        """(lower, upper), each broadcast to (rows, N)."""
        return self.lower, self.upper

    def holds(self, problem: Problem, place: Place, leg: int) -> Mask:
        """In which intervals it holds, shape (N,); for the end of the horizon the last one is asked."""
        stance = problem.schedule.contact[leg]
        if self.phase is Phase.ALWAYS:
            return np.ones_like(stance)
        return np.asarray(stance if self.phase is Phase.STANCE else ~stance)

    @abstractmethod
    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        """The constrained quantity of one foot at one instant, a column."""


Term = Cost | Constraint | FootConstraint
