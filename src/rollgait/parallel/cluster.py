"""Work on a cluster, of Dask or of Ray, whose workers may die.

joblib names the cluster, and does not carry the work: it waits for ever for a job whose workers died.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from itertools import islice
from typing import Any, Final, Generic, Protocol, TypeVar

IN_FLIGHT: Final = 2
"""Jobs per worker that are handed out at once, so that none waits for the next."""
RETRIES: Final = 1
"""How often Ray does a job again whose worker died; Dask has a number of its own."""

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")
HandleT = TypeVar("HandleT", bound=Hashable)


class LostError(Exception):
    """Workers died where a job was, again and again."""


class Cluster(Protocol[HandleT]):
    """What a cluster does with jobs."""

    def submit(self, job: Any) -> HandleT:
        """Has a job done, some time."""

    def one_done(self, handles: list[HandleT]) -> HandleT:
        """Waits for any of several."""

    def result(self, handle: HandleT) -> Any:
        """What came of one that is done. Raises `LostError`, or what the job raised."""

    def cancel(self, handles: list[HandleT]) -> None:
        """Takes jobs back."""


def results_of_cluster(
    cluster: Cluster[HandleT],
    jobs: Iterable[JobT],
    count: int,
    died: Callable[[JobT], ResultT],
) -> Iterator[ResultT]:
    """As `results`, by so many workers of a cluster."""
    jobs = iter(jobs)
    waiting: dict[HandleT, JobT] = {}
    suspects: list[JobT] = []
    try:
        while True:
            waiting.update(
                (cluster.submit(job), job) for job in islice(jobs, IN_FLIGHT * count - len(waiting))
            )
            if not waiting:
                break
            done = cluster.one_done(list(waiting))
            try:
                yield cluster.result(done)
            except LostError:
                suspects.append(waiting[done])
            del waiting[done]
    finally:
        cluster.cancel(list(waiting))
    for job in suspects:  # each alone: those that merely were where another died are cleared
        try:
            yield cluster.result(cluster.one_done([cluster.submit(job)]))
        except LostError:
            yield died(job)


class Dask(Generic[JobT, ResultT]):
    """A cluster of Dask, by its client."""

    def __init__(self, client: Any, call: Callable[[JobT], ResultT]) -> None:
        self._client, self._call = client, call

    def submit(self, job: JobT) -> Any:
        return self._client.submit(self._call, job, pure=False)

    def one_done(self, handles: list[Any]) -> Any:
        from distributed import wait

        return next(iter(wait(handles, return_when="FIRST_COMPLETED").done))

    def result(self, handle: Any) -> ResultT:
        from distributed import KilledWorker

        try:
            found: ResultT = handle.result()
        except KilledWorker:
            raise LostError from None
        return found

    def cancel(self, handles: list[Any]) -> None:
        self._client.cancel(handles)


class Ray(Generic[JobT, ResultT]):
    """The cluster of Ray that this process belongs to."""

    def __init__(self, call: Callable[[JobT], ResultT]) -> None:
        import ray

        def done(call: Callable[[JobT], ResultT], job: JobT) -> ResultT:
            return call(job)

        self._ray = ray
        self._call = ray.put(call)
        self._done = ray.remote(max_retries=RETRIES)(done)

    def submit(self, job: JobT) -> Any:
        return self._done.remote(self._call, job)

    def one_done(self, handles: list[Any]) -> Any:
        return self._ray.wait(handles, num_returns=1)[0][0]

    def result(self, handle: Any) -> ResultT:
        try:
            found: ResultT = self._ray.get(handle)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from None
        except self._ray.exceptions.RayError:
            raise LostError from None
        return found

    def cancel(self, handles: list[Any]) -> None:
        for handle in handles:
            self._ray.cancel(handle)
