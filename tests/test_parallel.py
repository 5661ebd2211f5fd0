"""Work on many cores: every job has one result, whoever dies."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

import pytest

from rollgait.counted import EVERY, Rate, duration
from rollgait.parallel import results


def squared(job: int, marks: Path, deadly: bool) -> int:
    """Ends its process at 3: always, or only the first time."""
    mark = marks / "died"
    if job == 3 and (deadly or not mark.exists()):
        mark.touch()
        os._exit(9)
    return job * job


@pytest.mark.parametrize("deadly", [False, True])
def test_a_dead_worker_loses_no_job_and_does_none_twice(tmp_path: Path, deadly: bool) -> None:
    call = partial(squared, marks=tmp_path, deadly=deadly)
    found = list(results(call, iter(range(12)), 2, lambda job: -job))
    assert sorted(found) == sorted(-3 if deadly and job == 3 else job * job for job in range(12))


def test_after_one_death_no_job_is_tried_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    alone: list[int] = []

    def tried_alone(_: object, job: int, *__: object) -> int:
        alone.append(job)
        return job * job

    monkeypatch.setattr("rollgait.parallel._alone", tried_alone)
    call = partial(squared, marks=tmp_path, deadly=False)
    assert sorted(results(call, iter(range(12)), 2, lambda job: -job)) == [job * job for job in range(12)]
    assert (tmp_path / "died").exists()
    assert not alone


def test_jobs_are_taken_as_they_are_needed() -> None:
    taken = []

    def jobs() -> object:
        for job in range(1000):
            taken.append(job)
            yield job

    come = results(abs, jobs(), 1, abs)  # type: ignore[arg-type, var-annotated]
    assert next(come) == 0
    assert len(taken) < 10
    come.close()  # type: ignore[attr-defined]


def test_a_log_says_rate_and_remaining_time() -> None:
    now = 0.0
    rate = Rate(100, 20, "planning", lambda: now)
    assert rate.advance() is None
    now = EVERY
    assert rate.advance() == "planning: 22 of 100, 0.0333 per second, 39 min left"
    assert [duration(s) for s in (40.0, 7200.0, 86400.0 * 3)] == ["40 s", "2.0 h", "3.0 days"]
