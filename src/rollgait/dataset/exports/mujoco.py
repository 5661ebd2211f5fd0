"""Motions as keyframes of MuJoCo: one .xml each, as `rollgait export --format mujoco` writes it."""

from __future__ import annotations

from pathlib import Path

from rollgait.dataset.exports.motions import Motions, Written
from rollgait.export import mujoco


def write_mujoco(motions: Motions, folder: Path) -> Written:
    """Writes `row-<number>.xml` for each motion; returns what was written."""
    written = Written()
    for frames in motions.each(written):
        assert frames.joints is not None  # they were asked for
        mujoco.write_mujoco(frames.joints, folder / f"row-{frames.row:08d}.xml", motions.rate)
    return written
