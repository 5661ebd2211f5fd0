"""A motion as one JSON document: what was asked, how it was judged, and the columns of the CSV by name."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from rollgait.export.csv import columns
from rollgait.export.motion import Motion, Sampled, sampled
from rollgait.files import replacing
from rollgait.plan.plan import Plan
from rollgait.tracking.joints import JointTrajectory

FORMAT_VERSION: Final = 1
"""Version of the document."""
CONVENTIONS: Final = {
    "units": "SI, rad",
    "frame": "world: x forward, y left, z up",
    "euler": "yaw, pitch, roll; R = Rz(yaw) Ry(pitch) Rx(roll)",
    "quaternion": "x, y, z, w",
}


def write_json(motion: Motion, path: Path, rate: float) -> Path:
    """Writes the motion, sampled at `rate` (Hz, both ends included), as JSON; returns the path."""
    data = _document(motion, sampled(motion, rate))
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _document(motion: Motion, s: Sampled) -> dict[str, Any]:
    document: dict[str, Any] = {
        "format": "rollgait-motion",
        "version": FORMAT_VERSION,
        "conventions": CONVENTIONS,
        "robot": s.robot.model_dump(mode="json"),
    }
    if isinstance(motion, Plan):
        document |= {
            "scenario": motion.scenario.to_dict(),
            "solved": motion.solved,
            "statistics": _finite(asdict(motion.statistics)),
            "certificate": motion.certificate().to_dict(),
        }
    else:
        report = motion.report if isinstance(motion, JointTrajectory) else motion.report()
        document["report"] = _finite(report.to_dict())
    document["samples"] = {name: values.tolist() for name, values in columns(s.samples, s.robot).items()}
    document["joints"] = {
        "names": list(s.joint_names),
        "base_position": s.base_position.tolist(),
        "base_quaternion": s.base_quaternion.tolist(),
        "position": s.joint_position.tolist(),
        "velocity": s.joint_velocity.tolist(),
        "effort": s.joint_effort.tolist(),
        "acceleration": s.joint_acceleration.tolist(),
    }
    return document


def _finite(data: Any) -> Any:
    """The same data; numbers that are not finite, which JSON does not have, become null."""
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    return None if isinstance(data, float) and not np.isfinite(data) else data
