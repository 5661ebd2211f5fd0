"""Motion files of every kind, built by hand: sound ones, small, from which the hostile ones are made."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.mpc.log import MpcLog
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.scenario import Scenario
from rollgait.simulation import Disturbances, SimulationLog
from rollgait.tracking import JointTrajectory
from rollgait.tracking.report import TrackingReport, TrackingRow
from tests.view.builders import motion_plan

SCENARIO = Scenario.from_dict({"robot": "centauro", "goal": {"x": 0.2}, "horizon": 1.0, "interval": 0.1})
JOINTS = ("hip", "knee")

Change = Callable[[dict[str, Any], dict[str, Any]], object]
"""Changes the header and the arrays of a file in place."""


def plan() -> Plan:
    return motion_plan(SCENARIO)


def joints() -> JointTrajectory:
    samples = plan().sample_every(20.0)
    body = _body(samples)
    row = TrackingRow("foot", 1e-4, 1e-3, "m", "FL", 0.5)
    return JointTrajectory(
        time=samples.time,
        joint_names=JOINTS,
        base_velocity=np.zeros((samples.time.size, 6)),
        joint_velocity=body["joint_position"],
        joint_torque=body["joint_position"],
        reference=samples,
        robot=plan().robot,
        interval=plan().scenario.interval,
        report=TrackingReport((row,), 20, 0, 0, 1e-3, 2e-3, 1.0),
        **body,
    )


def simulation() -> SimulationLog:
    samples = plan().sample_every(20.0)
    body = _body(samples)
    return SimulationLog(
        time=samples.time,
        base_velocity=np.zeros((samples.time.size, 6)),
        joint_velocity=body["joint_position"],
        joint_torque=body["joint_position"],
        torque_peak=body["joint_position"],
        com_position=samples.com_position,
        force=samples.force,
        slip=np.full((samples.time.size, 4), np.nan),
        planned_base_position=body["base_position"],
        planned_base_quaternion=body["base_quaternion"],
        planned_com_position=samples.com_position,
        planned_force=samples.force,
        planned_contact=samples.contact,
        effort_max=np.array([np.inf, 100.0]),
        joint_names=JOINTS,
        robot=plan().robot,
        disturbances=Disturbances(),
        feedback=False,
        ground_height=0.0,
        motion_end=1.0,
        fallen_at=None,
        wall_time=0.5,
        **body,
    )


def controller() -> MpcLog:
    samples = plan().sample_every(100.0).at(slice(None, -1))
    count = samples.time.size
    shared = ("time", "com_position", "euler", "com_velocity", "euler_rate", "foot_position", "heading")
    return MpcLog(
        **{name: getattr(samples, name) for name in (*shared, "speed", "force", "contact")},
        **dict.fromkeys(("seconds", "solver_seconds", "violation", "cost"), np.zeros(count)),
        reference=np.zeros((count, 4)),
        wanted=np.zeros((count, 3)),
        iterations=np.ones(count, dtype=int),
        mode=np.zeros(count, dtype=int),
        late=np.zeros(count, dtype=bool),
        joint_names=(),
        base_position=np.zeros((count, 0)),
        base_quaternion=np.zeros((count, 0)),
        joint_position=np.zeros((count, 0)),
        robot=plan().robot,
        plant="rigid",
        period=0.01,
        fallen_at=None,
        events=(),
    )


def _body(samples: Samples) -> dict[str, np.ndarray]:
    """A whole body that stands upright at the CoM."""
    count = samples.time.size
    return {
        "base_position": samples.com_position,
        "base_quaternion": np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)),
        "joint_position": np.zeros((count, len(JOINTS))),
    }


BUILDERS: dict[str, Callable[[], Any]] = {
    "plan": plan,
    "joints": joints,
    "simulation": simulation,
    "controller": controller,
}


def parts(file: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and arrays of a file."""
    with np.load(file) as data:
        arrays = dict(data)
    return json.loads(str(arrays.pop("header"))), arrays


def write(file: Path, header: Any, arrays: dict[str, Any]) -> Path:
    """A file of these parts, whatever they are."""
    np.savez_compressed(file, allow_pickle=True, header=np.array(json.dumps(header)), **arrays)
    return file


def changed(kind: str, file: Path, change: Change) -> Path:
    """A file of a kind after a change."""
    header, arrays = parts(BUILDERS[kind]().save(file))
    change(header, arrays)
    return write(file, header, arrays)
