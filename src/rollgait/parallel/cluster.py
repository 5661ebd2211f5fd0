"""Work on a cluster, of Dask or of Ray, whose workers may die.

joblib names the cluster, and does not carry the work: it waits for ever for a job whose workers died.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Any, Final, Generic, Protocol, TypeVar

from rollgait.errors import RollgaitError

IN_FLIGHT: Final = 2
"""Jobs per worker that are handed out at once, so that none waits for the next."""
RETRIES: Final = 1
"""How often Ray does a job again whose worker died; Dask has a number of its own."""
DASK_SETTINGS: Final[Mapping[str, Any]] = {
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
}
"""For `dask.config.set` where workers are started. Dask has them give memory back at once; solvers ask for it
again in their next iteration, and plans take 8 % longer."""

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")
HandleT = TypeVar("HandleT", bound=Hashable)


class LostError(Exception):
    """Workers died where a job was, again and again."""


class Cluster(Protocol[HandleT]):
    """What a cluster does with jobs."""

    def submit(self, job: Any) -> HandleT:
        """Has a job done, some time."""

    def one_done(self) -> HandleT:
        """Waits for any of those that are not done yet."""

    def result(self, handle: HandleT) -> Any:
        """What came of one that is done. Raises `LostError`, or what the job raised."""

    def cancel(self, handles: list[HandleT]) -> None:
        """Takes jobs back."""

    def does_nothing(self) -> None:
        """Does a job that nobody can die of. Raises `LostError`."""


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
            more = islice(jobs, IN_FLIGHT * max(count, 1) - len(waiting))
            waiting.update((cluster.submit(job), job) for job in more)
            if not waiting:
                break
            done = cluster.one_done()
            job = waiting.pop(done)
            try:
                yield cluster.result(done)
            except LostError:
                suspects.append(job)
        for job in suspects:  # each alone: those that merely were where another died are cleared
            waiting[cluster.submit(job)] = job
            done = cluster.one_done()
            del waiting[done]
            try:
                yield cluster.result(done)
            except LostError:
                _require_life(cluster)
                yield died(job)
    finally:
        cluster.cancel(list(waiting))


def _require_life(cluster: Cluster[HandleT]) -> None:
    """Raises `RollgaitError` if workers die of nothing."""
    try:
        cluster.does_nothing()
    except LostError:
        raise RollgaitError("no worker stays alive, even without a job") from None


class Dask(Generic[JobT, ResultT]):
    """A cluster of Dask, by its client; `settings` as `joblib.parallel_config` had them."""

    def __init__(self, client: Any, settings: Mapping[str, Any], call: Callable[[JobT], ResultT]) -> None:
        from distributed import as_completed

        self._client, self._settings, self._call = client, settings, call
        self._come = as_completed(loop=client.loop, raise_errors=False)

    def submit(self, job: JobT) -> Any:
        handle = self._client.submit(self._call, job, pure=False, **self._settings)
        self._come.add(handle)
        return handle

    def one_done(self) -> Any:
        return next(self._come)

    def result(self, handle: Any) -> ResultT:
        from distributed import KilledWorker

        try:
            found: ResultT = handle.result()
        except KilledWorker:
            raise LostError from None
        return found

    def cancel(self, handles: list[Any]) -> None:
        self._client.cancel(handles)

    def does_nothing(self) -> None:
        self.result(self._client.submit(_nothing, pure=False, **self._settings))


class Ray(Generic[JobT, ResultT]):
    """The cluster of Ray that this process belongs to."""

    def __init__(self, call: Callable[[JobT], ResultT]) -> None:
        import ray

        self._ray, self._waiting = ray, list[Any]()
        self._call = ray.put(call)
        self._done = ray.remote(max_retries=RETRIES)(_done)
        kinds = ("WorkerCrashedError", "OutOfMemoryError", "NodeDiedError", "ObjectLostError")
        self._losses = tuple(getattr(ray.exceptions, kind) for kind in kinds)

    def submit(self, job: JobT) -> Any:
        self._waiting.append(self._done.remote(self._call, job))
        return self._waiting[-1]

    def one_done(self) -> Any:
        (done,), self._waiting = self._ray.wait(self._waiting, num_returns=1)
        return done

    def result(self, handle: Any) -> ResultT:
        try:
            found: ResultT = self._ray.get(handle)
        except self._losses:
            raise LostError from None
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from None
        return found

    def cancel(self, handles: list[Any]) -> None:
        for handle in handles:
            self._ray.cancel(handle)

    def does_nothing(self) -> None:
        self.result(self._ray.remote(_nothing).remote())


def _done(call: Callable[[JobT], ResultT], job: JobT) -> ResultT:
    return call(job)


def _nothing() -> None:
    return None
