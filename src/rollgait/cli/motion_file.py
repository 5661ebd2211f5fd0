"""A motion in a file, of whatever kind, as several commands take it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rollgait.errors import FileError

if TYPE_CHECKING:
    from rollgait.mpc.log import MpcLog
    from rollgait.plan.plan import Plan
    from rollgait.simulation.log import SimulationLog
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


def load_any_motion(path: Path) -> Plan | JointTrajectory | SimulationLog | MpcLog:
    """The plan, the joints, or the log of a simulation or of the controller in a file. Raises `FileError`."""
    from rollgait.archive import kind_of
    from rollgait.mpc.log import FORMAT, MpcLog
    from rollgait.simulation.log import SimulationLog

    logs: dict[str, type[SimulationLog] | type[MpcLog]] = {
        "rollgait-simulation": SimulationLog,
        FORMAT: MpcLog,
    }
    rule = "is neither a plan nor a joint trajectory nor a log that rollgait saved"
    found = logs.get(kind_of(path, rule))
    return load_motion(path) if found is None else found.load(path)
