"""What happened in a simulation, as plain arrays beside the plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.plant.disturbances import Disturbances
from rollgait.plant.unplanned import UnplannedContact
from rollgait.robot.robot import Robot
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulationRecord:
    """What was simulated. SI units, world frame unless said otherwise, legs in the order FL, FR, HL, HR.

    Attributes:
        time: (n,), s.
        base_position: origin of the base link, (n, 3), m.
        base_quaternion: base link to world, (x, y, z, w), (n, 4).
        base_velocity: linear, then angular velocity of the base link in base axes, (n, 6), m/s and rad/s.
        joint_position: (n, n_j), rad.
        joint_velocity: (n, n_j), rad/s.
        joint_torque: of the drives, (n, n_j), N m.
        torque_peak: largest magnitude since the sample before, (n, n_j), N m.
        com_position: (n, 3), m, with the payload.
        force: contact force on each foot, mean since the sample before, (n, 4, 3), N.
        slip: speed of the material contact point over the ground, (n, 4), m/s; NaN in the air.
        planned_base_position: (n, 3), m.
        planned_base_quaternion: (x, y, z, w), (n, 4).
        planned_com_position: (n, 3), m.
        planned_force: (n, 4, 3), N.
        planned_contact: (n, 4), bool.
        effort_max: of the joints, (n_j,), N m, inf where there is no limit.
        joint_names: of the n_j joints.
        robot: the planner's robot.
        disturbances: what was not as planned.
        feedback: whether the base pose was fed back.
        ground_height: z of the ground where that is a plane, else of what is under the robot at the start, m.
        terrain: the ground; None if it is a plane.
        unplanned: what else than a foot touched the ground, in the order in which it did first.
        motion_end: when the planned motion ends, s; the robot stands still from then on.
        fallen_at: when it fell, s; None if it did not. The log ends there.
        wall_time: how long the simulation took, s.
    """

    time: Array
    base_position: Array
    base_quaternion: Array
    base_velocity: Array
    joint_position: Array
    joint_velocity: Array
    joint_torque: Array
    torque_peak: Array
    com_position: Array
    force: Array
    slip: Array
    planned_base_position: Array
    planned_base_quaternion: Array
    planned_com_position: Array
    planned_force: Array
    planned_contact: NDArray[np.bool_]
    effort_max: Array
    joint_names: tuple[str, ...]
    robot: Robot
    disturbances: Disturbances
    feedback: bool
    ground_height: float
    motion_end: float
    fallen_at: float | None
    wall_time: float
    terrain: Terrain | None = None
    unplanned: tuple[UnplannedContact, ...] = ()

    @property
    def fallen(self) -> bool:
        """Whether the robot fell."""
        return self.fallen_at is not None
