"""A motion in a file, of either kind, as several commands take it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rollgait.errors import FileError

if TYPE_CHECKING:
    from rollgait.plan.plan import Plan
    from rollgait.tracking.joints import JointTrajectory


def load_motion(path: Path) -> Plan | JointTrajectory:
    """The plan or the joint trajectory in a file. Raises `FileError`."""
    from rollgait.archive import kind_of
    from rollgait.plan.plan import Plan
    from rollgait.tracking.joints import JointTrajectory

    kinds: dict[str, type[Plan] | type[JointTrajectory]] = {
        "rollgait-plan": Plan,
        "rollgait-joints": JointTrajectory,
    }
    rule = "is neither a plan nor a joint trajectory that rollgait saved"
    found = kinds.get(kind_of(path, rule))
    if found is None:
        raise FileError("file", str(path), rule)
    return found.load(path)
