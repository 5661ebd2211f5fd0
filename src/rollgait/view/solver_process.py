"""The process behind the page: reads tasks from stdin, writes answers to stdout, one JSON object a line."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TextIO

import rollgait
from rollgait.config import parse_yaml
from rollgait.errors import NotSolvedError, RollgaitError
from rollgait.plan.plan import Plan
from rollgait.scenario.scenario import Scenario


def main() -> None:
    """Does tasks until stdin ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this process
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a solver prints must not get between the answers
    for line in sys.stdin:
        task = json.loads(line)
        try:
            file, message = (_plan if task["task"] == "plan" else _track)(task, answers)
        except RollgaitError as error:
            file, message = None, str(error)
        _answer(answers, {"file": file, "message": message})


def _plan(task: dict[str, Any], answers: TextIO) -> tuple[str | None, str]:
    from rollgait.planner import plan
    from rollgait.solvers import Iteration

    def progress(iteration: Iteration) -> None:
        numbers = {"iteration": iteration.number, "cost": iteration.cost, "violation": iteration.violation}
        _answer(answers, numbers)

    out = Path(task["out"])
    scenario = Scenario.from_dict(parse_yaml(task["scenario"], "the scenario of the page"))
    try:
        return str(plan(scenario, progress=progress).save(out)), ""
    except NotSolvedError as error:
        iterate: Plan | None = error.plan
        file = None if iterate is None else str(iterate.save(out))
        return file, f"{error}{_explained(scenario, progress)}"


def _track(task: dict[str, Any], answers: TextIO) -> tuple[str | None, str]:
    from rollgait.tracking import track

    return str(track(Plan.load(task["plan"]), rate=100.0, force=True).save(task["out"])), ""


def _explained(scenario: Scenario, progress: Callable[[Any], None]) -> str:
    """What stands in the way of a plan, and what would help; "" if nothing is found."""
    diagnose = getattr(rollgait, "diagnose", None)
    if diagnose is None:
        return ""
    found = diagnose(scenario, progress=progress)
    reasons = [f"{r.description}, missed by {r.excess:.3g} {r.unit}".rstrip() for r in found.reasons]
    helps = [suggestion.text for suggestion in found.suggestions]
    text = f". In the way: {'; '.join(reasons)}" if reasons else ""
    return text + (f". What would help: {'; '.join(helps)}" if helps else "")


def _answer(answers: TextIO, data: dict[str, Any]) -> None:
    answers.write(json.dumps(data) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
