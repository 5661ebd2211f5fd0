"""The process that plans in the background."""

from __future__ import annotations

import time

from rollgait.child import Parent
from rollgait.errors import NotSolvedError, RollgaitError
from rollgait.mpc.plans.worker import Answer, Task
from rollgait.planner import Planner
from rollgait.solvers import Iteration


def main() -> None:
    """Does one task after another."""
    parent, planner = Parent(), Planner()
    while True:
        parent.tell(_done(planner, parent.asks()))


def _done(planner: Planner, task: Task) -> Answer:
    begin = time.process_time()
    found, message = None, ""

    def in_time(_: Iteration) -> None:
        if task.seconds is not None and time.process_time() - begin > task.seconds:
            raise NotSolvedError(f"none was found within {task.seconds:g} s of processor time")

    try:
        found = planner.plan(task.asked, diagnose=False, progress=in_time)
        failures = found.certificate().failures
        if failures:
            found, message = None, f"the new plan is not certified: {failures[0].name}"
    except RollgaitError as error:
        message = str(error)
    return Answer(found, message, time.process_time() - begin)
