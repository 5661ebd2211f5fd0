"""Motions as Isaac Lab's motion loader reads them: one .npz each, arrays over frames, in single precision."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rollgait.dataset.exports.motions import Frames, Motions, Written
from rollgait.files import replacing


def write_isaaclab(motions: Motions, folder: Path) -> Written:
    """Writes `row-<number>.npz` for each motion; returns what was written.

    Velocities of bodies are those of their origins in world axes, rotations (w, x, y, z) from body to world.
    """
    fps = motions.require_whole_rate("isaaclab")
    written = Written()
    for frames in motions.each(written):
        with replacing(folder / f"row-{frames.row:08d}.npz") as temporary, temporary.open("wb") as stream:
            np.savez_compressed(stream, **arrays(frames, fps))
    return written


def arrays(frames: Frames, fps: int) -> dict[str, Any]:
    """The arrays of a file, by their names."""
    joints, bodies, k = frames.joints, frames.bodies, frames.index
    assert joints is not None  # they were asked for
    assert bodies is not None
    numbers = {
        "dof_positions": joints.joint_position[k],
        "dof_velocities": joints.joint_velocity[k],
        "body_positions": bodies.position,
        "body_rotations": bodies.quaternion,
        "body_linear_velocities": bodies.linear_velocity,
        "body_angular_velocities": bodies.angular_velocity,
    }
    return {
        "fps": np.int64(fps),
        "dof_names": np.array(joints.joint_names),
        "body_names": np.array(bodies.names),
        **{name: values.astype(np.float32) for name, values in numbers.items()},
    }
