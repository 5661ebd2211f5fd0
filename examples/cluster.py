"""Plan many scenarios on a Dask cluster: here one on this machine; the same call uses a hundred machines.

pip install 'rollgait[cluster]'
python examples/cluster.py [folder]     (writes into ./out if no folder is given; again: only what is missing)
"""

import sys
from pathlib import Path

import dask.config
import joblib
import numpy as np
from dask.distributed import Client, LocalCluster

import rollgait as rg
from rollgait.parallel import DASK_SETTINGS

GOALS = 8


def main(folder: Path) -> None:
    generator = np.random.default_rng(seed=1)
    base = rg.find_scenario("wheeled").with_values({"horizon": 8.0})
    scenarios = {
        f"goal-{number}": base.with_values(
            {"goal": {"x": x, "y": y, "yaw_deg": yaw_deg}}  # m, m, degrees
        )
        for number, (x, y, yaw_deg) in enumerate(
            generator.uniform([-1.0, -0.5, -60.0], [1.0, 0.5, 60.0], (GOALS, 3)).round(2).tolist()
        )
    }
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
        outcomes = rg.plan_many(scenarios, folder=folder / "cluster")

    print("  scenario   goal x m   y m   yaw deg   result")
    for outcome in outcomes:
        goal = scenarios[outcome.name].goal
        result = "certified" if outcome.certified else outcome.error or "not certified"
        print(f"  {outcome.name:<8} {goal.x:10.2f} {goal.y:5.2f} {goal.yaw_deg:9.1f}   {result}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
