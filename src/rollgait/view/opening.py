"""From a file to the clip in it, by the kind of the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from rollgait.archive import kind_of
from rollgait.errors import InputError
from rollgait.mpc.log import FORMAT as MPC_LOG
from rollgait.mpc.log import MpcLog
from rollgait.plan.plan import Plan
from rollgait.scenario.scenario import Scenario
from rollgait.simulation.log import SimulationLog
from rollgait.tracking import JointTrajectory
from rollgait.view.clip import Clip, clip_of_joints, clip_of_log, clip_of_plan
from rollgait.view.mpc_clip import clip_of_mpc
from rollgait.view.standing_clip import clip_of_scenario

KINDS: Final[tuple[tuple[type, Callable[[Any, str], Clip], str], ...]] = (
    (Plan, clip_of_plan, "plan"),
    (JointTrajectory, clip_of_joints, "joints"),
    (SimulationLog, clip_of_log, "simulation"),
    (MpcLog, clip_of_mpc, "run"),
    (Scenario, clip_of_scenario, "scenario"),
)
"""What can be seen, how, and under which name where it has none of its own."""


def clip_of(motion: Any) -> Clip:
    """The clip of a motion, or of the file of one.

    Raises:
        InputError: it is neither.
    """
    if isinstance(motion, Clip):
        return motion
    if isinstance(motion, str | Path):
        return open_clip(motion)
    for kind, make, name in KINDS:
        if isinstance(motion, kind):
            return make(motion, name)
    rule = "must be a plan, joints, a simulation, a run of the controller, a scenario, or the file of one"
    raise InputError("motion", type(motion).__name__, rule)


def open_clip(path: str | Path) -> Clip:
    """The clip in a file: a plan, joints, a log of physics or of the controller, or a scenario (YAML).

    Runs no code of it.

    Raises:
        FileError: the file is missing, is none of these, or has a version that is not known here.
    """
    file = Path(path)
    if file.suffix in (".yaml", ".yml"):
        return clip_of_scenario(Scenario.from_yaml(file), file.stem)
    name = file.name.removesuffix(".npz")
    kind = kind_of(file, "is neither a plan nor a joint trajectory nor a log that rollgait saved")
    if kind == "rollgait-joints":
        return clip_of_joints(JointTrajectory.load(file), name)
    if kind == "rollgait-simulation":
        return clip_of_log(SimulationLog.load(file), name)
    if kind == MPC_LOG:
        return clip_of_mpc(MpcLog.load(file), name)
    return clip_of_plan(Plan.load(file), name)
