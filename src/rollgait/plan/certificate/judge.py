"""The judgement: a list of checks, each in the file of its subject."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.defects import check_defects
from rollgait.plan.certificate.ends import check_final_stance, check_goal, check_rest, check_start
from rollgait.plan.certificate.feet import check_forces, check_stance, check_swing
from rollgait.plan.certificate.limits import (
    check_accelerations,
    check_box,
    check_joints,
    check_speeds,
    check_steering,
)
from rollgait.plan.certificate.motion import DenseMotion
from rollgait.plan.certificate.rows import Certificate, Row, measured
from rollgait.plan.plan import Plan

CHECKS: tuple[Callable[[Case], Iterator[Row]], ...] = (
    check_defects,
    check_stance,
    check_swing,
    check_forces,
    check_box,
    check_steering,
    check_speeds,
    check_accelerations,
    check_joints,
    check_start,
    check_goal,
    check_rest,
    check_final_stance,
)


def certify(plan: Plan) -> Certificate:
    """Judges a plan by code that shares nothing with the optimiser.

    A plan with a number that is not finite fails in the row `finite` and has no other row.
    """
    # a plan of nonsense must fail, not warn
    with np.errstate(all="ignore"):
        motion = DenseMotion.of(plan)
        case = Case(plan, motion)
        finite = tuple(_check_finite(case))
        if any(row.verdict == "fail" for row in finite):
            return Certificate(finite)
        rows = [*finite, *_check_schedule(case)]
        rows += [row for check in CHECKS for row in check(case)]
    return Certificate(tuple(rows))


def _check_finite(case: Case) -> Iterator[Row]:
    """Every sampled number, and every number of the trajectory itself, is finite and not absurdly large."""
    time = case.motion.time
    bad = sum(
        (
            (~(np.abs(values.reshape(*time.shape, -1)) < tol.LARGEST)).sum(axis=-1)
            for values in (np.asarray(getattr(case.motion.at, f.name)) for f in fields(case.motion.at))
        ),
        start=np.zeros(time.shape),
    )
    stored = sum(
        int((~(np.abs(np.asarray(values, dtype=float)) < tol.LARGEST)).sum())
        for values in case.plan.trajectory.arrays().values()
    )
    worst = np.asarray(bad, dtype=float)
    if stored and not worst.any():
        worst[0, 0] = stored
    yield from measured("finite", "numbers that are not finite", "", worst, 0.0, time)


def _check_schedule(case: Case) -> Iterator[Row]:
    """The motion follows the contact schedule that the gait asks for."""
    asked = case.scenario.schedule.contact
    planned = case.schedule.contact
    time = case.motion.time
    differs = np.ones((*time.shape, planned.shape[0]))
    if asked.shape == planned.shape:
        sampled = case.motion.at.contact
        differs = ((sampled != planned.T[:, None, :]) | (sampled != asked.T[:, None, :])).astype(float)
    yield from measured(
        "schedule", "contacts that are not those of the gait (1: there are some)", "", differs, 0.0, time
    )
