"""The search for better steps, with the planner."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from rollgait.attempts import Effort
from rollgait.diagnosis.budget import Limits
from rollgait.discover.step_search import CANDIDATES, CHANGES, StepSearch, Tried, enumerate_steps
from rollgait.plan.plan import Plan
from rollgait.planner import Planner
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario

ITERATIONS: Final = 80
"""Of the solver for each solve of a changed gait: who needs more mostly gets nowhere."""
CHANGED: Final = Effort(
    starts=2, rounds=3, patience=math.inf, limits=Limits(until=math.inf, iterations=ITERATIONS)
)
"""For a changed gait: from the best motion so far, and where that leads nowhere once from none."""


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
    begun = False

    def plan(asked: Scenario, warm_start: Plan | None) -> Plan:
        nonlocal begun
        timing = asked.gait.timing
        if begun and (timing is None or not timing.optimize):
            return planner.plan_within(asked, CHANGED, warm_start)
        begun = True  # on the gait that is given all depends
        return planner.plan(asked, warm_start=warm_start, diagnose=False)

    asked = scenario if isinstance(scenario, Scenario) else find_scenario(str(scenario))
    return enumerate_steps(asked, plan, changes, candidates, tell)
