"""What constraints need between their nodes while a foot goes over something: it turns in the air."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.context import PlanContext


def between_nodes_over(problem: PlanContext, leg: int, curvature: float) -> NDArray[np.float64]:
    """What a constraint needs beside its nodes while a foot goes over something, (N,), in its unit.

    Args:
        problem: whose swings and mesh count.
        leg: number of the foot.
        curvature: of the constraint in time then, beyond that of its term, unit/s².
    """
    mesh = problem.schedule.mesh
    result, h = np.zeros(mesh.intervals), np.maximum(mesh.lengths_before, mesh.lengths)
    for swing in problem.footing.swings:
        if swing.leg == leg and swing.over:
            over = slice(max(swing.lift_off - 1, 0), swing.touch_down + 1)
            result[over] = curvature * h[over] ** 2 / 8.0
    return result
