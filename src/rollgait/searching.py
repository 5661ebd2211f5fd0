"""The search for better steps, with the planner."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from rollgait.discover.step_search import CANDIDATES, CHANGES, StepSearch, Tried, enumerate_steps
from rollgait.plan.plan import Plan
from rollgait.planner import Planner
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario


def search_steps(
    scenario: str | Path | Scenario,
    *,
    changes: Sequence[str] = CHANGES,
    candidates: int = CANDIDATES,
    kernels: bool = True,
    tell: Callable[[Tried], None] = lambda tried: None,
) -> StepSearch:
    """Changes the steps of a gait as long as that saves cost: fewer, more, in pairs, in other orders.

    >>> search_steps("hybrid-forward").best.steps  # doctest: +SKIP
    ()

    Args:
        scenario: a scenario with a gait, the name of one in the library, or the path of a YAML file.
        changes: what is tried in turn: `fewer`, `more`, `pairs`, `orders`.
        candidates: how many gaits are planned at most.
        kernels: whether to use compiled stage functions where there is a compiler.
        tell: is told of each gait that was planned.

    Returns:
        All gaits that were planned, and the best one.

    Raises:
        InputError: something in the input is wrong.
    """
    planner = Planner(kernels=kernels)

    def plan(asked: Scenario, warm_start: Plan | None) -> Plan:
        return planner.plan(asked, warm_start=warm_start, diagnose=False)

    asked = scenario if isinstance(scenario, Scenario) else find_scenario(str(scenario))
    return enumerate_steps(asked, plan, changes, candidates, tell)
