"""The judgement: a list of checks, each in the file of its subject."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.body import check_body
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.defects import check_defects
from rollgait.plan.certificate.ends import check_final_stance, check_goal, check_rest, check_start
from rollgait.plan.certificate.feet import check_forces, check_stance, check_swing
from rollgait.plan.certificate.ground import check_ground
from rollgait.plan.certificate.judged import Judged
from rollgait.plan.certificate.limits import (
    check_accelerations,
    check_box,
    check_joints,
    check_speeds,
    check_steering,
)
from rollgait.plan.certificate.loads import check_loads
from rollgait.plan.certificate.motion import DenseMotion
from rollgait.plan.certificate.robot import check_robot
from rollgait.plan.certificate.rows import Certificate, Row, measured
from rollgait.plan.certificate.skid import check_skid
from rollgait.plan.certificate.support import check_support

CHECKS: tuple[Callable[[Case], Iterator[Row]], ...] = (
    check_robot,
    check_loads,
    check_defects,
    check_stance,
    check_skid,
    check_swing,
    check_ground,
    check_body,
    check_forces,
    check_support,
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


def certify(plan: Judged) -> Certificate:
    """Judges a plan by code that shares nothing with the optimiser.

    A plan whose motion is on other intervals than its schedule fails in the row `mesh`, one with a number
    that is not finite in the row `finite`; neither can be looked at further.
    """
    # a plan of nonsense must fail, not warn
    with np.errstate(all="ignore"):
        mesh = tuple(_check_mesh(plan))
        if any(row.verdict == "fail" for row in mesh):
            return Certificate(mesh)
        motion = DenseMotion.of(plan)
        case = Case(plan, motion)
        finite = tuple(_check_finite(case))
        if any(row.verdict == "fail" for row in finite):
            return Certificate(finite)
        rows = [*mesh, *finite, *_check_schedule(case)]
        rows += [row for check in CHECKS for row in check(case)]
    return Certificate(tuple(rows))


def _check_mesh(plan: Judged) -> Iterator[Row]:
    """The intervals of the motion are those of its schedule, and fill the horizon that was asked for."""
    lengths, planned = plan.trajectory.lengths, plan.schedule.lengths
    apart = np.full(planned.shape, np.inf)
    if lengths.shape == planned.shape:
        apart = np.abs(lengths - planned)
        apart[-1] = max(apart[-1], abs(planned.sum() - plan.scenario.horizon))
    yield from measured(
        "mesh",
        "intervals of the motion against those of its schedule and, in sum, the horizon",
        "s",
        apart,
        tol.DURATION,
        plan.schedule.node_times[:-1],
    )


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
    """The motion follows the contact schedule that the gait asks for, on whichever mesh."""
    asked, time = case.scenario.schedule, case.motion.time
    wanted = np.moveaxis(asked.contact[:, asked.mesh.interval_at(time)], 0, -1)
    sampled = case.motion.at.contact
    differs = (sampled != case.motion.in_stance) | (sampled != wanted)
    # what is asked between two samples of a long interval
    own = case.schedule.mesh.interval_at(asked.mesh.middles)
    for k, between in zip(own, (case.schedule.contact[:, own] != asked.contact).T, strict=True):
        differs[k, 0] |= between
    yield from measured(
        "schedule",
        "contacts that are not those of the gait (1: there are some)",
        "",
        differs.astype(float),
        0.0,
        time,
    )
