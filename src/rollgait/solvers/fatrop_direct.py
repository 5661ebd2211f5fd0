"""Fatrop called directly: what CasADi's adapter spends on setting up, this one does not."""

from __future__ import annotations

import logging
import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers.budget import Repair
from rollgait.solvers.compiled_evaluation import library
from rollgait.solvers.fatrop_engine import FatropEngine, Options
from rollgait.solvers.linear_algebra import linear_algebra
from rollgait.solvers.refusal import refuse_unsolvable
from rollgait.solvers.solution import Progress, Solution
from rollgait.solvers.watched import NoAnswerError
from rollgait.transcription.base import Structure
from rollgait.transcription.nlp import Nlp

log = logging.getLogger("rollgait")
Array = NDArray[np.float64]


class DirectFatrop:
    """A solver for one NLP with stages, built once, solved as often as needed.

    Args:
        nlp, structure: the problem.
        options, warm_options, repair_options: of fatrop; the second for a guess near the solution, the last
            where in addition there is a `repair`.
        kernels: whether what evaluates the problem is compiled, where there is a compiler.

    Raises:
        InterfaceError: the library is not the expected one.
    """

    name = "fatrop"
    real_time = True
    runs_side_by_side = True  # each has its own memory

    def __init__(
        self,
        nlp: Nlp,
        structure: Structure,
        options: Options,
        warm_options: Options,
        repair_options: Options,
        kernels: bool = False,
    ) -> None:
        self.nlp = nlp
        self.linear_algebra = linear_algebra()
        compiled = library() if kernels else None
        self._make_engine = partial(
            FatropEngine, nlp, structure, options, warm_options, repair_options, compiled
        )
        self._engine = self._make_engine()

    def solve(
        self,
        guess: Array,
        progress: Progress | None = None,
        warm: bool = False,
        until: float = math.inf,
        iterations: int | None = None,
        repair: Repair | None = None,
    ) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution.

        Limits and parameters are those that the NLP has now. No iteration begins that would end after `until`
        (a time of `time.perf_counter`, s), nor more than `iterations` (fatrop's `max_iter` of 1 makes two).
        With a `repair` there may be more, the iterate with the smallest violation counts, and the last one is
        not looked at whether it converged.
        `progress` is called in another thread, while this one waits. If fatrop does not come back, it is left
        behind: the guess is returned, not solved, and the next solve begins with another one.

        Raises:
            NotSolvedError: the numbers are such that no solver is asked.
            KeyboardInterrupt: the user interrupted it, and nobody else handles that.
        """
        refuse_unsolvable(self.nlp, guess)
        engine = self._engine
        try:
            return engine.solve(guess, progress, warm, until, iterations, repair)
        except NoAnswerError as error:
            log.warning("fatrop does not come back (%s): it is left behind", error)
            self._replace(engine)
            return self._as_it_was(guess)
        except BaseException:
            if engine.is_running:  # somebody ended the wait for it
                self._replace(engine)
            raise

    def _replace(self, engine: FatropEngine) -> None:
        engine.abandon()
        self._engine = self._make_engine()

    def _as_it_was(self, guess: Array) -> Solution:
        cost, g = self._engine.values(guess)
        return Solution(guess.copy(), g, cost, solved=False, status="No_Answer", iterations=0)

    def violation(self, w: Array) -> float:
        """Largest violation of a constraint at the free variables, for the NLP as it is now; may be NaN."""
        _, g = self._engine.values(w)
        return float(self.nlp.violations(g, w).max(initial=0.0))
