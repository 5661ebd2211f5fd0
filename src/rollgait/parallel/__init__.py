"""Work on the cores of this machine, or wherever joblib's backend carries it; workers may die on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Final, TypeVar

from rollgait.parallel.cluster import DASK_SETTINGS as DASK_SETTINGS
from rollgait.parallel.cluster import Dask, Ray, results_of_cluster
from rollgait.parallel.crew import results_of_crew
from rollgait.parallel.threads import one_thread as one_thread

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
    chosen by `joblib.parallel_config`. Deaths of workers are survived here, on Dask and on Ray.

    Args:
        call: is run in the workers; what it raises is raised here, and the work ends.
        jobs: what can be sent to a worker.
        workers: how many at once; −1: one for each core (or worker of the cluster).
        died: the result of a job that kills its worker time and again.

    Raises:
        RollgaitError: workers die even without a job, or something cannot be sent to them.
    """
    from joblib import effective_n_jobs
    from joblib.parallel import get_active_backend

    backend, _ = get_active_backend()
    count = int(effective_n_jobs(workers))
    match type(backend).__name__:
        case "DaskDistributedBackend":
            return results_of_cluster(Dask(backend.client, backend.submit_kwargs, call), jobs, count, died)
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
    """By a backend of joblib of which nothing is known."""
    from joblib import Parallel, delayed

    calls = (delayed(call)(job) for job in jobs)
    try:
        parallel = Parallel(n_jobs=count, batch_size=1, return_as="generator_unordered")
    except ValueError:  # one that only returns all at once: in portions
        with Parallel(n_jobs=count) as together:
            while portion := list(islice(calls, PORTION * count)):
                yield from together(portion)
        return
    yield from parallel(calls)
