"""Work on many cores: every job has one result, whoever dies."""

from __future__ import annotations

import os
import random
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import joblib
import pytest

from rollgait.counted import EVERY, Rate, duration
from rollgait.errors import RollgaitError
from rollgait.parallel import crew, results
from tests.clusters import dask_cluster

LARGE = 200_000
"""Bytes of a result: several times what a pipe holds, so that a process is often killed as it writes."""


def squared(job: int, marks: Path, deadly: bool) -> int:
    """Ends its process at 3: always, or only the first time."""
    mark = marks / "died"
    if job == 3 and (deadly or not mark.exists()):
        mark.touch()
        os._exit(9)
    return job * job


@pytest.mark.parametrize("deadly", [False, True])
def test_a_dead_worker_loses_no_job_and_does_none_twice(tmp_path: Path, deadly: bool) -> None:
    call = partial(squared, marks=tmp_path, deadly=deadly)
    found = list(results(call, iter(range(12)), 2, lambda job: -job))
    assert sorted(found) == sorted(-3 if deadly and job == 3 else job * job for job in range(12))


@pytest.mark.slow
@pytest.mark.parametrize("deadly", [False, True])
def test_so_it_is_on_a_cluster(tmp_path: Path, deadly: bool) -> None:
    call = partial(squared, marks=tmp_path, deadly=deadly)
    with dask_cluster(processes=True):
        found = list(results(call, iter(range(12)), 2, lambda job: -job))
    assert sorted(found) == sorted(-3 if deadly and job == 3 else job * job for job in range(12))


def large(job: int) -> tuple[int, int, bytes]:
    return job, os.getpid(), bytes(LARGE)


def test_a_worker_that_is_killed_in_the_middle_of_a_sentence_stops_nobody() -> None:
    """Whenever it is killed: 12 times in one run, as its results come."""
    order = random.Random(0)
    kill_at = set(order.sample(range(5, 150), 12))
    found = []
    for count, (job, pid, _) in enumerate(results(large, range(200), 2, lambda job: (job, 0, b""))):
        found.append(job)
        if count in kill_at:
            threading.Timer(order.uniform(0.0, 2e-3), _kill, [pid]).start()
    assert sorted(found) == list(range(200))


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):  # another was faster
        os.kill(pid, signal.SIGKILL)


def test_a_job_is_given_up_only_for_deaths_while_it_was_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one that waited behind it in the same process is done by another, however often that dies."""
    monkeypatch.setattr(crew, "SUSPECT", 5)
    given_up: list[int] = []

    def died(job: int) -> int:
        given_up.append(job)
        return -job

    call = partial(squared, marks=tmp_path, deadly=True)
    assert len(list(results(call, range(8), 2, died))) == 8
    assert given_up == [3]


def broken(job: int) -> object:
    """Raises, or returns what cannot be sent."""
    if job == 0:
        raise KeyError("of a job")
    return threading.Lock()


@pytest.mark.parametrize(("job", "error", "text"), [(0, KeyError, "of a job"), (1, RollgaitError, "be sent")])
def test_what_a_job_raises_is_raised_and_no_process_is_left(
    job: int, error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        list(results(broken, [job], 2, lambda job: job))


class Unreadable:
    """Can be sent, and not be read."""

    def __reduce__(self) -> tuple[Callable[[str], int], tuple[str]]:
        return int, ("no number",)


@pytest.mark.parametrize("way", ["there", "back"])
def test_what_cannot_be_read_is_said(way: str) -> None:
    call = (lambda _: Unreadable()) if way == "back" else str
    with pytest.raises(RollgaitError, match=r"cannot .*read.*: ValueError: invalid literal"):
        list(results(call, [Unreadable()] if way == "there" else [1], 2, str))


def test_workers_that_die_as_they_begin_are_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", ["/nowhere"])
    with pytest.raises(RollgaitError, match="no worker stays alive"):
        list(results(large, range(4), 2, lambda job: (job, 0, b"")))


def test_no_worker_outlives_the_work() -> None:
    come = results(large, iter(range(1000)), 2, lambda job: (job, 0, b""))
    _, pid, _ = next(come)
    assert pid != os.getpid()
    os.kill(pid, 0)
    close(come)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize("workers", [1, 2])
def test_jobs_are_taken_as_they_are_needed(workers: int) -> None:
    taken = []

    def jobs() -> Iterator[int]:
        for job in range(1000):
            taken.append(job)
            yield job

    come = results(abs, jobs(), workers, abs)
    assert next(come) in range(workers)
    assert len(taken) < 10
    close(come)


@pytest.mark.parametrize("backend", ["multiprocessing", "threading", "sequential", "loky"])
def test_any_backend_of_joblib_will_do(backend: str) -> None:
    with joblib.parallel_config(backend=backend):
        assert sorted(results(abs, range(50), 2, abs)) == list(range(50))


def close(come: Iterator[object]) -> None:
    if (end := getattr(come, "close", None)) is not None:  # one worker: a `map`
        end()


def test_a_log_says_rate_and_remaining_time() -> None:
    now = 0.0
    rate = Rate(100, 20, "planning", lambda: now)
    assert rate.advance() is None
    now = EVERY
    assert rate.advance() == "planning: 22 of 100, 0.0333 per second, 39 min left"
    assert [duration(s) for s in (40.0, 7200.0, 86400.0 * 3)] == ["40 s", "2.0 h", "3.0 days"]
