"""What every transcription gives: a nonlinear program, and the way from motions to its variables and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.problem import Problem
from rollgait.plan.trajectory import Trajectory
from rollgait.transcription.guess import MotionGuess
from rollgait.transcription.nlp import Limits, Nlp

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Structure:
    """Sizes of the stages 0 … N: states, inputs, and rows that do not define the next state."""

    nx: tuple[int, ...]
    nu: tuple[int, ...]
    ng: tuple[int, ...]


class Program(Limits, Protocol):
    """A nonlinear program as a general solver sees it."""

    size: int
    rows: int

    @property
    def parameters(self) -> Array:
        """All numbers that the functions depend on."""

    @property
    def functions(self) -> Mapping[str, ca.Function]:
        """f, g and their derivatives as functions of (x, p), under the names that `nlpsol` uses."""

    def violations(self, g: Array, w: Array) -> Array:
        """By how much each constraint, then each bound, is violated (0 where it holds)."""

    def limit_name(self, number: int) -> str:
        """What a constraint, or a bound, is about; numbered as in `violations`."""


class Solvable(Protocol):
    """What a solver needs to know of a problem."""

    @property
    def name(self) -> str:
        """Name of the transcription."""

    @property
    def nlp(self) -> Nlp:
        """The nonlinear program."""

    @property
    def structure(self) -> Structure | None:
        """The stages, for solvers that exploit them; None if the variables are not those of stages."""


class Transcribed(Solvable, Protocol):
    """A transcribed problem."""

    @property
    def problem(self) -> Problem:
        """What was transcribed."""

    def encode(self, motion: MotionGuess) -> Array:
        """The free variables that come nearest to a motion."""

    def decode(self, w: Array) -> Trajectory:
        """The motion that free variables mean."""
