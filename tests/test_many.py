"""Many plans at once: in order, each on its own, resumable, on whatever joblib offers."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import FileError, MissingExtraError, RollgaitError, UnknownNameError
from rollgait.ocp.term import Data
from tests.clusters import dask_cluster

BASE = rg.Scenario.from_dict(
    {"robot": "centauro-2020", "goal": {"x": 0.1}, "horizon": 1.6, "interval": 0.2, "gait": "drive"}
)
GOOD = {f"to {x:g}": BASE.with_values({"goal.x": x}) for x in (0.1, 0.15)}
UNSOLVABLE = BASE.with_values({"bounds.force_max": 50.0})


class Deadly(rg.Cost):
    """Ends the process that plans for one of the goals."""

    name = "deadly"

    def data(self, problem: Any) -> dict[str, Any]:
        if problem.scenario.goal.x == 0.15:
            os._exit(9)
        return {}

    def expression(self, x: rg.Instant, d: Data) -> Any:
        return 0.0 * x.r[0]


class Faulty(Deadly):
    """Has a mistake."""

    def data(self, problem: Any) -> dict[str, Any]:
        return {}["nothing"]


def same(plan: rg.Plan | None, other: rg.Plan | None) -> bool:
    assert plan is not None
    assert other is not None
    return all(
        np.array_equal(array, other.trajectory.arrays()[name])
        for name, array in plan.trajectory.arrays().items()
    )


def test_one_bad_scenario_leaves_the_others_alone(tmp_path: Path) -> None:
    asked = {**GOOD, "wrong": "no such scenario", "heavy": UNSOLVABLE}
    outcomes = rg.plan_many(asked, workers=1, folder=tmp_path)
    good, wrong, heavy = outcomes[:2], outcomes[2], outcomes[3]
    assert [outcome.name for outcome in outcomes] == ["to-0.1", "to-0.15", "wrong", "heavy"]
    for outcome, scenario in zip(good, GOOD.values(), strict=True):
        assert outcome.error is None
        assert outcome.certified
        assert same(outcome.plan, rg.plan(scenario))
        assert outcome.file is not None
        assert same(rg.Plan.load(outcome.file), outcome.plan)
    assert wrong.plan is heavy.plan is None
    assert isinstance(wrong.error, rg.InputError)
    assert isinstance(heavy.error, rg.NotSolvedError)
    assert not heavy.error.plan.solved
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(o.file.name for o in good if o.file)


def test_a_second_call_makes_only_what_is_missing(tmp_path: Path) -> None:
    (first, second) = rg.plan_many(GOOD, workers=1, folder=tmp_path)
    assert first.file is not None
    assert second.file is not None
    second.file.write_bytes(b"damaged")
    before = first.file.stat().st_mtime_ns
    again = rg.plan_many(GOOD, workers=1, folder=tmp_path)
    assert first.file.stat().st_mtime_ns == before
    assert [outcome.file for outcome in again] == [first.file, second.file]
    assert same(rg.Plan.load(second.file), second.plan)
    options: list[dict[str, Any]] = [{"profile": "paper"}, {"multistart": 2}, {"kernels": False}]
    for option in options:
        (other,) = rg.plan_many({"to 0.1": GOOD["to 0.1"]}, workers=1, folder=tmp_path, **option)
        assert other.file is not None
        assert other.file != first.file


def test_processes_plan_what_one_process_plans() -> None:
    alone, together = (rg.plan_many(list(GOOD.values()), workers=workers) for workers in (1, 2))
    assert [o.name for o in together] == ["scenario-0000", "scenario-0001"]
    for a, b in zip(alone, together, strict=True):
        assert a.plan is not None
        assert b.plan is not None
        # a process in which BLASFEO was loaded before keeps its product, which rounds otherwise
        if a.plan.statistics.linear_algebra == b.plan.statistics.linear_algebra:
            assert same(a.plan, b.plan)
        assert a.plan.statistics.cost == pytest.approx(b.plan.statistics.cost, rel=1e-9)


def test_a_worker_that_dies_takes_only_its_own_scenario_along() -> None:
    first, second = rg.plan_many(GOOD, workers=2, terms=[Deadly(weight=1.0)], kernels=False)
    assert first.certified
    assert "died" in str(second.error)


def test_a_mistake_in_a_term_is_an_outcome() -> None:
    for outcome in rg.plan_many(GOOD, workers=1, terms=[Faulty(weight=1.0)], kernels=False):
        assert isinstance(outcome.error, RollgaitError)
        assert "KeyError" in str(outcome.error)


def test_names_are_never_the_same() -> None:
    names = [outcome.name for outcome in rg.plan_many(["x/none.yaml", "none.yaml", "y/none"], workers=1)]
    assert names == ["none", "none-2", "none-3"]


def test_wrong_options_are_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"options: 'solvers' .*valid: solver"):
        rg.plan_many(GOOD, solvers="fatrop")
    with pytest.raises(rg.InputError, match="workers: 0 must be"):
        rg.plan_many(GOOD, workers=0)
    with pytest.raises(rg.InputError, match="scenarios: 'wheeled' must be several"):
        rg.plan_many("wheeled")
    with pytest.raises(FileError):
        rg.plan_many(GOOD, warm_start=tmp_path / "missing.npz")


@pytest.mark.parametrize(
    "error",
    [
        rg.InputError("goal.x", 3, "must be less", ["1", "2"]),
        UnknownNameError("robot", "centaur", ["centauro"]),
        FileError("file", "a", "is missing"),
        rg.NotSolvedError("no solution", None),
        MissingExtraError("tracking", "whole-body"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_errors_come_home_from_another_process(error: RollgaitError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_ctrl_c_keeps_what_is_there(tmp_path: Path) -> None:
    """Ctrl-C in a terminal reaches all processes. What is on disk is whole, and nothing goes on working."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(
        [sys.executable, "-c", ENDLESS, str(tmp_path)],
        start_new_session=True,
        stderr=subprocess.PIPE,
        env=environment,
    )
    while not list(tmp_path.glob("goal*.npz")):  # on a new machine kernels are compiled first
        assert process.poll() is None
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=300.0)
    assert b"KeyboardInterrupt" in errors
    assert process.returncode != 0
    files = list(tmp_path.iterdir())
    assert files
    for file in files:
        assert rg.Plan.load(file).solved


