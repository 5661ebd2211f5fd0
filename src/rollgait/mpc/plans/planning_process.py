"""The process that plans in the background: reads tasks from stdin, writes answers to stdout, pickled."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import time

from rollgait.errors import NotSolvedError, RollgaitError
from rollgait.mpc.plans.worker import Answer, Task
from rollgait.planner import Planner
from rollgait.solvers import Iteration


def main() -> None:
    """Does tasks until stdin ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the controller, which ends this process
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a solver prints must not get between the answers
    planner = Planner()
    while True:
        try:
            task = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(_done(planner, task), answers)
        answers.flush()


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


if __name__ == "__main__":
    main()
