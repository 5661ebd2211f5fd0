"""Many plans at once: on the cores of this machine, or wherever joblib's backend carries them."""

from __future__ import annotations

import hashlib
import inspect
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from rollgait.counted import counted
from rollgait.errors import FileError, InputError, RollgaitError, UnknownNameError
from rollgait.parallel import one_thread, results
from rollgait.plan.plan import Plan
from rollgait.presented import Shown
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario

Asked = str | Path | Scenario


@dataclass(frozen=True)
class Outcome(Shown):
    """What came of one scenario: either a plan or an error.

    Attributes:
        name: of the scenario; no two are the same.
        plan: the plan, its certificate already computed if it was planned now.
        error: why there is none. A `NotSolvedError` carries the last iterate.
        file: where the plan is, if a folder was given.
    """

    name: str
    plan: Plan | None = None
    error: RollgaitError | None = None
    file: Path | None = None

    @property
    def certified(self) -> bool:
        """Whether there is a plan and its certificate passes."""
        return self.plan is not None and self.plan.certificate().passed


def plan_many(
    scenarios: Mapping[str, Asked] | Iterable[Asked],
    *,
    workers: int = -1,
    folder: str | Path | None = None,
    quiet: bool = False,
    **options: Any,
) -> list[Outcome]:
    """Plans many motions at once. One that goes wrong leaves the others alone.

    The work is done by processes of this machine; inside `joblib.parallel_config(backend="dask")` (or "ray")
    by a cluster.

    Args:
        scenarios: scenarios, names of the library or paths of YAML files; a mapping names them.
        workers: how many at once, each with one thread; −1: one for each core (or worker of the cluster).
        folder: where each plan is written as soon as it is there. Plans that are there already, for the same
            scenario and options, are not made again: a call that was interrupted is resumed by repeating it.
            (Of terms of your own, name and parameters count, not their code.)
        quiet: no progress bar. There is none either where stderr is not a terminal.
        options: further arguments of `rollgait.plan`, the same for all.

    Returns:
        What came of each scenario, in their order.

    Raises:
        InputError: an option or the number of workers is wrong. (A wrong scenario is an outcome.)
        FileError: the folder cannot be written to.
    """
    if workers == 0 or workers < -1:
        raise InputError("workers", workers, "must be a number of processes, or −1 for all cores")
    profile, shared = _shared(options)
    jobs = [_job(name, asked, profile, shared, folder) for name, asked in _named(scenarios)]
    outcomes = {job.name: found for job in jobs if (found := job.outcome) is not None}
    waiting = [job for job in jobs if job.name not in outcomes]
    targets = {job.name: job.target for job in waiting}
    with counted(len(jobs), len(outcomes), quiet) as advance:
        for outcome in results(partial(_outcome, options=shared), waiting, workers, _died):
            outcomes[outcome.name] = _saved(outcome, targets[outcome.name])
            advance()
    return [outcomes[job.name] for job in jobs]


# -- before ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Job:
    """A scenario to be planned, the file for the plan, and the outcome if there is nothing left to do."""

    name: str
    scenario: Scenario | None
    target: Path | None = None
    outcome: Outcome | None = None


def _shared(options: Mapping[str, Any]) -> tuple[str | None, dict[str, Any]]:
    """The profile, and the options for the workers, who may not see our files."""
    from rollgait.planner import plan

    valid = [name for name in inspect.signature(plan).parameters if name not in ("scenario", "progress")]
    for name in options:
        if name not in valid:
            raise UnknownNameError("options", name, valid)
    shared = dict(options)
    profile = shared.pop("profile", None)
    if isinstance(shared.get("warm_start"), str | Path):
        shared["warm_start"] = Plan.load(shared["warm_start"])
    return profile, shared


def _named(scenarios: Mapping[str, Asked] | Iterable[Asked]) -> list[tuple[str, Asked]]:
    """Scenarios with names that can stand in a file's name, no two the same."""
    if isinstance(scenarios, str | Path | Scenario):
        raise InputError("scenarios", scenarios, "must be several: a list, or a mapping from names")
    if isinstance(scenarios, Mapping):
        pairs = list(scenarios.items())
    else:
        pairs = [(_name(asked, number), asked) for number, asked in enumerate(scenarios)]
    used: set[str] = set()
    result = []
    for wished, asked in pairs:
        plain = re.sub(r"[^\w.+-]+", "-", str(wished)).strip("-.") or "scenario"
        numbers = (f"{plain}-{count}" for count in range(2, len(pairs) + 2))
        name = plain if plain not in used else next(name for name in numbers if name not in used)
        used.add(name)
        result.append((name, asked))
    return result


def _name(asked: Asked, number: int) -> str:
    return f"scenario-{number:04d}" if isinstance(asked, Scenario) else Path(asked).stem


def _job(
    name: str, asked: Asked, profile: str | None, shared: Mapping[str, Any], folder: str | Path | None
) -> _Job:
    try:
        scenario = asked if isinstance(asked, Scenario) else find_scenario(str(asked))
        if profile is not None:
            scenario = scenario.with_values({"profile": profile})
        scenario = scenario.self_contained()  # a worker elsewhere may have other files
    except RollgaitError as error:
        return _Job(name, None, outcome=Outcome(name, error=error))
    if folder is None:
        return _Job(name, scenario)
    target = Path(folder) / f"{name}-{_key(scenario, shared)}.npz"
    try:
        done = Outcome(name, Plan.load(target), file=target) if target.exists() else None
    except FileError:  # damaged: it is planned again
        done = None
    return _Job(name, scenario, target, done)


def _key(scenario: Scenario, shared: Mapping[str, Any]) -> str:
    """Tells plans of different scenarios or options apart."""
    import joblib

    values = dict(shared)
    values["terms"] = [(type(term).__qualname__, vars(term)) for term in values.get("terms", ())]
    if (earlier := values.get("warm_start")) is not None:
        values["warm_start"] = (earlier.scenario.to_dict(), earlier.trajectory.arrays())
    text = json.dumps(scenario.to_dict(), sort_keys=True) + str(joblib.hash(values))
    return hashlib.sha256(text.encode()).hexdigest()[:12]


# -- the work ----------------------------------------------------------------------------------------------


def _outcome(job: _Job, options: dict[str, Any]) -> Outcome:
    """Plans one scenario, in a worker; whatever goes wrong becomes its outcome."""
    assert job.scenario is not None  # others are outcomes already
    try:
        with one_thread():
            from rollgait.planner import plan

            found = plan(job.scenario, **options)
            found.certificate()
        return Outcome(job.name, found)
    except RollgaitError as error:
        return Outcome(job.name, error=error)
    except Exception as error:
        return Outcome(job.name, error=RollgaitError(f"unexpected {type(error).__name__}: {error}"))


def _died(job: _Job) -> Outcome:
    return Outcome(job.name, error=RollgaitError("the process that planned it died"))


# -- after -------------------------------------------------------------------------------------------------


def _saved(outcome: Outcome, target: Path | None) -> Outcome:
    if outcome.plan is None or target is None:
        return outcome
    return replace(outcome, file=outcome.plan.save(target))
