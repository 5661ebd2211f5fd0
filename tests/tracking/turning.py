"""A plan as it is in a world that was turned about its vertical axis."""

from dataclasses import replace

import numpy as np

import rollgait as rg
from rollgait.plan.condensed import CondensedTrajectory


def turned(plan: rg.Plan, yaw: float) -> rg.Plan:
    """The plan and its ground, of parts, turned by an angle (rad) about the origin."""
    motion = plan.trajectory
    assert isinstance(motion, CondensedTrajectory)
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    flat = R[:2, :2]
    ground = motion.ground.copy()  # ref, h0, g, H as xx xy yy, slope at the contact
    for pair in (slice(0, 2), slice(3, 5), slice(8, 10)):
        ground[..., pair] = motion.ground[..., pair] @ flat.T
    H = flat @ motion.ground[..., [5, 6, 6, 7]].reshape(*ground.shape[:2], 2, 2) @ flat.T
    ground[..., 5:8] = H[..., [0, 0, 1], [0, 1, 1]]
    other = replace(
        motion,
        r=motion.r @ R.T,
        theta=motion.theta + np.array([yaw, 0.0, 0.0]),
        dr=motion.dr @ R.T,
        L=motion.L @ R.T,
        foot_xy=motion.foot_xy @ flat.T,
        heading=motion.heading + yaw,
        force=motion.force @ R.T,
        ground=ground,
    )
    scenario = plan.scenario
    parts = [part.model_dump(mode="json") for part in scenario.terrain.turned(yaw).parts]
    return replace(plan, trajectory=other, scenario=scenario.with_values({"ground": {"parts": parts}}))
