"""Planning the rows of a data set that are not there yet."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.counted import counted
from rollgait.dataset import columns
from rollgait.dataset.dataset import Dataset
from rollgait.dataset.sampler import Sampler
from rollgait.dataset.spec import Spec
from rollgait.dataset.store import Store
from rollgait.errors import InputError, NotSolvedError, RollgaitError
from rollgait.files import check_writable
from rollgait.parallel import one_thread, results

WINDOW: Final = 4096
"""So many rows are put in order at a time: those of a kind come one after the other, and so a worker derives,
or reads and compiles, the code of a kind once; and no more than these need be held."""


def plan_dataset(
    spec: Spec | str | Path,
    folder: str | Path | None = None,
    *,
    workers: int = -1,
    quiet: bool = False,
) -> Dataset:
    """Plans all rows of a data set that are not there yet, each as soon as a worker is free.

    The work is done by processes of this machine; inside `joblib.parallel_config(backend="dask")` (or "ray")
    by a cluster. A call that was interrupted, by Ctrl-C
    or by a failure of the machine, is resumed by repeating it.

    Args:
        spec: the data set, or its YAML file.
        folder: where it is written. Default: named like the YAML file, without its suffix.
        workers: how many at once, each with one thread; −1: one for each core (or worker of the cluster).
        quiet: shows no progress.

    Returns:
        The data set.

    Raises:
        InputError: the spec or the number of workers is wrong, all first rows of a family contradict
            themselves, or the folder holds another data set.
        FileError: the folder cannot be written to, or another process is writing it.
        MissingExtraError: the extra `dataset` is not installed.
    """
    if workers == 0 or workers < -1:
        raise InputError("workers", workers, "must be a number of processes, or −1 for all cores")
    columns.arrow()
    sampler, target = _read(spec, folder)
    sampler.require_sense()
    check_writable(target / "dataset.json")
    store = Store.create(target, sampler)
    worker = Worker(store.sampler)
    with store.writing():
        done = store.planned()
        rows = _in_order(store.sampler, done)
        with counted(len(done), int(done.sum()), quiet, lines=True) as advance:
            for row, content in results(worker.plan, rows, workers, worker.died):
                store.add(row, content)
                advance()
        store.merge()
    return Dataset(target)


def _read(spec: Spec | str | Path, folder: str | Path | None) -> tuple[Sampler, Path]:
    if isinstance(spec, Spec):
        if folder is None:
            raise InputError("folder", None, "must be given where the spec is in no file")
        return Sampler.of(spec), Path(folder)
    path = Path(spec)
    return Sampler.of(Spec.from_yaml(path), path.parent), Path(folder or path.with_suffix(""))


def _in_order(sampler: Sampler, done: NDArray[np.bool_]) -> Iterator[int]:
    """The rows that are not there, in windows sorted by their kind."""
    missing = (row for row in range(len(done)) if not done[row])
    while window := list(islice(missing, WINDOW)):
        yield from sorted(window, key=lambda row: sampler.asked(row).kind)


@dataclass(frozen=True)
class Worker:
    """What plans a row, in another process. Whatever goes wrong becomes the row's reason."""

    sampler: Sampler

    @cached_property
    def _store(self) -> Store:
        return Store(Path(), self.sampler)  # for its columns; a worker has no folder

    def __getstate__(self) -> dict[str, Any]:
        return {"sampler": self.sampler}

    def plan(self, row: int) -> tuple[int, bytes]:
        """A row, and what its file holds."""
        return row, self._store.encoded(self._record(row))

    def died(self, row: int) -> tuple[int, bytes]:
        """The row that killed its worker."""
        reason = "the process that planned it died"
        found = columns.record(self.sampler, self.sampler.asked(row), columns.DIED, reason, 0.0)
        return row, self._store.encoded(found)

    def _record(self, row: int) -> columns.Record:
        begin = time.perf_counter()
        found: columns.Record = {}
        asked = self.sampler.asked(row)
        try:
            found = self._planned(row)
            status, reason = found.pop("status"), found.pop("reason")
        except InputError as error:
            status, reason = columns.REFUSED, str(error)
        except NotSolvedError as error:
            status, reason = columns.NOT_SOLVED, str(error)
        except RollgaitError as error:
            status, reason = columns.FAULTY, str(error)
        except Exception as error:
            status, reason = columns.FAULTY, f"unexpected {type(error).__name__}: {error}"
        seconds = time.perf_counter() - begin
        return columns.record(self.sampler, asked, status, reason, seconds) | found

    def _planned(self, row: int) -> columns.Record:
        """What a row says of its plan."""
        spec = self.sampler.spec
        scenario = self.sampler.scenario(self.sampler.asked(row))
        with one_thread():
            from rollgait.planner import plan

            found = plan(scenario, multistart=spec.starts, seed=row, diagnose=spec.diagnose)
        stored = columns.as_stored(found)
        failures = stored.certificate().failures
        reason = "; ".join(" ".join(str(one).split()) for one in failures)
        status = columns.NOT_CERTIFIED if failures else columns.CERTIFIED
        return {**columns.columns_of(stored), "status": status, "reason": reason}
