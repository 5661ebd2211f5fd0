"""The process behind the page: reads tasks from stdin, writes answers to stdout, one JSON object a line."""

from __future__ import annotations

import json
import os
import signal
import sys
from pathlib import Path
from typing import Any, Final, TextIO

import numpy as np

import rollgait
from rollgait.config import parse_yaml
from rollgait.diagnosis.report import Diagnosis
from rollgait.errors import NotSolvedError, RollgaitError
from rollgait.plan.plan import Plan
from rollgait.scenario.scenario import Scenario
from rollgait.terrain.height_map import HeightMap

GOAL_ROWS: Final = ("goal_distance", "goal_yaw")
"""Rows of the certificate that fail when a plan does not get to its goal."""


def main() -> None:
    """Does tasks until stdin ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this process
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a solver prints must not get between the answers
    for line in sys.stdin:
        task = json.loads(line)
        try:
            found = (_plan if task["task"] == "plan" else _track)(task, answers)
        except RollgaitError as error:
            found = {"file": None, "message": str(error)}
        _answer(answers, found)


def _plan(task: dict[str, Any], answers: TextIO) -> dict[str, Any]:
    from rollgait.planner import plan
    from rollgait.solvers import Iteration

    stage = ""

    def progress(iteration: Iteration) -> None:
        numbers = {"iteration": iteration.number, "cost": iteration.cost, "violation": iteration.violation}
        _answer(answers, {"stage": stage or iteration.task, **numbers})

    out = Path(task["out"])
    data, heights = parse_yaml(task["scenario"], "the scenario of the page"), None
    if "map" in task:
        place = dict(task["map"])
        heights = HeightMap(np.load(place.pop("heights")), **place)
    scenario = Scenario.from_dict(data, heights=heights)
    try:
        found = plan(scenario, progress=progress)
    except NotSolvedError as error:
        return {"file": None, "message": str(error), "diagnosis": _data(error.diagnosis)}
    diagnosis = None
    if any(row.name in GOAL_ROWS for row in found.certificate().failures):
        stage = "the goal is missed: looking for the reason"
        diagnosis = rollgait.diagnose(scenario, progress=progress)
    return {"file": str(found.save(out)), "message": "", "diagnosis": _data(diagnosis)}


def _track(task: dict[str, Any], answers: TextIO) -> dict[str, Any]:
    from rollgait.tracking import track

    joints = track(Plan.load(task["plan"]), rate=100.0, force=True)
    return {"file": str(joints.save(task["out"])), "message": ""}


def _data(diagnosis: Diagnosis | None) -> dict[str, Any] | None:
    return None if diagnosis is None else diagnosis.to_dict()


def _answer(answers: TextIO, data: dict[str, Any]) -> None:
    answers.write(json.dumps(data) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
