"""Solving a problem from one initial guess after another, or from several at once."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from rollgait.diagnosis.budget import UNLIMITED, Budget, Limits
from rollgait.errors import NotSolvedError, UnknownNameError
from rollgait.mending import ROUNDS
from rollgait.ocp.problem import Problem
from rollgait.plan.plan import StartResult
from rollgait.solvers import SOLVER_NAMES, Iteration, Progress, Solution, Solver, make_solver
from rollgait.solvers.code_store import store_for
from rollgait.solvers.solution import saying
from rollgait.starts import InitialGuess
from rollgait.stopwatch import Stopwatch
from rollgait.transcription import TRANSCRIPTION_NAMES, transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import MotionGuess

Array = NDArray[np.float64]

FALLBACKS = 4
"""Starts that are tried before a problem is given up."""


AGAIN = 40
"""Iterations for a problem that is nearly the same as one that was solved: it takes about 20 if it does not
stall."""
PATIENCE = 8.0
"""s, after which no further attempt is made to turn a solution into one whose certificate passes."""


@dataclass(frozen=True)
class Effort:
    """What may be spent on a problem.

    Attributes:
        starts: that are tried before it is given up.
        rounds: looks of the judge at a solution; between two of them it is mended.
        patience: s, after which a solution is not mended any further.
        limits: of each run of a solver.
        warm_iterations: the most of a run from near a solution.
    """

    starts: int = FALLBACKS
    rounds: int = ROUNDS
    patience: float = PATIENCE
    limits: Limits = field(default_factory=lambda: UNLIMITED)
    warm_iterations: int | None = None

    @property
    def again(self) -> Effort:
        """For a problem nearly the same as one that was solved: two starts, the warm one soon ends."""
        return replace(self, starts=2, warm_iterations=AGAIN)

    def limits_of(self, start: InitialGuess) -> Limits:
        """Of a run of a solver from a start."""
        most = [n for n in (self.limits["iterations"], self.warm_iterations if start.warm else None) if n]
        return Limits(until=self.limits["until"], iterations=min(most, default=None))


USUAL = Effort()
"""Of a problem on which all depends."""
OF_REST = replace(USUAL, warm_iterations=30)
"""Of what is left of a plan: from its own motion it takes 6 to 25 iterations, or stalls; from the same as a
start that is trusted less it mostly goes on then."""


@dataclass(frozen=True)
class Method:
    """How problems are solved: names of transcription and solver, and whether kernels are compiled."""

    transcription: str
    solver: str
    kernels: bool

    @classmethod
    def of(cls, transcription: str | None, solver: str | None, kernels: bool) -> Method:
        """The method of these names; what is not named is chosen. Raises `UnknownNameError`."""
        if transcription is not None and transcription not in TRANSCRIPTION_NAMES:
            raise UnknownNameError("transcription", transcription, TRANSCRIPTION_NAMES)
        if solver is not None and solver not in SOLVER_NAMES:
            raise UnknownNameError("solver", solver, SOLVER_NAMES)
        if solver is None:
            solver = "ipopt" if transcription == "collocation" else "fatrop"
        return cls(transcription or "condensed", solver, kernels)

    def solve(self, problem: Problem, motion: MotionGuess) -> MotionGuess | None:
        """The solution of another problem from a motion, by the same method; None if there is none."""
        ready = Ready(self, problem)
        if ready.transcribed.nlp.contradictions:
            return None
        solution = ready.solver.solve(ready.transcribed.encode(motion))
        if not solution.solved:
            return None
        trajectory = ready.transcribed.decode(solution.w)
        return lambda times: trajectory.sample(times, problem.robot)


class Ready:
    """A problem, transcribed, with its solver."""

    def __init__(self, method: Method, problem: Problem) -> None:
        self.problem = problem
        store = store_for(method.kernels)
        self.transcribed: Transcribed = transcribe(method.transcription, problem, store)
        self._method = method
        self._solver: Solver | None = None

    @property
    def solver(self) -> Solver:
        """The solver, made when it is first asked for."""
        if self._solver is None:
            self._solver = self.another_solver()
        return self._solver

    def another_solver(self, name: str | None = None) -> Solver:
        """A further solver for the same problem: for another thread, or another one by name."""
        return make_solver(name or self._method.solver, self.transcribed, self._method.kernels)

    def refuse_contradictions(self) -> None:
        """Raises `NotSolvedError` where fixed values break a constraint: no solver need be asked."""
        found = self.transcribed.nlp.contradictions
        if not found:
            return
        # what contradicts the dynamics mostly follows from what contradicts itself
        origin, excess = max(found, key=lambda item: (item[0].label.term != "dynamics", item[1]))
        at = self.problem.schedule.node_times[origin.interval]
        amount = f"{excess * origin.label.scale:.3g} {origin.label.unit}".rstrip()
        raise NotSolvedError(
            f"no solution exists: {origin.label.describe()} contradicts the fixed values "
            f"at t = {at:.2f} s by {amount}"
        )


@dataclass(frozen=True)
class Attempt:
    """What came of a start."""

    start: InitialGuess
    solution: Solution
    solve_time: float
    violation: float
    solver: str
    linear_algebra: str

    def result(self) -> StartResult:
        """The same in short, as statistics keep it."""
        s = self.solution
        return StartResult(self.start.name, s.solved, s.cost, s.iterations, self.solve_time)


class Attempts:
    """Solves a problem from starts until enough are solved.

    Attributes:
        done: the attempts, in the order in which they were made.
        ready: what is solved.
    """

    def __init__(
        self, ready: Ready, progress: Progress | None, watch: Stopwatch, effort: Effort = USUAL
    ) -> None:
        self.ready, self._progress, self._watch, self._effort = ready, progress, watch, effort
        self.done: list[Attempt] = []

    @property
    def solved(self) -> bool:
        """Whether any start was solved."""
        return any(attempt.solution.solved for attempt in self.done)

    @property
    def best(self) -> Attempt:
        """The cheapest solution, or what came nearest to one."""
        solved = [attempt for attempt in self.done if attempt.solution.solved]
        return (
            min(solved, key=lambda a: a.solution.cost)
            if solved
            else min(self.done, key=lambda a: a.violation)
        )

    def run(self, starts: Iterator[InitialGuess], multistart: int) -> None:
        """Solves from `multistart` starts at once, then one by one until one is solved or all are tried."""
        first = list(islice(self._guesses(starts), multistart))
        self._side_by_side(first) if len(first) > 1 else self._in_turn(first)
        # a start may be the solution of another problem: it is made only when it is needed
        further = self._guesses(islice(starts, max(0, self._effort.starts - multistart)))
        while not self.solved and (guess := next(further, None)) is not None:
            self._in_turn([guess])

    def run_another(self, starts: Iterator[InitialGuess]) -> Attempt | None:
        """Solves from one more start; None if there is none, if it is not solved, or the effort is made."""
        guess = next(self._guesses(islice(starts, max(0, self._effort.starts - len(self.done)))), None)
        if guess is None:
            return None
        self._in_turn([guess])
        return self.done[-1] if self.done[-1].solution.solved else self.run_another(starts)

    def run_elastic(self, motion: MotionGuess | None, budget: Budget) -> None:
        """Solves from a motion that keeps all constraints, if there is one; if need be with IPOPT."""
        if motion is None:
            return
        report = budget.counting("solving from a motion that keeps all constraints", self._progress)
        with self._watch("guess"):
            guess = self.ready.transcribed.encode(motion)
        start = InitialGuess("elastic", lambda: motion, warm=True)
        with self._watch("solve"):
            self.done.append(_attempt(self.ready, self.ready.solver, start, guess, report, budget.limits))
        if not self.solved and self.ready.solver.name != "ipopt":
            with self._watch("build"):
                other = self.ready.another_solver("ipopt")
            start = InitialGuess("elastic, by ipopt", lambda: motion)
            with self._watch("solve"):
                self.done.append(_attempt(self.ready, other, start, guess, report, budget.limits))

    def _guesses(self, some: Iterator[InitialGuess]) -> Iterator[tuple[InitialGuess, Array]]:
        """Starts with their guesses of the variables; those that do not apply are left out."""
        for start in some:
            with self._watch("guess"):
                motion = start.motion()
                guess = None if motion is None else self.ready.transcribed.encode(motion)
            if guess is not None:
                yield start, guess

    def _in_turn(self, guesses: Sequence[tuple[InitialGuess, Array]]) -> None:
        with self._watch("build"):
            solver = self.ready.solver
        for start, guess in guesses:
            number, most = len(self.done) + 1, max(FALLBACKS, len(self.done) + len(guesses))
            said = saying(f"solving, start {number} of {most}", self._progress)
            with self._watch("solve"):
                limits = self._effort.limits_of(start)
                progress = said if number > 1 else self._progress
                self.done.append(_attempt(self.ready, solver, start, guess, progress, limits))

    def _side_by_side(self, guesses: Sequence[tuple[InitialGuess, Array]]) -> None:
        """Solves on the cores there are, if the solver can run more than once at a time; Ctrl-C ends all."""
        cores = min(len(guesses), os.cpu_count() or 1)
        if cores < 2 or not getattr(self.ready.solver, "runs_side_by_side", False):
            self._in_turn(guesses)
            return
        with self._watch("build"):
            solvers = [self.ready.solver, *(self.ready.another_solver() for _ in guesses[1:])]
        over = threading.Event()

        def watched(number: int) -> Progress:
            def report(iteration: Iteration) -> None:
                if over.is_set():
                    raise KeyboardInterrupt
                if number == 0 and self._progress is not None:
                    self._progress(iteration)

            return report

        with self._watch("solve"), ThreadPoolExecutor(cores) as pool:
            try:
                futures = [
                    pool.submit(
                        _attempt,
                        self.ready,
                        solver,
                        start,
                        guess,
                        watched(number),
                        self._effort.limits_of(start),
                    )
                    for number, (solver, (start, guess)) in enumerate(zip(solvers, guesses, strict=True))
                ]
                self.done += [future.result() for future in futures]
            finally:
                over.set()


def _attempt(
    ready: Ready,
    solver: Solver,
    start: InitialGuess,
    guess: Array,
    progress: Progress | None,
    limits: Limits = UNLIMITED,
) -> Attempt:
    begin = time.perf_counter()
    solution = solver.solve(guess, progress, start.warm, **limits)
    violation = float(ready.transcribed.nlp.violations(solution.g, solution.w).max(initial=0.0))
    seconds = time.perf_counter() - begin
    return Attempt(start, solution, seconds, violation, solver.name, solver.linear_algebra)