ENDLESS = """
import sys
import rollgait as rg
from tests.test_many import BASE
scenarios = {f"goal {x}": BASE.with_values({"goal.x": x / 1000}) for x in range(500)}
rg.plan_many(scenarios, workers=2, folder=sys.argv[1])
"""


OWN_TERM = """
import rollgait as rg

class Lean(rg.Cost):
    name = "lean"
    def residual(self, x, d):
        return x.theta[1:]

def to(x):
    return rg.Scenario(robot="centauro", goal={"x": x}, horizon=1.0, gait={"kind": "drive"})

scenarios = {"near": to(0.1), "far": to(0.2)}
for outcome in rg.plan_many(scenarios, workers=2, terms=[Lean(weight=2.0)], kernels=False, quiet=True):
    assert outcome.certified, outcome.error
    assert "lean" in outcome.plan.statistics.costs
"""


def test_terms_of_a_script_go_to_workers() -> None:
    """They are known nowhere else, and there is no `if __name__ == "__main__"`."""
    done = subprocess.run([sys.executable, "-c", OWN_TERM], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_dask_cluster_carries_the_same_call() -> None:
    with dask_cluster():
        outcomes = rg.plan_many(GOOD)
    for outcome, scenario in zip(outcomes, GOOD.values(), strict=True):
        assert same(outcome.plan, rg.plan(scenario))


def test_a_backend_that_returns_all_at_once_will_do() -> None:
    """As Ray's, which is built on this one."""
    with joblib.parallel_config(backend="multiprocessing"):
        outcomes = rg.plan_many(GOOD, workers=2)
    assert [outcome.certified for outcome in outcomes] == [True, True]
