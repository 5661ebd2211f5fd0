"""Is a library of 2000 plans made at the rate of the cores, whole after two deaths, and small?

    python benchmarks/dataset.py [--count 2000] [--engine processes|dask|ray] [--keep DIR] [--quick]

Mixed goals and grounds (`mixed_motions.yaml`) on 2 workers. On the way a worker is killed, then the whole
run; a second run goes on. Prints Markdown and keeps it in docs/benchmarks.md: rows lost or done twice, rate
against twice that of one process which plans the same rows, memory over time, bytes per plan, rows certified
anew, and what a plan nearby is worth as a start.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import joblib
import numpy as np
from numpy.typing import NDArray

import rollgait as rg
from reporting import keep, load, machine, table
from rollgait.dataset import Sampler
from rollgait.dataset.columns import CERTIFIED
from rollgait.dataset.running import Worker
from rollgait.dataset.spec import Spec
from rollgait.parallel import DASK_SETTINGS

HERE = Path(__file__).resolve()
SPEC = HERE.with_name("mixed_motions.yaml")
WORKERS = 2
ENGINES = ("processes", "dask", "ray")
ALONE = 100
"""Rows by which the rate of one process is measured, evenly from all: 1000 would take as long as the rest."""
LOOK = 0.5
"""Between two looks at memory and progress, s."""
PATIENCE = 4 * 3600.0
"""After which a run is given up, s."""
WORKER_DIES, RUN_DIES = 0.2, 0.5
"""Shares of the rows after which each is killed."""
ANEW = 50
"""Rows that are certified anew."""
NEIGHBOURS = 40
"""New goals that are planned with and without a start nearby."""


@dataclass
class Run:
    """What was seen of the runs.

    Attributes:
        seconds: in which rows were made, of both runs, s.
        memory: MB of parent and workers, at each look, of the last run.
        killed: how the runs ended.
        twice: rows that changed after they were there.
    """

    seconds: float = 0.0
    memory: list[float] = field(default_factory=list)
    killed: list[str] = field(default_factory=list)
    twice: int = 0


class Alone:
    """One process that plans, certifies and encodes rows and does nothing else.

    It plans some of all rows: half of them before the run and half after it, as machines change their speed.

    Args:
        sampler: of the data set.
        count: rows that it plans.
    """

    def __init__(self, sampler: Sampler, count: int) -> None:
        self._worker = Worker(sampler)
        rows = np.unique(np.linspace(0, sampler.spec.count - 1, count).astype(int)).tolist()
        kinds = {row: sampler.asked(row).kind for row in rows}
        for row in {kind: row for row, kind in kinds.items()}.values():
            self._worker.plan(row)  # what is compiled once is no part of a rate
        rows.sort(key=kinds.__getitem__)
        self._halves = [rows[0::2], rows[1::2]]
        self._done: list[int] = []
        self._seconds = 0.0

    def half(self) -> None:
        """Plans the next half."""
        rows = self._halves.pop()
        begin = time.perf_counter()
        for row in rows:
            self._worker.plan(row)
        self._seconds += time.perf_counter() - begin
        self._done += rows

    def rate(self, library: rg.Dataset) -> float:
        """Rows per second of all; those not planned count by what they took in the run."""
        then = seconds_of(library)
        return len(library) * float(then[self._done].sum() / then.sum()) / self._seconds


def seconds_of(library: rg.Dataset) -> NDArray[np.float64]:
    """How long each row took in the run, by its number, s."""
    table = library.table(["seconds"])
    found = np.zeros(len(library))
    found[table["row"].to_numpy()] = table["seconds"].to_numpy()
    return found


def disturbed(file: Path, folder: Path, count: int, engine: str) -> Run:
    """Plans all rows; a worker is killed on the way, and the whole run."""
    run = Run()
    while True:
        before = {path: path.stat().st_mtime_ns for path in folder.glob("rows/row*")}
        begin, first = time.perf_counter(), planned(folder)
        process = subprocess.Popen([sys.executable, str(HERE), "--run", str(file), str(folder), engine])
        ended = watch(process, folder, count, run)
        run.seconds += time.perf_counter() - begin
        run.twice += sum(p.exists() and p.stat().st_mtime_ns != changed for p, changed in before.items())
        if ended:
            return run
        if planned(folder) <= first:
            raise SystemExit("the run makes no progress")


def watch(process: subprocess.Popen[bytes], folder: Path, count: int, run: Run) -> bool:
    """Looks at a run, and kills what is due; whether it ended by itself."""
    begin = time.perf_counter()
    run.memory.clear()
    while process.poll() is None:
        time.sleep(LOOK)
        done, family = planned(folder), descendants(process.pid)
        run.memory.append(sum(resident(pid) for pid in (process.pid, *family)))
        if not run.killed and done >= WORKER_DIES * count and (victims := workers_of(family)):
            os.kill(victims[0], signal.SIGKILL)
            run.killed.append(f"a worker after {done} rows")
        elif len(run.killed) == 1 and done >= RUN_DIES * count:
            process.kill()
            process.wait()
            run.killed.append(f"the run after {done} rows")
            return False
        if time.perf_counter() - begin > PATIENCE:
            process.kill()
            raise SystemExit("the run takes too long")
    if process.returncode != 0:
        raise SystemExit(f"the run ended with {process.returncode}")
    return True


def planned(folder: Path) -> int:
    """Rows that are there, as far as names of files tell: parts are full but for the last."""
    import pyarrow.parquet as parquet

    rows = len(list(folder.glob("rows/row*")))
    return rows + sum(parquet.read_metadata(path).num_rows for path in folder.glob("parts/part*"))


def descendants(pid: int) -> list[int]:
    """Processes below one (Linux)."""
    children: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = stat.read_text(encoding="utf-8")
        except OSError:
            continue
        parent = int(text.rpartition(")")[2].split()[1])
        children.setdefault(parent, []).append(int(stat.parent.name))
    found, waiting = [], [pid]
    while waiting:
        waiting += (own := children.get(waiting.pop(), []))
        found += own
    return found


def workers_of(pids: list[int]) -> list[int]:
    """Those that plan: more than a trifle of memory, and no parents of others that do."""
    large = [pid for pid in pids if resident(pid) > 150.0 and "raylet" not in command(pid)]
    return [pid for pid in large if not set(descendants(pid)) & set(large)]


def command(pid: int) -> str:
    """Its command line; "" if it is gone."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8")
    except OSError:
        return ""


