"""What the controller expects of the horizon, read from its iterate."""

from __future__ import annotations

import numpy as np

from rollgait.dynamics.foot import planar_motion
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.filling import Filling
from rollgait.mpc.iterate import Iterate
from rollgait.mpc.model import RobotModel
from rollgait.mpc.prediction import Prediction, Status
from rollgait.mpc.reference import Reference
from rollgait.plant.moving import MotionState
from rollgait.plant.state import SHAPES
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


def expected_at(
    problem: LiveProblem,
    iterate: Iterate,
    fill: Filling,
    clock: GaitClock,
    model: RobotModel,
    now: float,
    node: int,
) -> MotionState:
    """The robot as it is expected at a node of the horizon, with the inputs that lead there.

    Args:
        problem: how the iterate is ordered.
        iterate: what is carried out.
        fill: interval, robot and ground.
        clock: which foot is where when.
        model: of the robot.
        now: time of the first node, s.
        node: its number, from 1.
    """
    layout, time = problem.layout, now + node * fill.interval
    inputs = iterate.inputs[node - 1]
    contact = clock.contact(time)
    xy = iterate.states[node, layout.node["xy"]].reshape(1, 4, 2)
    heights, rates = (part[0] for part in fill.ground.foot_heights(clock, np.array([time]), xy)[:2])
    motion = inputs[layout.inputs["motion"]].reshape(4, 2)
    state = model.state(iterate.states[node], time, np.column_stack([xy[0], heights]), motion[:, 0])
    velocity = np.zeros((4, 3))
    for i, leg in enumerate(fill.robot.leg_list):
        rate = float(state.euler_rate[0])
        moved = planar_motion(np, leg.foot, motion[i], state.heading[i], state.euler[0], rate, leg.heading)
        velocity[i, :2] = moved.velocity
    velocity[:, 2] = np.where(contact, 0.0, rates)
    force = inputs[layout.inputs["force"]].reshape(4, 3) * fill.robot.weight
    values = {name: getattr(state, name) for name in SHAPES}
    return MotionState(
        time=time, **values, foot_velocity=velocity, force=force * contact[:, None], contact=contact
    )
