"""What the controller expects of the horizon, read from its iterate."""

from __future__ import annotations

import numpy as np

from rollgait.mpc.clock import GaitClock
from rollgait.mpc.filling import Filling
from rollgait.mpc.iterate import Iterate
from rollgait.mpc.prediction import Prediction, Status
from rollgait.mpc.reference import Reference
from rollgait.transcription.live import LiveProblem


def outlook(
    problem: LiveProblem,
    iterate: Iterate,
    fill: Filling,
    clock: GaitClock,
    time: float,
    reference: Reference,
    status: Status,
) -> Prediction:
    """The prediction of a step.

    Args:
        problem: whose numbers say which feet stand where.
        iterate: the plan.
        fill: interval, robot and ground.
        clock: how high each foot is when.
        time: of the first node, s.
        reference: what is asked for.
        status: of the step.
    """
    layout, count, stage = problem.layout, fill.count, problem.interval
    stands = stage.numbers("stands").T > 0.0
    position = np.empty((count + 1, 4, 3))
    position[:, :, :2] = iterate.states[:, layout.node["xy"]].reshape(count + 1, 4, 2)
    times = time + fill.interval * np.arange(count + 1, dtype=float)
    position[:, :, 2] = fill.ground.foot_heights(clock, times, position[:, :, :2])[0]
    force = iterate.inputs[:, layout.inputs["force"]].reshape(count, 4, 3) * fill.robot.weight
    return Prediction(
        time=times,
        com_position=iterate.states[:, layout.node["r"]].copy(),
        euler=iterate.states[:, layout.node["theta"]].copy(),
        foot_position=position,
        force=force * stands[:, :, None],
        contact=stands,
        reference=reference.pose.T,
        status=status,
    )
