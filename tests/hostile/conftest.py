"""Hostile input runs in a process of its own, whose CPU time and memory are limited by the system."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

CPU_TIME = 5
"""That an answer may take beyond the imports, s of CPU time: a busy machine changes nothing."""
MEMORY = 500_000_000
"""That an answer may take beyond an idle process, bytes of address space."""

IDLE = """
import resource
import rollgait.cli.app, rollgait.planner, rollgait.view.clip, rollgait.view.mpc_clip, rollgait.mpc.setup
peak = next(line for line in open("/proc/self/status") if line.startswith("VmPeak"))
used = resource.getrusage(resource.RUSAGE_SELF)
print(1024 * int(peak.split()[1]), used.ru_utime + used.ru_stime)
"""
"""A process that has loaded what the commands load, and does nothing: its address space and CPU time."""
COMMAND = "import sys; from rollgait.cli.app import run; sys.exit(run())"


@dataclass(frozen=True)
class Limits:
    """Of a process: address space, bytes, and CPU time, s."""

    memory: int
    cpu: int

    def apply(self) -> None:
        """In the child, before it begins."""
        resource.setrlimit(resource.RLIMIT_AS, (self.memory, self.memory))
        resource.setrlimit(resource.RLIMIT_CPU, (self.cpu, self.cpu))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


@dataclass(frozen=True)
class Answer:
    """What came of a process, and which files it left beside those that were there."""

    status: int
    out: str
    error: str
    written: frozenset[str]

    def assert_refused(self, *words: str) -> str:
        """Exit status 2, one readable sentence with these words, nothing written; returns the sentence."""
        assert (self.status, self.out) == (2, ""), self
        assert self.error.startswith("error: "), self
        sentence = self.error.removesuffix("\n")
        assert sentence.isprintable(), self
        assert len(sentence) < 2100, self
        for word in words:
            assert word in sentence, self
        assert not self.written, self
        return sentence


Run = Callable[..., Answer]


@pytest.fixture(scope="session")
def limits() -> Limits:
    """What an idle process takes, and the budget on top."""
    done = subprocess.run([sys.executable, "-c", IDLE], capture_output=True, text=True, check=True)
    memory, cpu = done.stdout.split()
    return Limits(int(memory) + MEMORY, round(float(cpu) + 0.5) + CPU_TIME)


@pytest.fixture
def snippet(limits: Limits, tmp_path: Path) -> Run:
    """Runs Python text with arguments, in the folder `tmp_path` and within the limits."""

    def run(text: str, arguments: Sequence[str] = (), environment: dict[str, str] | None = None) -> Answer:
        before = {str(path) for path in tmp_path.rglob("*")}
        done = subprocess.run(
            [sys.executable, "-c", text, *arguments],
            cwd=tmp_path,
            env=os.environ | (environment or {}),
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
            preexec_fn=limits.apply,
            check=False,
        )
        after = {str(path) for path in tmp_path.rglob("*")}
        return Answer(done.returncode, done.stdout, done.stderr, frozenset(after - before))

    return run


@pytest.fixture
def rollgait(snippet: Run) -> Run:
    """Runs a command: `rollgait("check", "plan.npz")`, in the folder `tmp_path` and within the limits."""

    def run(*arguments: str) -> Answer:
        return snippet(COMMAND, arguments)

    return run
