"""Controls that execute a plan, as a controller would give them."""

from dataclasses import replace

import numpy as np

import rollgait as rg
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.tracking.headings import held_headings


def controls(plan: rg.Plan, model: WholeBodyModel, period: float = 0.01) -> list[Control]:
    """The plan cut into periods, with locked wheels at the headings they are held at."""
    at = plan.sample_every(1.0 / period)
    at = replace(at, heading=held_headings(plan, at, model))
    between = plan.sample(0.5 * (at.time[1:] + at.time[:-1]))
    turning = np.diff(at.heading, axis=0) / np.diff(at.time)[:, None]
    motion = np.stack([between.speed, turning], axis=-1)
    states = [
        RobotState(
            float(at.time[k]),
            at.com_position[k],
            at.euler[k],
            at.com_velocity[k],
            at.euler_rate[k],
            at.foot_position[k],
            at.heading[k],
            at.speed[k],
        )
        for k in range(len(at.time))
    ]
    return [
        Control(states[k], states[k + 1], between.force[k], motion[k], between.contact[k])
        for k in range(len(states) - 1)
    ]
