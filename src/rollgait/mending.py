"""Solved means certified: where the judge would not pass a solution, the mesh is cut finer there.

A solver keeps its constraints at nodes; the certificate looks between them. What fails there is mended warm:
intervals that fail, and their neighbours, are halved, and the same problem is solved again from the motion
that is known. The certificate stays the judge of the result, and knows nothing of this.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.certificate.rows import Certificate
from rollgait.plan.plan import Plan
from rollgait.scenario.schedule import ContactSchedule

ROUNDS: Final = 4
"""Looks of the judge at a solution, between which its mesh is cut: at the last an interval is at least an
eighth of what it was."""
SHORTEST: Final = 0.01
"""s; an interval of half this length or less is not cut: between its nodes nothing moves by a millimetre."""
NEIGHBOURS: Final = 1
"""Intervals on both sides that are cut along: what fails in one is decided at its nodes."""
AT_NODES: Final = (
    "start_",
    "end_",
    "goal_",
    "schedule",
    "mesh",
    "finite",
    "robot",
    "load_",
    "swing_clearance",
)
"""How the names of rows begin that no finer mesh can mend."""


def finer(plan: Plan) -> ContactSchedule | None:
    """The schedule of a plan on a mesh that is finer where its certificate fails.

    Returns:
        None if nothing fails that a finer mesh could mend, or if the intervals are as short as they may be.
    """
    bad = failing_intervals(plan)
    if bad is None:
        return None
    for _ in range(NEIGHBOURS):
        bad[1:] |= bad[:-1].copy()
        bad[:-1] |= bad[1:].copy()
    bad &= plan.schedule.lengths > SHORTEST
    return plan.schedule.refined(bad, 2) if bad.any() else None


def failing_intervals(plan: Plan) -> NDArray[np.bool_] | None:
    """In which intervals the certificate fails, (N,); None if it passes or fails at the ends alone."""
    times = mendable(plan.certificate())
    if not times:
        return None
    bad = np.zeros(plan.schedule.intervals, dtype=bool)
    bad[plan.schedule.mesh.interval_at(np.asarray(times))] = True
    return bad


def mendable(certificate: Certificate) -> list[float]:
    """Times at which rows fail that a finer mesh may mend, s."""
    return [
        time
        for row in certificate.failures
        if not row.name.startswith(AT_NODES)
        for time in (row.failing or ((row.time,) if row.time is not None else ()))
    ]
