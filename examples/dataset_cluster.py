"""Plan a library of motions on Dask or Ray: here on this machine; the same call uses a hundred machines.

pip install 'rollgait[dataset,cluster]'
python examples/dataset_cluster.py [folder] [dask|ray]  (default: ./out, dask; again: only what is missing)
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import joblib

import rollgait as rg
from rollgait.dataset import Spec
from rollgait.parallel import DASK_SETTINGS

SPEC = Spec.from_dict(
    {
        "count": 8,
        "seed": 1,
        "families": {
            "drive": {"base": "wheeled", "vary": {"goal.yaw_deg": {"uniform": [-30, 30]}}},
            "hybrid": {"base": "hybrid-forward", "vary": {"ground.friction": {"uniform": [0.4, 0.8]}}},
        },
        "vary": {"goal.x": {"uniform": [0.0, 1.0]}},
    }
)


@contextmanager
def on_dask() -> Iterator[None]:
    import dask.config
    from dask.distributed import Client, LocalCluster

    with (
        dask.config.set(DASK_SETTINGS),
        LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            dashboard_address=":0",
        ) as cluster,
        Client(cluster),
        joblib.parallel_config(backend="dask"),
    ):
        yield


@contextmanager
def on_ray() -> Iterator[None]:
    ray = import_module("ray")  # no extra of rollgait brings it: pip install ray
    ray.init(num_cpus=2, include_dashboard=False)
    import_module("ray.util.joblib").register_ray()
    with joblib.parallel_config(backend="ray", n_jobs=2):
        yield


def main(folder: Path, engine: str) -> None:
    with on_ray() if engine == "ray" else on_dask():
        library = rg.plan_dataset(SPEC, folder / "library")
    print(library)
    print(library.stats().statuses)


if __name__ == "__main__":
    place, engine, *_ = [*sys.argv[1:], *("out", "dask")[len(sys.argv) - 1 :]]
    main(Path(place), engine)
