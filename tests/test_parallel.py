"""Work on many cores: every job has one result, whoever dies."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
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


def own_number(job: int) -> tuple[int, int]:
    """The second job takes long."""
    time.sleep(1.0 if job == 1 else 0.05)
    return job, os.getpid()


def test_a_worker_that_is_killed_with_nothing_to_do_is_missed_by_nobody() -> None:
    found = []
    for job, pid in results(own_number, range(2), 2, lambda job: (job, 0)):
        found.append(job)
        if job == 0:
            os.kill(pid, signal.SIGKILL)
    assert sorted(found) == [0, 1]


def test_deaths_before_a_job_is_begun_do_not_count(tmp_path: Path) -> None:
    """Both workers are killed while they wait, then job 3 ends its process once: it is done all the same."""
    call = partial(squared_by, marks=tmp_path)
    come = results(call, iter(range(12)), 2, lambda job: (-job, 0))
    found, pids = [], set()
    for square, pid in come:
        found.append(square)
        pids.add(pid)
        if len(found) == 2:
            time.sleep(0.3)  # both have nothing left to do
            for each in pids:
                _kill(each)
    assert sorted(found) == [job * job for job in range(12)]


def squared_by(job: int, marks: Path) -> tuple[int, int]:
    return squared(job, marks, deadly=False), os.getpid()


def broken(job: int) -> object:
    """Raises, or returns what cannot be sent."""
    if job == 0:
        raise KeyError("of a job")
    return threading.Lock()


@pytest.mark.parametrize(("job", "error", "text"), [(0, KeyError, "of a job"), (1, RollgaitError, "be sent")])
def test_what_a_job_raises_is_raised_and_no_process_is_left(
    job: int, error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text) as caught:
        list(results(broken, [job], 2, lambda job: job))
    assert error is RollgaitError or "in broken" in caught.value.__notes__[0]
    assert not _children()


class Unreadable:
    """Can be sent, and not be read: reading it raises, or ends whoever reads it."""

    def __init__(self, ends: bool) -> None:
        self._ends = ends

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        return (sys.exit, ("now",)) if self._ends else (int, ("no number",))


@pytest.mark.parametrize("ends", [False, True])
@pytest.mark.parametrize("way", ["there", "back"])
def test_what_cannot_be_read_is_said(way: str, ends: bool) -> None:
    call = (lambda _: Unreadable(ends)) if way == "back" else str
    with pytest.raises(
        RollgaitError, match=r"cannot .*read.*: (SystemExit: now|ValueError: invalid literal)"
    ):
        list(results(call, [Unreadable(ends)] if way == "there" else [1], 2, str))


class WordyError(Exception):
    """Cannot be read where it has been sent to."""

    def __init__(self, one: str, other: str) -> None:
        super().__init__(f"{one} and {other}")


def wordy(_: int) -> None:
    raise WordyError("this", "that")


def test_an_error_that_cannot_be_read_is_said_in_its_words() -> None:
    with pytest.raises(RollgaitError, match="WordyError in a worker: this and that"):
        list(results(wordy, [1], 2, lambda _: None))


@pytest.mark.parametrize("what", ["call", "job"])
def test_what_cannot_be_sent_is_refused_and_no_process_is_left(what: str) -> None:
    lock = threading.Lock()
    call = (lambda _: lock) if what == "call" else str
    with pytest.raises(RollgaitError, match="cannot be sent to another process"):
        list(results(call, [lock], 2, str))
    assert not _children()


def stolen(how: str) -> str:
    """Reads what it has no business with, or writes where it should not."""
    if how == "input":
        with pytest.raises(EOFError):
            input()
    elif how == "program":
        return subprocess.run(["cat"], stdout=subprocess.PIPE, text=True, check=True).stdout
    elif how == "print":
        print("something that was printed")
        os.write(1, b"something else\n")
    elif how == "exit":
        sys.exit(0)
    return ""


@pytest.mark.parametrize("how", ["input", "program", "print"])
def test_jobs_may_read_and_print(how: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert list(results(stolen, [how] * 4, 2, lambda _: "died")) == [""] * 4
    if how == "print":
        assert capfd.readouterr().err.count("something") == 8


def test_a_job_that_ends_its_process_is_as_one_that_crashes(capfd: pytest.CaptureFixture[str]) -> None:
    assert sorted(results(stolen, ["exit", ""], 2, lambda _: "died")) == ["", "died"]
    assert capfd.readouterr().err == ""


def threads(_: int) -> int:
    """How many there are; NumPy's library starts its own as it is loaded."""
    return len(list(Path("/proc/self/task").iterdir()))


def test_linear_algebra_in_a_worker_has_one_thread() -> None:
    """The job's, the one that listens and the one that watches: no more."""
    assert list(results(threads, [0], 2, lambda _: 0)) == [3]


def test_workers_that_die_as_they_begin_are_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", ["/nowhere"])
    with pytest.raises(RollgaitError, match="no worker stays alive"):
        list(results(large, range(4), 2, lambda job: (job, 0, b"")))


def _children() -> list[str]:
    """Processes of this one that do jobs."""
    here = f"/proc/self/task/{threading.get_native_id()}/children"
    pids = Path(here).read_text(encoding="ascii").split()
    return [pid for pid in pids if b"parallel.member" in Path(f"/proc/{pid}/cmdline").read_bytes()]


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
