"""Work on the cores of this machine, or wherever joblib's backend carries it; workers may die on the way."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from itertools import islice
from typing import Any, Final, TypeVar

from rollgait.errors import RollgaitError

THREAD_VARIABLES: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables by which the linear algebra below the solvers learns how many threads it may use."""
IN_FLIGHT: Final = 2
"""Jobs per worker that are handed out at once, so that none waits for the next."""
PORTION: Final = 8
"""Jobs per worker that are handed out at once to a backend that returns all of them together: it waits for
the slowest, so they must be several."""
SUSPECT: Final = 2
"""A job that was handed out when so many workers died is tried alone, to know whether it kills them."""
LOOK: Final = 1.0
"""Between two looks of a worker whether its parent is there, s."""
LOSSES: Final = {
    "concurrent.futures.process": "BrokenProcessPool",
    "distributed.scheduler": "KilledWorker",
    "ray.exceptions": "RayError",
}
"""By which error each carrier says that a worker is gone: module and name."""

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")


def results(
    call: Callable[[JobT], ResultT],
    jobs: Iterable[JobT],
    workers: int,
    died: Callable[[JobT], ResultT],
) -> Iterator[ResultT]:
    """What `call` makes of each job, as they come; jobs are taken one by one, as they are needed.

    If a worker dies, all that was handed out is tried again, and what was there at `SUSPECT` deaths alone:
    most deaths are of a machine, not of a job, and one job at a time leaves the other cores idle.

    Args:
        call: is run in the workers; must not raise.
        jobs: what can be sent to a worker.
        workers: how many at once; −1: one for each core (or worker of the cluster).
        died: the result of a job that killed its worker when it was alone.

    Raises:
        RollgaitError: workers die even without a job.
    """
    numbered = enumerate(jobs)
    open_jobs: dict[int, JobT] = {}

    def handed_out(again: list[int]) -> Iterator[tuple[int, JobT]]:
        for number in again:
            yield number, open_jobs[number]
        for number, job in numbered:
            open_jobs[number] = job
            yield number, job

    deaths: Counter[int] = Counter()
    again: list[int] = []
    while True:
        try:
            for number, result in _in_parallel(call, handed_out(again), workers):
                del open_jobs[number]
                yield result
            return
        except Exception as error:
            if not _is_loss(error):
                raise
        deaths.update(open_jobs.keys())
        for number in sorted(number for number in open_jobs if deaths[number] >= SUSPECT):
            yield _alone(call, open_jobs.pop(number), workers, died)
        again = sorted(open_jobs)


@contextmanager
def one_thread() -> Iterator[None]:
    """Solvers that are loaded in here use one thread each: the cores are taken by the other workers."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _alone(
    call: Callable[[JobT], ResultT], job: JobT, workers: int, died: Callable[[JobT], ResultT]
) -> ResultT:
    """The result of a job in a worker that has no other."""
    others = max(2, _count(workers))  # one would be this process
    try:
        return next(_in_parallel(call, iter([(0, job)]), others))[1]
    except Exception as error:
        if not _is_loss(error):
            raise
    try:
        list(_in_parallel(_nothing, iter([(0, None)]), others))
    except Exception as error:
        raise RollgaitError(f"no worker stays alive: {type(error).__name__}") from error
    return died(job)


def _in_parallel(
    call: Callable[[Any], ResultT], jobs: Iterator[tuple[int, Any]], workers: int
) -> Iterator[tuple[int, ResultT]]:
    from joblib import Parallel, delayed

    caller = os.getpid()
    calls = (delayed(_with_number)(call, number, job, caller) for number, job in jobs)
    settings: dict[str, Any] = {"n_jobs": workers, "batch_size": 1, "pre_dispatch": f"{IN_FLIGHT} * n_jobs"}
    try:
        parallel = Parallel(return_as="generator_unordered", **settings)
    except ValueError:  # a backend that only returns all at once (Ray's): in portions
        with Parallel(**settings) as together:  # their workers keep what they compiled
            while portion := list(islice(calls, PORTION * _count(workers))):
                yield from together(portion)
        return
    yield from parallel(calls)


def _with_number(call: Callable[[JobT], ResultT], number: int, job: JobT, caller: int) -> tuple[int, ResultT]:
    if os.getpid() != caller:
        _leave_with_parent()
    return number, call(job)


@lru_cache(maxsize=1)
def _leave_with_parent() -> None:
    """Ends this process when its parent was killed: nobody would take its results, nor end it."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _nothing(_: None) -> None:
    return None


def _count(workers: int) -> int:
    from joblib import effective_n_jobs

    return int(effective_n_jobs(workers))


def _is_loss(error: Exception) -> bool:
    """Whether an error says that a worker is gone; nothing is imported for it."""
    kinds = (getattr(sys.modules.get(module), name, None) for module, name in LOSSES.items())
    return isinstance(error, tuple(kind for kind in kinds if kind is not None))