def resident(pid: int) -> float:
    """Memory of a process that is in use, MB (Linux); 0 if it is gone."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * 4096 / 1e6
    except (OSError, IndexError):
        return 0.0


@contextmanager
def carried(engine: str) -> Iterator[None]:
    """Inside, joblib's work is done by an engine with `WORKERS` workers."""
    if engine == "dask":
        import dask.config
        from dask.distributed import Client, LocalCluster

        with (
            dask.config.set(DASK_SETTINGS),
            LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=":0") as cluster,
            Client(cluster),
            joblib.parallel_config(backend="dask"),
        ):
            yield
    elif engine == "ray":
        import ray
        from ray.util.joblib import register_ray

        ray.init(num_cpus=WORKERS, include_dashboard=False)
        register_ray()
        with joblib.parallel_config(backend="ray", n_jobs=WORKERS):
            yield
    else:
        yield


def worth(library: rg.Dataset, count: int) -> list[tuple[object, ...]]:
    """Iterations and time in the solver of new rows, from scratch and from the nearest plan."""
    sampler = library.sampler
    fresh = Sampler(
        sampler.spec.model_copy(update={"seed": sampler.spec.seed + 1}), sampler.bases, sampler.maps
    )
    figures: dict[str, dict[str, list[tuple[float, float, float]]]] = {}
    for row in range(min(count, fresh.spec.count)):
        asked = fresh.asked(row)
        scenario = fresh.scenario(asked)
        near = library.nearest(scenario)
        if not near:
            continue
        start = library.plan(near[0][0])
        try:
            plans = {"cold": rg.plan(scenario, diagnose=False)}
            plans["warm"] = rg.plan(scenario, diagnose=False, warm_start=start)
        except rg.RollgaitError:
            continue
        for name, plan in plans.items():
            s = plan.statistics
            one = (float(s.iterations), s.solve_time, s.cost)
            figures.setdefault(asked.family, {}).setdefault(name, []).append(one)
    rows = []
    for family, both in figures.items():
        cold, warm = np.array(both["cold"]), np.array(both["warm"])
        cells = [f"{a:.3g} → {b:.3g}" for a, b in zip(np.median(cold, 0), np.median(warm, 0), strict=True)]
        cheaper = int((warm[:, 2] < cold[:, 2] * (1 - 1e-3)).sum())
        dearer = int((warm[:, 2] > cold[:, 2] * (1 + 1e-3)).sum())
        rows.append((family, len(cold), cells[0], cells[1], f"{cheaper} / {dearer}"))
    return rows


