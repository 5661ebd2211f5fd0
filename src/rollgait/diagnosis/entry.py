"""From a scenario that cannot be solved to the reason and to what would help."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING

from rollgait.diagnosis.budget import ITERATIONS, SECONDS, Budget
from rollgait.diagnosis.report import Diagnosis, Suggestion
from rollgait.errors import RollgaitError
from rollgait.ocp.term import Term
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Progress
from rollgait.transcription.guess import MotionGuess

if TYPE_CHECKING:
    from rollgait.diagnosis.changes import Candidate
    from rollgait.plan.trajectory import Trajectory

TRYING = "trying"
MAX_SUGGESTIONS = 3
MAX_TRIALS = 6
"""Changed scenarios that are solved, at the most."""
FURTHER_STARTS = (4, 8)
"""Of the starts of `rollgait.plan`, from which to which: it has tried the first ones by itself."""


def diagnose(
    scenario: str | Path | Scenario,
    *,
    profile: str | None = None,
    terms: Sequence[Term] = (),
    kernels: bool = True,
    progress: Progress | None = None,
    seconds: float = SECONDS,
    iterations: int = ITERATIONS,
) -> Diagnosis:
    """Why a scenario cannot be solved or misses its goal, and which single change helps.

    Constraints are relaxed at a price per unit; those that must be missed even so stand in the way. (Like
    every planner here it searches near its initial guess: it shows why no motion was found there.)

    Args:
        scenario: a scenario, the name of one in the library, or the path of a YAML file.
        profile: `paper` or `executable`, in place of the scenario's own.
        terms: further costs and constraints of your own.
        kernels: whether to use compiled stage functions where there is a compiler.
        progress: is called after each iteration of the solvers, with what is being tried.
        seconds: of wall time that may be spent.
        iterations: of all solvers together that may be spent.

    Returns:
        The reasons, none if the constraints leave room for a motion; and changes that were tried and help. If
        the budget is spent before, what was found until then.

    Raises:
        InputError: something in the input is wrong.
    """
    asked = scenario if isinstance(scenario, Scenario) else find_scenario(str(scenario))
    if profile is not None:
        asked = asked.with_values({"profile": profile})
    return Investigation(asked, terms, kernels, progress, Budget(seconds, iterations)).diagnosis()


class Investigation:
    """What the elastic problem says of a scenario; what would help is tried only when it is asked for.

    Args:
        scenario: what was asked.
        terms: further terms of the problem.
        kernels: whether to use compiled stage functions.
        progress: is called after each iteration, with what is being tried.
        budget: what may be spent, from now on.
        has_failed: whether the scenario as it is has been tried in vain.
    """

    def __init__(
        self,
        scenario: Scenario,
        terms: Sequence[Term],
        kernels: bool,
        progress: Progress | None,
        budget: Budget,
        has_failed: bool = False,
    ) -> None:
        self._scenario, self._terms, self._kernels, self._progress = scenario, terms, kernels, progress
        self.budget, self._has_failed = budget, has_failed
        self._failed: list[str] = []
        self._open: list[Suggestion] = []
        from rollgait.diagnosis.elastic import find_missed  # what it needs takes a while to load

        budget.begin()
        self._finding = find_missed(scenario, terms, kernels, progress, budget)

    @property
    def motion(self) -> MotionGuess | None:
        """A motion that keeps all constraints but perhaps misses the goal; None if there is none."""
        kept, robot = self._finding.kept, self._finding.problem.robot
        return None if kept is None else lambda times: kept.sample(times, robot)

    def diagnosis(self) -> Diagnosis:
        """The reasons, and the changes that help; or the next steps."""
        from rollgait.diagnosis.changes import candidates, next_steps
        from rollgait.diagnosis.reasons import reasons_of

        finding, scenario = self._finding, self._scenario
        reasons = reasons_of(finding.problem, finding.missed)
        found: tuple[Suggestion, ...] = ()
        if finding.missed:
            found = tuple(self._helpful(candidates(scenario, finding), MAX_TRIALS))
        elif not self._has_failed and self._solves(scenario, "to plan it as it is", to_goal=True):
            return Diagnosis()
        if not found and not self._open:
            steps = chain(self._helpful(next_steps(scenario, finding), MAX_TRIALS), self._further_starts())
            found = tuple(islice(steps, 1))
        found = found or tuple(self._open[:MAX_SUGGESTIONS])
        return Diagnosis(reasons, found, tuple(self._failed), complete=not self.budget.is_spent())

    def _helpful(self, some: Iterator[Candidate], most: int) -> Iterator[Suggestion]:
        """Of each candidate the mildest strength that helps; what there is no time to try stays open."""
        trials = found = 0
        for candidate in some:
            for text, change in candidate.variants:
                if trials == most or found == MAX_SUGGESTIONS:
                    return
                try:
                    changed = self._scenario.with_values(change)
                except RollgaitError:  # the scenario's own rules refuse it
                    continue
                if self.budget.is_spent():
                    self._open.append(Suggestion(change, text, verified=False))
                    break
                trials += 1
                near = self._finding.motion if candidate.is_limit else None
                if self._solves(changed, text, near, to_goal=not self._finding.missed):
                    found += 1
                    yield Suggestion(change, text, verified=True)
                    break

    def _further_starts(self) -> Iterator[Suggestion]:
        """Starts that the planner has not tried by itself, one by one."""
        from rollgait.ocp.problem import make_problem
        from rollgait.starts import starts

        first, last = FURTHER_STARTS
        text = f"more initial guesses: {last}"
        if self.budget.is_spent():
            self._open.append(Suggestion({}, text, verified=False, arguments={"multistart": last}))
            return
        try:
            guesses = starts(make_problem(self._scenario, self._terms), lambda *_: None, None, seed=0)
        except RollgaitError:
            return
        for number, start in enumerate(islice(guesses, first, last), first + 1):
            if self.budget.is_spent():
                return
            text = f"more initial guesses: {number}"
            if self._solves(self._scenario, text, start.motion(), to_goal=True):
                yield Suggestion({}, text, verified=True, arguments={"multistart": number})
                return

    def _solves(
        self,
        changed: Scenario,
        what: str,
        near: Trajectory | MotionGuess | None = None,
        to_goal: bool = False,
    ) -> bool:
        from rollgait.diagnosis.trial import is_solvable

        report = self.budget.counting(f"{TRYING} {what}", self._progress)
        helps = is_solvable(changed, self._terms, self._kernels, report, self.budget, near, to_goal)
        if not helps and not self.budget.is_spent():  # a trial cut short says nothing
            self._failed.append(what)
        return helps
