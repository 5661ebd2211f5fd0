"""Whole simulations: statics, following a plan, disturbances, and what a log promises."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.errors import FileError, NotCertifiedError, UnknownNameError
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf import import_robot
from rollgait.robot.whole_body import load_whole_body
from rollgait.simulation import Disturbances, Payload, Push, SimulationLog

FIXTURES = Path(__file__).parent.parent / "fixtures"
STANDING_TIME = 1.0
DRIVE = {"kind": "drive"}


@pytest.fixture(scope="module")
def standing() -> rg.JointTrajectory:
    return rg.track(
        rg.plan(rg.Scenario(robot="centauro", goal={"x": 0.0}, horizon=STANDING_TIME, gait=DRIVE))
    )


@pytest.fixture(scope="module")
def drive() -> rg.JointTrajectory:
    """A short drive to the front and the side, with a turn."""
    goal = {"x": 0.4, "y": 0.2, "yaw_deg": 20.0}
    return rg.track(rg.plan(rg.Scenario(robot="centauro", goal=goal, horizon=4.0, gait=DRIVE)))


@pytest.fixture(scope="module")
def log(drive: rg.JointTrajectory) -> SimulationLog:
    return rg.simulate(drive)


@pytest.fixture(scope="module")
def roller() -> rg.JointTrajectory:
    """A robot with fixed wheels, three joints per leg, welded to the world in its URDF."""
    file = FIXTURES / "roller.yaml"
    robot = import_robot(load_whole_body(file), str(file)).robot
    gait = {"kind": "crawl", "steps": 4}
    return rg.track(rg.plan(rg.Scenario(robot=robot, goal={"x": 0.3}, horizon=8.0, gait=gait)))


def test_who_stands_is_carried_and_stays(standing: rg.JointTrajectory) -> None:
    log = rg.simulate(standing)
    late = log.time > 0.5 * STANDING_TIME
    total = log.force[late].sum(axis=1).mean(axis=0)
    assert np.allclose(total, [0.0, 0.0, log.robot.mass * GRAVITY], atol=0.005 * log.robot.weight)
    assert not log.fallen
    assert log.report().final_distance < 2e-3
    assert log.report().final_angle < np.radians(0.2)
    assert np.nanmax(log.slip[late]) < 2e-3


def test_a_payload_is_carried_too(standing: rg.JointTrajectory) -> None:
    log = rg.simulate(standing, Disturbances(payload=Payload(mass=10.0)))
    total = log.force[log.time > 0.5 * STANDING_TIME].sum(axis=1).mean(axis=0)
    assert total[2] == pytest.approx((log.robot.mass + 10.0) * GRAVITY, rel=0.005)


def test_on_a_slope_the_feet_hold_the_robot(standing: rg.JointTrajectory) -> None:
    log = rg.simulate(standing, Disturbances(slope_deg=3.0))
    total = log.force[log.time > 0.7 * STANDING_TIME].sum(axis=1).mean(axis=0)
    slope = np.radians(3.0)
    expected = log.robot.weight * np.array([np.sin(slope), 0.0, np.cos(slope)])
    assert np.allclose(total, expected, atol=0.01 * log.robot.weight)


def test_a_short_drive_follows_its_plan(log: SimulationLog) -> None:
    report = log.report()
    assert not report.fallen
    assert report.final_distance < 0.02
    assert abs(report.final_yaw) < np.radians(1.0)
    assert report.com_rms < 0.02
    assert report.slip_p95 < 0.02
    assert np.linalg.norm(log.base_position[-1] - log.base_position[0]) > 0.35


def test_torques_stay_within_the_limits(drive: rg.JointTrajectory) -> None:
    push = Push(force=500.0, start=1.0, duration=0.3)
    log = rg.simulate(drive, Disturbances(pushes=(push,)), feedback=True)
    assert np.all(np.abs(log.joint_torque) <= log.effort_max + 1e-9)
    assert np.all(log.torque_peak <= log.effort_max + 1e-9)
    assert np.all(log.torque_peak >= np.abs(log.joint_torque) - 1e-9)
    assert max(use.share for use in log.report().joints) <= 1.0 + 1e-9


def test_feedback_takes_back_what_wrong_wheels_add(drive: rg.JointTrajectory) -> None:
    wrong = Disturbances(radius_error=0.03)
    alone, corrected = (rg.simulate(drive, wrong, feedback=on).report() for on in (False, True))
    assert corrected.final_distance < 0.5 * alone.final_distance
    assert corrected.final_distance < 0.01


def test_wheels_larger_than_known_go_farther(drive: rg.JointTrajectory) -> None:
    way = [
        np.linalg.norm(log.base_position[-1, :2] - log.base_position[0, :2])
        for log in (rg.simulate(drive, Disturbances(radius_error=error)) for error in (-0.03, 0.0, 0.03))
    ]
    assert way[0] < way[1] < way[2]


def test_latency_does_not_throw_it_over(drive: rg.JointTrajectory) -> None:
    report = rg.simulate(drive, Disturbances(latency=5e-3)).report()
    assert not report.fallen
    assert report.final_distance < 0.03


def test_wheels_by_velocity(drive: rg.JointTrajectory) -> None:
    assert rg.simulate(drive, wheels="velocity").report().final_distance < 0.1


def test_a_huge_push_fells_it_and_ends_the_log(standing: rg.JointTrajectory) -> None:
    push = Push(force=8000.0, start=0.3, duration=0.5)
    log = rg.simulate(standing, Disturbances(pushes=(push,)))
    assert log.fallen
    assert log.report().fallen
    assert log.fallen_at is not None
    assert 0.3 < log.fallen_at == log.time[-1] < 0.3 + STANDING_TIME


def test_the_same_simulation_twice(roller: rg.JointTrajectory) -> None:
    first, second = rg.simulate(roller), rg.simulate(roller)
    assert np.array_equal(first.base_position, second.base_position)
    assert np.array_equal(first.force, second.force)


def test_fixed_wheels_roll_and_step_as_well(roller: rg.JointTrajectory) -> None:
    report = rg.simulate(roller).report()
    assert not report.fallen
    assert report.final_distance < 0.02


def test_a_log_reads_back(log: SimulationLog, tmp_path: Path) -> None:
    given = Disturbances(pushes=(Push(force=1.0, start=2.0),), payload=Payload(mass=1.0))
    for original in (log, replace(log, fallen_at=1.5, feedback=True, disturbances=given)):
        path = original.save(tmp_path / "log")
        assert path.suffix == ".npz"
        again = SimulationLog.load(path)
        for field in fields(SimulationLog):
            one, other = getattr(original, field.name), getattr(again, field.name)
            assert (
                np.array_equal(one, other, equal_nan=True) if field.name == "slip" else np.all(one == other)
            )
        assert again.report() == original.report()


def test_files_that_are_no_logs(tmp_path: Path, log: SimulationLog) -> None:
    text = tmp_path / "text.npz"
    text.write_text("no log")
    other = tmp_path / "other.npz"
    np.savez(other, header=np.array("{}"))
    for path in (text, other, tmp_path / "missing.npz", tmp_path):
        with pytest.raises(FileError):
            SimulationLog.load(path)


def test_a_log_has_the_rate_it_says(log: SimulationLog) -> None:
    assert np.allclose(np.diff(log.time), 0.005)
    assert log.time[0] == 0.0
    assert log.time[-1] == pytest.approx(log.motion_end + 0.5)
    assert np.allclose(np.linalg.norm(log.planned_base_quaternion, axis=1), 1.0)


def test_unknown_wheels_and_uncertified_plans(drive: rg.JointTrajectory) -> None:
    with pytest.raises(UnknownNameError, match="angle"):
        rg.simulate(drive, wheels="square")
    plan = rg.plan(rg.Scenario(robot="centauro", goal={"x": 0.0}, horizon=1.0, gait=DRIVE))
    spoilt = replace(plan, statistics=replace(plan.statistics, solved=False))
    with pytest.raises(NotCertifiedError):
        rg.simulate(spoilt)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "distance", "angle"),
    [
        ("wheeled", 0.03, 2.0),
        ("hybrid-forward", 0.03, 2.0),
        ("legged-forward", 0.05, 3.0),
        ("hybrid-goback", 0.05, 3.0),
    ],
)
def test_the_four_motions(motion: str, distance: float, angle: float) -> None:
    joints = rg.track(rg.plan(motion))
    alone, corrected = (rg.simulate(joints, feedback=on).report() for on in (False, True))
    assert not alone.fallen
    assert alone.final_distance < distance
    assert alone.final_angle < np.radians(angle)
    assert alone.slip_p95 < 0.02
    assert alone.com_rms < 0.04
    assert corrected.final_distance < 0.01
    assert corrected.final_angle < np.radians(0.5)