def report(count: int, engine: str, folder: Path) -> str:
    """Runs all and returns the page's section."""
    before = load()
    text = SPEC.read_text(encoding="utf-8")
    file = folder.parent / "mixed_motions.yaml"
    file.write_text(text.replace("count: 2000", f"count: {count}"), encoding="utf-8")
    alone = Alone(Sampler.of(Spec.from_yaml(file), file.parent), min(ALONE, count))
    alone.half()
    run = disturbed(file, folder, count, engine)
    alone.half()
    library = rg.Dataset(folder)
    one = alone.rate(library)
    check = library.check(min(ANEW, count))
    stats = library.stats()
    rate, busy = count / run.seconds, seconds_of(library).sum()
    half = len(run.memory) // 2
    quarter = max(1, half // 2)
    rows = [
        ("rows there, lost, twice", f"{check.there}, {count - check.there}, {len(check.twice) + run.twice}"),
        ("killed", "; ".join(run.killed)),
        ("certified", f"{stats.statuses.get(CERTIFIED, 0)} of {count}"),
        ("certified anew, wrong", f"{len(check.certified)}, {len(check.wrong)}"),
        ("rows per second of one process", f"{one:.2f}"),
        ("seconds of workers: in rows, of all", f"{busy:.0f}, {WORKERS * run.seconds:.0f}"),
        (f"of {WORKERS} workers, both runs, starts and deaths included", f"{rate:.2f}"),
        ("share of twice one process", f"{100 * rate / (WORKERS * one):.0f} %"),
        (
            "memory of all processes in the last run, MB: median of its third and its last quarter, most",
            f"{np.median(run.memory[half : half + quarter]):.0f}, {np.median(run.memory[-quarter:]):.0f}, "
            f"{max(run.memory):.0f}",
        ),
        ("kB per plan, all files", f"{stats.bytes_per_row / 1e3:.1f}"),
    ]
    statuses = [(name, *(own.get(s, 0) for s in stats.statuses)) for name, own in stats.families.items()]
    parts = [
        f"## A data set of {count} plans, {engine}",
        f"{machine()}; load {before} before, {load()} after.",
        table(("what", "measured"), rows),
        table(("family", *stats.statuses), statuses),
    ]
    if engine == "processes":
        columns = ("start from the nearest plan", "goals", "iterations", "solver, s", "cheaper / dearer")
        parts.append(table(columns, worth(library, NEIGHBOURS)))
    return "\n\n".join(parts)


def main() -> None:
    """Measures and prints the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="rows (default: 2000)")
    parser.add_argument("--engine", choices=ENGINES, default="processes", help="what carries the work")
    parser.add_argument("--keep", type=Path, help="folder for the data set (default: a temporary one)")
    parser.add_argument("--quick", action="store_true", help="twelve rows, to see that it works")
    parser.add_argument("--run", nargs=3, metavar=("SPEC", "DIR", "ENGINE"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.run:
        spec, folder, engine = options.run
        with carried(engine):
            rg.plan_dataset(spec, folder, workers=WORKERS, quiet=False)
        return
    count = 12 if options.quick else options.count
    place = options.keep or Path(tempfile.mkdtemp())
    place.mkdir(parents=True, exist_ok=True)
    try:
        text = report(count, options.engine, place / "library")
    finally:
        if options.keep is None:
            shutil.rmtree(place, ignore_errors=True)
    print(text)
    if not options.quick:
        keep(f"dataset-{options.engine}", text)


if __name__ == "__main__":
    main()
