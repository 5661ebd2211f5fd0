"""A cluster on this machine, for what runs on clusters."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import joblib
import pytest


@contextmanager
def dask_cluster(*, processes: bool = False) -> Iterator[None]:
    """joblib's calls go to a Dask cluster: of one worker in this process, or of two in theirs.

    Skips the test where Dask is not installed.
    """
    distributed = pytest.importorskip("dask.distributed")
    with (
        distributed.LocalCluster(
            n_workers=1 + processes, threads_per_worker=1, processes=processes, dashboard_address=":0"
        ) as cluster,
        distributed.Client(cluster),
        joblib.parallel_config(backend="dask"),
    ):
        yield
