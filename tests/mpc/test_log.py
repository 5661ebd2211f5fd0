"""The log of a run: what is written is read again; what is no log is refused in one sentence."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from rollgait.errors import FileError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.log import ARRAYS, MpcLog
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.replay import Replay
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.prediction import Event
from rollgait.mpc.script import Script, TimedCommand
from rollgait.mpc.settings import MpcSettings
from tests.mpc.builders import assert_equal

SCRIPT = Script(duration=0.5, commands=(TimedCommand(command=VelocityCommand(forward=0.3)),))


@pytest.fixture(scope="module")
def log(built: Mpc) -> MpcLog:
    built.reset("drive")
    built.events.clear()
    return ClosedLoop(built, RigidPlant(built.robot)).run(SCRIPT)


def test_a_log_is_as_long_as_the_run_and_counts_its_time(log: MpcLog) -> None:
    assert log.time.size == 50
    np.testing.assert_allclose(np.diff(log.time), log.period)
    assert log.com_velocity[-1, 0] > 0.1
    assert all(getattr(log, name).shape[0] == 50 for name in ARRAYS)
    report = log.report()
    assert report.duration == pytest.approx(0.5)
    assert report.passed
    assert report.verdict == "the robot stays on its feet"
    assert report.to_dict()["passed"]
    assert 0.0 < report.median_ms <= report.p99_ms <= report.worst_ms


def test_round_trip(log: MpcLog, tmp_path: Path) -> None:
    noted = replace(log, events=(Event(0.25, "something"),), fallen_at=0.4)
    again = MpcLog.load(noted.save(tmp_path / "log"))
    for field in fields(MpcLog):
        a, b = getattr(noted, field.name), getattr(again, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b)
        else:
            assert a == b
    assert again.report() == noted.report()
    assert again.report().verdict == "the robot falls at 0.40 s"
    assert not again.report().passed
    assert again.report().events == ("0.25 s: something",)


def test_feet_where_no_leg_could_have_them_are_a_failure_of_a_plant_without_legs(log: MpcLog) -> None:
    """Whatever way the robot looks: the box turns with its base."""
    x, y = log.robot.foot_boxes()[0, 1, :2]
    feet, yaw = log.foot_position.copy(), log.euler[-1, 0]
    forward, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    nominal = log.com_position[-1, :2] + log.robot.stance[0, 0] * forward + log.robot.stance[0, 1] * left
    feet[-1, 0, :2] = nominal + (x + 0.17) * forward + y * left
    level = replace(log, foot_position=feet, euler=log.euler * [1.0, 0.0, 0.0])
    assert level.report().outside == pytest.approx(0.17, abs=1e-6)
    assert not level.report().passed
    assert "170 mm outside its box" in level.report().verdict
    assert replace(level, plant="mujoco").report().passed  # its legs have reached there
    assert log.report().outside == 0.0


def test_the_tracking_of_a_log_is_what_its_numbers_say(log: MpcLog) -> None:
    wanted = np.zeros((50, 3))
    wanted[:, 0] = log.com_velocity[:, 0] * np.cos(log.euler[:, 0])
    wanted[:, 0] += log.com_velocity[:, 1] * np.sin(log.euler[:, 0])
    wanted[:, 2] = log.euler_rate[:, 0] + 0.1
    report = replace(log, wanted=wanted).report()
    assert report.forward_rms == pytest.approx(0.0, abs=1e-12)
    assert report.turn_rms == pytest.approx(0.1)
    standing = log.mode.copy()
    standing[30:] = 2
    assert "stands for good after 0.30 s" in replace(log, mode=standing).report().verdict


def other_version(path: Path) -> None:
    with np.load(path) as data:
        arrays = dict(data)
    header = json.loads(str(arrays.pop("header"))) | {"version": 99}
    np.savez(path, header=np.array(json.dumps(header)), **arrays)


def other_kind(path: Path) -> None:
    np.savez(path, header=np.array(json.dumps({"format": "rollgait-plan", "version": 1})))


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:1000])


def no_npz(path: Path) -> None:
    path.write_text("time, x\n0, 1\n")


def gone(path: Path) -> None:
    path.unlink()


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (other_version, "has version 99; this rollgait reads 1"),
        (other_kind, "is not a log of the controller"),
        (cut, "is not a log of the controller"),
        (no_npz, "is not a log of the controller"),
        (gone, "cannot be read: No such file"),
    ],
)
def test_what_is_no_log_is_refused(log: MpcLog, spoil, says: str, tmp_path: Path) -> None:
    path = log.save(tmp_path / "log.npz")
    spoil(path)
    with pytest.raises(FileError, match=says) as error:
        MpcLog.load(path)
    assert "\n" not in str(error.value)


def test_a_recording_shows_a_controller_the_same_states_again(log: MpcLog, mpc: Mpc) -> None:
    plant = Replay(log)
    assert plant.duration == pytest.approx(SCRIPT.duration)
    again = ClosedLoop(mpc, plant).run(SCRIPT)
    for name in ("com_position", "euler", "foot_position", "heading", "speed"):
        np.testing.assert_allclose(getattr(again, name), getattr(log, name), atol=1e-12)
    np.testing.assert_allclose(again.force, log.force, atol=1e-6)  # and it would have done the same
    assert not plant.fallen
    assert plant.pose is None


def test_a_recording_goes_on_at_another_period_and_rests_at_its_end(log: MpcLog, mpc: Mpc) -> None:
    plant = Replay(log)
    control, _ = mpc.step(plant.state, VelocityCommand())
    half = replace(control, end=control.end.at(control.begin.time + 0.5 * log.period))
    plant.step(half)
    np.testing.assert_allclose(plant.state.com_position, log.com_position[:2].mean(axis=0), atol=1e-12)
    plant.push(np.array([1e6, 0.0, 0.0]), 1.0)
    for _ in range(80):
        plant.step(control)
    assert plant.state.time == pytest.approx(log.time[0] + 80.5 * log.period)
    np.testing.assert_array_equal(plant.state.com_position, log.com_position[-1])
    assert np.all(plant.state.com_velocity == 0.0)
    plant.step(control)
    assert_equal(plant.state, plant.state)


def test_a_recorded_fall_is_a_fall_at_its_time(log: MpcLog, mpc: Mpc) -> None:
    fell = Replay(replace(log, fallen_at=0.2))
    again = ClosedLoop(mpc, fell).run(SCRIPT)
    assert again.fallen_at == pytest.approx(0.2)
    assert again.time.size == 20


def test_a_watch_ends_a_run(mpc: Mpc) -> None:
    seen: list[float] = []

    def watch(time: float) -> bool:
        seen.append(time)
        return len(seen) == 7

    log = ClosedLoop(mpc, RigidPlant(mpc.robot)).run(SCRIPT, watch)
    assert log.time.size == 7
    np.testing.assert_allclose(seen, log.time)


def test_settings_know_their_number_of_intervals() -> None:
    assert MpcSettings().intervals == 10
    assert MpcSettings(horizon=1.5, interval=0.05).intervals == 30
