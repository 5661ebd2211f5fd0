"""A run of the controller as a clip: frame by frame what the log says."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra view")

import rollgait as rg
from rollgait.mpc.log import MpcLog
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.prediction import Event
from rollgait.plant.stance import standing_control, standing_state
from rollgait.view.mpc_clip import clip_of_mpc
from rollgait.view.opening import open_clip

COUNT, PERIOD = 101, 0.01


@pytest.fixture(scope="module")
def log() -> MpcLog:
    """A robot that drives straight ahead on a rigid body, without a controller."""
    robot = rg.find_robot("centauro")
    start = replace(standing_state(robot), com_velocity=np.array([0.3, 0.0, 0.0]))
    plant, states = RigidPlant(robot, start), []
    for _ in range(COUNT):
        states.append(plant.state)
        control = standing_control(robot, plant.state, PERIOD)
        plant.step(replace(control, motion=np.tile([0.3, 0.0], (4, 1))))
    columns = {
        name: np.array([getattr(state, name) for state in states])
        for name in ("time", "com_position", "euler", "com_velocity", "euler_rate", "foot_position")
    }
    nothing = np.zeros(COUNT)
    return MpcLog(
        **columns,
        heading=np.array([state.heading for state in states]),
        speed=np.array([state.speed for state in states]),
        force=np.tile([0.0, 0.0, robot.weight / 4.0], (COUNT, 4, 1)),
        contact=np.ones((COUNT, 4), dtype=bool),
        reference=np.zeros((COUNT, 4)),
        wanted=np.zeros((COUNT, 3)),
        seconds=nothing,
        solver_seconds=nothing,
        iterations=np.ones(COUNT, dtype=int),
        violation=nothing,
        cost=nothing,
        mode=np.zeros(COUNT, dtype=int),
        late=np.zeros(COUNT, dtype=bool),
        base_position=np.empty((COUNT, 0)),
        base_quaternion=np.empty((COUNT, 0)),
        joint_position=np.empty((COUNT, 0)),
        joint_names=(),
        robot=robot,
        plant="rigid",
        period=PERIOD,
        fallen_at=None,
        events=(),
    )


def test_the_frames_are_those_of_the_log(log: MpcLog) -> None:
    clip = clip_of_mpc(log, "run")
    assert clip.horizon == pytest.approx(1.0)
    assert len(clip.time) == 31
    at = np.rint(clip.time / PERIOD).astype(int)
    np.testing.assert_array_equal(clip.samples.foot_position, log.foot_position[at])
    inner = clip.samples.foot_velocity[2:-2]
    np.testing.assert_allclose(inner[..., 0], 0.3, atol=0.06)  # rows of the log are 10 ms apart, frames 33
    np.testing.assert_allclose(inner[..., 1:], 0.0, atol=1e-9)
    assert clip.terrain.level == pytest.approx(0.0)
    assert clip.joints is None
    assert clip.passed
    assert clip.verdict == "the robot stays on its feet"


def test_events_and_the_fall_are_marks(log: MpcLog) -> None:
    events = tuple(Event(0.1 * k, f"fault {k}") for k in range(1, 12))
    clip = clip_of_mpc(replace(log, events=events, fallen_at=1.0), "run")
    assert clip.marks[0].failed
    assert clip.marks[0].title == "fall"
    assert clip.marks[1].value == "fault 1"
    assert len(clip.marks) == 6
    assert not clip.passed
    assert "falls at 1.00 s" in clip.verdict


def test_time_of_a_clip_begins_with_the_log(log: MpcLog) -> None:
    later = replace(log, time=log.time + 5.0, events=(Event(5.5, "fault"),))
    clip = clip_of_mpc(later, "run")
    assert clip.time[0] == 0.0
    assert clip.horizon == pytest.approx(1.0)
    assert clip.marks[0].time == pytest.approx(0.5)


def test_a_single_step_can_be_shown(log: MpcLog) -> None:
    names = (*vars(log),)
    one = replace(log, **{n: getattr(log, n)[:1] for n in names if isinstance(getattr(log, n), np.ndarray)})
    clip = clip_of_mpc(one, "run")
    assert np.isfinite(clip.samples.foot_velocity).all()
    assert clip.frame(clip.horizon) == len(clip.time) - 1


def test_a_file_is_told_by_its_header(log: MpcLog, tmp_path: Path) -> None:
    clip = open_clip(log.save(tmp_path / "run.npz"))
    assert clip.kind == "mpc"
    assert clip.name == "run"
