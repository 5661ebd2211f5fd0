"""From a scenario that cannot be solved to the reason and to what would help."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rollgait.diagnosis.report import Diagnosis, Suggestion
from rollgait.errors import RollgaitError
from rollgait.ocp.term import Term
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Progress
from rollgait.transcription.guess import Motion

if TYPE_CHECKING:
    from rollgait.diagnosis.changes import Candidate

LOOKING = "looking for the reason"
TRYING = "trying what would help"
MAX_SUGGESTIONS = 3
MAX_TRIALS = 6
"""Changed scenarios that are solved, at the most."""


def diagnose(
    scenario: str | Path | Scenario,
    *,
    profile: str | None = None,
    terms: Sequence[Term] = (),
    kernels: bool = True,
    progress: Progress | None = None,
) -> Diagnosis:
    """Why a scenario cannot be solved or misses its goal, and which single change helps.

    Constraints are relaxed at a price per unit; those that must be missed even so stand in the way. (Like
    every planner here it searches near its initial guess: it shows why no motion was found there.)

    Args:
        scenario: a scenario, the name of one in the library, or the path of a YAML file.
        profile: `paper` or `executable`, in place of the scenario's own.
        terms: further costs and constraints of your own.
        kernels: whether to use compiled stage functions where there is a compiler.
        progress: is called after each iteration of the solvers.

    Returns:
        The reasons, none if the constraints leave room for a motion; and changes that were tried and help.

    Raises:
        InputError: something in the input is wrong.
    """
    asked = scenario if isinstance(scenario, Scenario) else find_scenario(str(scenario))
    if profile is not None:
        asked = asked.with_values({"profile": profile})
    return Investigation(asked, terms, kernels, progress).diagnosis()


class Investigation:
    """What the elastic problem says of a scenario; what would help is tried only when it is asked for."""

    def __init__(
        self, scenario: Scenario, terms: Sequence[Term], kernels: bool, progress: Progress | None
    ) -> None:
        self._scenario, self._terms, self._kernels, self._progress = scenario, terms, kernels, progress
        from rollgait.diagnosis.elastic import find_missed  # what it needs takes a while to load

        self._finding = find_missed(scenario, terms, kernels, _saying(LOOKING, progress))

    @property
    def motion(self) -> Motion | None:
        """A motion that keeps all constraints but perhaps misses the goal; None if there is none."""
        kept, robot = self._finding.kept, self._finding.problem.robot
        return None if kept is None else lambda times: kept.sample(times, robot)

    def diagnosis(self) -> Diagnosis:
        """The reasons, and the changes that help."""
        from rollgait.diagnosis.reasons import reasons_of

        finding = self._finding
        reasons = reasons_of(finding.problem, finding.missed)
        return Diagnosis(reasons, tuple(self._suggestions()) if finding.missed else ())

    def _suggestions(self) -> Iterator[Suggestion]:
        from rollgait.diagnosis.changes import candidates

        trials = found = 0
        for candidate in candidates(self._scenario, self._finding):
            for text, change in candidate.variants:
                if trials == MAX_TRIALS or found == MAX_SUGGESTIONS:
                    return
                try:
                    changed = self._scenario.with_values(change)
                except RollgaitError:  # the scenario's own rules refuse it
                    continue
                trials += 1
                if self._helps(changed, candidate):
                    found += 1
                    yield Suggestion(change, text, verified=True)
                    break

    def _helps(self, changed: Scenario, candidate: Candidate) -> bool:
        from rollgait.diagnosis.trial import is_solvable

        near = self._finding.motion if candidate.is_limit else None
        return is_solvable(changed, self._terms, self._kernels, _saying(TRYING, self._progress), near)


def _saying(task: str, progress: Progress | None) -> Progress | None:
    """Progress that says what the iterations are for."""
    if progress is None:
        return None
    return lambda iteration: progress(replace(iteration, task=task))
