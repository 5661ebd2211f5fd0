"""Work on the cores of this machine, or wherever joblib's backend carries it; workers may die on the way."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from typing import Final, TypeVar

from rollgait.parallel.cluster import Dask, Ray, results_of_cluster
from rollgait.parallel.crew import results_of_crew

THREAD_VARIABLES: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables by which the linear algebra below the solvers learns how many threads it may use."""
PORTION: Final = 8
"""Jobs per worker that are handed out at once where all are waited for: also for the slowest, so several."""

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")


def results(
    call: Callable[[JobT], ResultT],
    jobs: Iterable[JobT],
    workers: int,
    died: Callable[[JobT], ResultT],
) -> Iterator[ResultT]:
    """What `call` makes of each job, as they come; jobs are taken one by one, as they are needed.

    One worker is this process; several are processes of this machine, or what the backend has that was
    chosen by `joblib.parallel_config`.

    Args:
        call: is run in the workers; what it raises is raised here, and the work ends.
        jobs: what can be sent to a worker.
        workers: how many at once; −1: one for each core (or worker of the cluster).
        died: the result of a job that kills its worker time and again.

    Raises:
        RollgaitError: workers die even without a job.
    """
    from joblib import effective_n_jobs
    from joblib.parallel import get_active_backend

    backend, _ = get_active_backend()
    count = int(effective_n_jobs(workers))
    match type(backend).__name__:
        case "DaskDistributedBackend":
            return results_of_cluster(Dask(backend.client, call), jobs, count, died)
        case "RayBackend":
            return results_of_cluster(Ray(call), jobs, count, died)
        case "LokyBackend" if count > 1:  # joblib's choice where nobody has chosen
            return results_of_crew(call, jobs, count, died)
        case "LokyBackend":
            return map(call, jobs)
        case _:
            return _results_of_joblib(call, jobs, count)


def _results_of_joblib(
    call: Callable[[JobT], ResultT], jobs: Iterable[JobT], count: int
) -> Iterator[ResultT]:
    """By a backend of joblib of which nothing is known: in portions, as some only return all at once."""
    from joblib import Parallel, delayed

    calls = (delayed(call)(job) for job in jobs)
    with Parallel(n_jobs=count) as together:
        while portion := list(islice(calls, PORTION * count)):
            yield from together(portion)


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
