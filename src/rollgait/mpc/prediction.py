"""What a step of the controller says about itself and about what it expects."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from rollgait.config import Line

Array = NDArray[np.float64]
Mode = Literal["tracking", "coasting", "standing"]


@dataclass(frozen=True)
class Status:
    """How a step of the controller went.

    Attributes:
        mode: `tracking` the command; `coasting` on the last plan; `standing` for good, after a fault.
        iterations: of the solver.
        converged: whether the solver met its tolerance.
        violation: largest violation of a constraint, in the solver's scaling.
        cost: of the horizon.
        cost_rate: of its first interval, per second.
        solver_seconds: of wall time that the solver took.
        seconds: of wall time that the step took.
        late: whether that was more than the deadline.
    """

    mode: Mode
    iterations: int = 0
    converged: bool = False
    violation: float = 0.0
    cost: float = math.nan
    cost_rate: float = math.nan
    solver_seconds: float = 0.0
    seconds: float = 0.0
    late: bool = False


STANDING_STATUS: Final = Status("standing")


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the controller expects.

    Attributes:
        time: of the nodes, (N + 1,), s.
        com_position: r, (N + 1, 3), m.
        euler: θ, (N + 1, 3), rad.
        foot_position: p, (N + 1, 4, 3), m.
        force: mean over each interval, (N, 4, 3), N.
        contact: whether a foot stands for some of the interval, (N, 4).
        reference: r and yaw that are asked for, (N + 1, 4).
        status: of the step.
    """

    time: Array
    com_position: Array
    euler: Array
    foot_position: Array
    force: Array
    contact: NDArray[np.bool_]
    reference: Array
    status: Status


@dataclass(frozen=True)
class Event:
    """Something that was not as it should be: when (s), and what."""

    time: float
    text: Line
