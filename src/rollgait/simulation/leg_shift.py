"""Feet shifted from where they are planned from the base: which joints do it.

The base over the feet, or a foot in the air beside where it was planned: both are places of feet seen from
the base. Joints are found on the planned configuration, one Newton step an update: shifts change slowly.
"""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.simulation.world import World
from rollgait.tracking.tasks import rotation_vector

Array = NDArray[np.float64]

POSITION_WEIGHT: Final = 1e4
"""Of a foot's place over its orientation where a leg cannot keep both, 1/m² per 1/rad²."""

SIDEWAYS_MIN: Final = 0.05
"""Share of what joints move a foot at most that they move it at least, whatever the direction, in a leg that
counts as able to: one without a joint for a side has no more than what the tilt of the base gives."""

SINGULAR: Final = 1e-3
"""Share of the largest singular value below which a direction counts as none: a straight knee."""


class LegShift:
    """Finds the shifts of the joints for shifts of the feet.

    Args:
        world: whose legs.

    Attributes:
        joints: Δq, (n_j,), rad. Wheels turn against their shank, so that they do not roll by being shifted.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._planned, self._shifted = mujoco.MjData(world.model), mujoco.MjData(world.model)
        self._legs = [np.zeros(len(leg)) for leg in world.legs]
        self.joints: Array = np.zeros(len(world.joint_names))

    def moves_all_ways(self, base_position: Array, base_quaternion: Array, joint_position: Array) -> bool:
        """Whether each leg can move its foot in all directions, in a configuration as for `update`."""
        world, data = self._world, self._planned
        world.put(data, base_position, base_quaternion, joint_position)
        mujoco.mj_kinematics(world.model, data)
        mujoco.mj_comPos(world.model, data)
        J_p = np.zeros((3, world.model.nv))
        for foot, places in zip(world.feet, world.legs, strict=True):
            mujoco.mj_jacGeom(world.model, data, J_p, None, foot)
            sizes = np.linalg.svd(J_p[:, world.velocity[places]], compute_uv=False)
            if len(sizes) < 3 or sizes[-1] < SIDEWAYS_MIN * sizes[0]:
                return False
        return True

    def update(
        self, base_position: Array, base_quaternion: Array, joint_position: Array, shift: Array
    ) -> None:
        """Leads the joints to where the feet are shifted.

        Args:
            base_position: planned origin of the base link, (3,), m.
            base_quaternion: planned, base link to world, (x, y, z, w), (4,).
            joint_position: planned, (n_j,), rad.
            shift: of the feet from where they are planned from the base, axes of the world, (4, 3), m.
        """
        if not (shift.any() or self.joints.any()):
            return
        world, planned, shifted = self._world, self._planned, self._shifted
        for data, joints in ((planned, joint_position), (shifted, joint_position + self._without_wheels())):
            world.put(data, base_position, base_quaternion, joints)
            mujoco.mj_kinematics(world.model, data)
        mujoco.mj_comPos(world.model, shifted)  # Jacobians need it
        scale = np.sqrt(POSITION_WEIGHT)
        J_p, J_r = np.zeros((3, world.model.nv)), np.zeros((3, world.model.nv))
        for leg, places in enumerate(world.legs):
            foot, columns = world.feet[leg], world.velocity[places]
            mujoco.mj_jacGeom(world.model, shifted, J_p, J_r, foot)
            missing = planned.geom_xpos[foot] + shift[leg] - shifted.geom_xpos[foot]
            R_planned, R_shifted = (data.geom_xmat[foot].reshape(3, 3) for data in (planned, shifted))
            turned = rotation_vector(R_planned @ R_shifted.T)
            J = np.concatenate([scale * J_p[:, columns], J_r[:, columns]])
            step = np.linalg.lstsq(J, np.concatenate([scale * missing, turned]), rcond=SINGULAR)[0]
            self._legs[leg] += step
            self.joints[places] = self._legs[leg]
            wheel = world.wheels[leg]
            if wheel is not None:
                axle = shifted.xaxis[world.joints[wheel]]
                self.joints[wheel] = axle @ (turned - J_r[:, columns] @ step)

    def _without_wheels(self) -> Array:
        """Δq of the legs alone, (n_j,), rad."""
        shift = np.zeros_like(self.joints)
        for leg, places in enumerate(self._world.legs):
            shift[places] = self._legs[leg]
        return shift
