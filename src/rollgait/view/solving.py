"""Planning and tracking in a process of their own, so that the page never waits for them.

The process begins with the first task and stays. Tasks and answers are lines of JSON, plans travel as files.
"""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any

import numpy as np

from rollgait.diagnosis.report import Diagnosis, Reason, Suggestion
from rollgait.scenario.scenario import Scenario


@dataclass(frozen=True)
class SolvingProgress:
    """An iteration of the solver, and what it works at."""

    stage: str
    number: int
    cost: float
    violation: float


@dataclass(frozen=True)
class Outcome:
    """What came of a task.

    Attributes:
        file: what was found, None if there is nothing.
        message: why not, "" if all is well.
        diagnosis: what is in the way of the plan or of its goal, None if nothing is.
    """

    file: Path | None
    message: str = ""
    diagnosis: Diagnosis | None = None


class Solving:
    """One task at a time, in the background.

    Args:
        on_progress: is called with each iteration, in a thread.
        on_done: is called with the outcome, in a thread.
    """

    def __init__(
        self, on_progress: Callable[[SolvingProgress], None], on_done: Callable[[Outcome], None]
    ) -> None:
        self._on_progress, self._on_done = on_progress, on_done
        self._process: subprocess.Popen[str] | None = None
        self._folder = TemporaryDirectory(prefix="rollgait-")
        self._lock = threading.Lock()
        self._count = 0
        self._busy = False

    @property
    def busy(self) -> bool:
        """Whether a task runs."""
        return self._busy

    def plan(self, scenario: Scenario) -> bool:
        """Plans a scenario; False if another task runs. The heights of its map go with it as a file."""
        task: dict[str, Any] = {"task": "plan", "scenario": scenario.to_yaml()}
        heights = scenario.ground.heights
        if heights is not None:
            file = self.new_file(".npy")
            np.save(file, heights.values)
            task["map"] = {"heights": str(file), **heights.place()}
        return self._start(task)

    def track(self, plan: Path) -> bool:
        """Finds the joints of a plan in a file; False if another task runs."""
        return self._start({"task": "track", "plan": str(plan)})

    def new_file(self, suffix: str = ".npz") -> Path:
        """A place for a file that lives as long as this object."""
        self._count += 1
        return Path(self._folder.name) / f"{self._count}{suffix}"

    def cancel(self) -> None:
        """Stops the running task, and says so to `on_done`."""
        process = self._process
        if self._busy and process is not None:
            process.kill()

    def close(self) -> None:
        """Ends the process and removes its files."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    stream.close()
        self._folder.cleanup()

    def _start(self, task: dict[str, Any]) -> bool:
        with self._lock:
            if self._busy:
                return False
            self._busy = True
        threading.Thread(target=self._run, args=(task,), name="solving", daemon=True).start()
        return True

    def _run(self, task: dict[str, Any]) -> None:
        outcome = self._exchange({**task, "out": str(self.new_file())})
        self._busy = False
        if self._process is not None or outcome.file is not None:
            self._on_done(outcome)

    def _exchange(self, task: dict[str, Any]) -> Outcome:
        """Hands a task to the process and reads its answers until the last one."""
        process = self._process
        if process is None or process.poll() is not None:
            process = self._process = _new_process()
        try:
            _pipe(process.stdin).write(json.dumps(task) + "\n")
            _pipe(process.stdin).flush()
            for line in _pipe(process.stdout):
                answer = json.loads(line)
                if "iteration" in answer:
                    self._on_progress(_progress(answer))
                else:
                    return _outcome(answer)
        except (OSError, ValueError):
            pass
        return Outcome(None, "stopped")


def _progress(answer: dict[str, Any]) -> SolvingProgress:
    return SolvingProgress(answer["stage"], answer["iteration"], answer["cost"], answer["violation"])


def _outcome(answer: dict[str, Any]) -> Outcome:
    file, data = answer["file"], answer.get("diagnosis")
    diagnosis = None
    if data is not None:
        reasons = tuple(Reason(**reason) for reason in data["reasons"])
        diagnosis = Diagnosis(reasons, tuple(Suggestion(**each) for each in data["suggestions"]))
    return Outcome(None if file is None else Path(file), answer["message"], diagnosis)


def _new_process() -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "rollgait.view.solver_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        encoding="utf-8",
    )


def _pipe(stream: IO[str] | None) -> IO[str]:
    if stream is None:
        raise OSError
    return stream
