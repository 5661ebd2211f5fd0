"""`rollgait mpc`: what it prints, what it writes, and one sentence for what is wrong."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rollgait as rg
from rollgait.cli.app import run
from rollgait.cli.mpc_input import asked_from, pushes_from
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.log import MpcLog
from rollgait.mpc.script import RandomScript

QUICK = ["mpc", "--no-kernels", "--duration", "0.3"]
COMMANDS = "duration: 0.3\ncommands: [{command: {kind: velocity, forward: 0.2}}]\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.yaml").write_text(COMMANDS)
    (tmp_path / "odd.yaml").write_text("a: 1\n")
    (tmp_path / "bad.yaml").write_text(COMMANDS.replace("forward", "forwards"))
    return tmp_path


def test_what_a_person_reads(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--command", "forward=0.2,gait=trot", "--push", "20N@0.1s", "--iterations", "2"]
    assert run([*QUICK, *arguments]) == 0
    out = capsys.readouterr().out
    assert "centauro, rigid, 0.3 s of 0.3 s: forward=0.2,gait=trot" in out
    for words in ("up to 2 iterations", "1 pushes", "step, median", "missed deadlines", "stays on its feet"):
        assert words in out


def test_json_and_the_log_say_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, "--command", "x=0.1", "--record", "log.npz", "--json"]) == 0
    captured = capsys.readouterr()
    data, log = json.loads(captured.out), MpcLog.load("log.npz")
    assert captured.err == ""
    assert data["file"] == "log.npz"
    assert data["passed"]
    assert data["steps"] == log.time.size == 30
    assert data["final_place"] == log.report().final_place


def test_a_recording_is_a_plant_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, "--command", "script.yaml", "--record", "log.npz"]) == 0
    assert run(["mpc", "--no-kernels", "--plant", "replay:log.npz", "--record", "again.npz"]) == 0
    assert "replay, 0.3 s" in capsys.readouterr().out
    first, again = MpcLog.load("log.npz"), MpcLog.load("again.npz")
    np.testing.assert_allclose(first.com_position, again.com_position, atol=1e-12)


def test_a_fall_is_status_1_and_is_told_of(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["mpc", "--no-kernels", "--duration", "4", "--push", "9000N@0.1s:0.5s"]) == 1
    out = capsys.readouterr().out
    assert "the robot falls at" in out or "the robot stands for good" in out
    assert "events" in out


def test_a_page_of_a_run(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser", reason="needs the extra view")
    assert run([*QUICK, "--record", "run.html"]) == 0
    assert "<html" in Path("run.html").read_text(encoding="utf-8")[:2000].lower()
    assert run([*QUICK, "--record", "run.npz"]) == 0
    assert run(["record", "run.npz", "--out", "again.html"]) == 0
    assert "again.html" in capsys.readouterr().out


def test_the_whole_robot(capsys: pytest.CaptureFixture[str]) -> None:
    for module in ("mujoco", "pinocchio", "daqp"):
        pytest.importorskip(module, reason="needs the extra whole-body")
    disturbed = ["--plant", "mujoco", "--payload", "3kg", "--friction", "0.6", "--estimator", "delayed"]
    assert run([*QUICK, *disturbed, "--record", "log.npz"]) == 0
    assert "mujoco" in capsys.readouterr().out
    assert MpcLog.load("log.npz").joint_position.shape == (30, 39)


WRONG = {
    ("--gait", "trott"): "gait: 'trott' is not known; valid: trot",
    ("--plant", "mujocco"): "valid: mujoco, rigid, replay:FILE",
    ("--plant", "replay:none.npz"): "none.npz",
    ("--plant", "replay:odd.yaml"): "is not a log of the controller",
    ("--plant", "rigid", "--friction", "0.5"): "plant: 'rigid' has no payload",
    ("--command", "wheeld"): "valid: wheeled",
    ("--command", "forward=fast"): "command.forward: 'fast' must be a number",
    ("--command", "forwrd=1"): "valid: forward",
    ("--command", "forward=0.1,gait=gallop"): "gallop",
    ("--command", "forward=0.1,0.2"): "KEY=VALUE",
    ("--command", "x=1,forward=0.2"): "command.forward",
    ("--command", "none.yaml"): "none.yaml",
    ("--command", "odd.yaml"): "must hold commands",
    ("--command", "bad.yaml"): "commands.0.command.forwards",
    ("--duration", "-1"): "duration: -1.0 must be greater than 0",
    ("--duration", "nan"): "duration: nan",
    ("--duration", "1e9"): "duration",
    ("--push", "100"): "push: '100' must be FORCE@START",
    ("--push", "100N/0s"): "push: '100N/0s' must hold positive numbers",
    ("--push", "50N:z@3s"): "push: '50N:z@3s'",
    ("--duration", "3", "--push", "50N@3s"): "push: '50N@3s' must begin within [0, 3) s",
    ("--duration", "3", "--push", "50N/3s"): "must push more often than every 3 s",
    ("--estimator", "exact"): "estimator: 'exact' is not known; valid: ",
    ("--horizon", "0"): "horizon: 0.0 must be greater than 0",
    ("--interval", "1e-5"): "interval",
    ("--interval", "3"): "interval",
    ("--iterations", "0"): "iterations: 0",
    ("--set", "weights.gaol=1"): "valid: goal",
    ("--set", "weights.goal=-1"): "weights.goal: -1 must not be negative",
    ("--set", "weights"): "key=value",
    ("--record", "run.txt"): "record: 'run.txt' must end in a format that is known",
    ("--record", "odd.yaml/run.npz"): "not a folder",
    ("centaur",): "valid: centauro",
    ("--seed", "-1"): "--seed",
}


@pytest.mark.parametrize("arguments", sorted(WRONG))
def test_what_is_wrong_is_one_sentence(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["mpc", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    assert WRONG[arguments] in captured.err


def test_a_recording_cannot_be_pushed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, "--record", "log.npz"]) == 0
    assert run(["mpc", "--plant", "replay:log.npz", "--push", "10N@0.1s"]) == 2
    assert "cannot be pushed" in capsys.readouterr().err


def test_pushes_as_they_are_written() -> None:
    (one,) = pushes_from("50N:-y@3s:0.4s", 10.0, 0)
    np.testing.assert_allclose(one.force, (0.0, -50.0, 0.0), atol=1e-12)
    assert (one.at, one.duration) == (3.0, 0.4)
    many = pushes_from("100N/2s:0.1s", 9.0, 7)
    assert [push.at for push in many] == [2.0, 4.0, 6.0, 8.0]
    assert all(push.duration == 0.1 and np.isclose(np.hypot(*push.force[:2]), 100.0) for push in many)
    assert many == pushes_from("100N/2s:0.1s", 9.0, 7)
    assert many != pushes_from("100N/2s:0.1s", 9.0, 8)


def test_commands_as_they_are_written() -> None:
    def first(text: str, **options) -> VelocityCommand | PoseCommand:
        return asked_from(
            text, **({"gait": None, "duration": None, "seed": 0, "pushes": ()} | options)
        ).script

    assert first("forward=0.3, turn_rate=-0.2").commands[0].command == VelocityCommand(
        forward=0.3, turn_rate=-0.2
    )
    assert first("x=1,yaw_deg=90").commands[0].command == PoseCommand(x=1.0, yaw_deg=90.0)
    assert first("random", duration=30.0, seed=4) == RandomScript(duration=30.0, seed=4).script()
    assert (
        first("random", duration=30.0, pushes=["80N/5s"]) == RandomScript(duration=30.0, push=80.0).script()
    )
    kept = first("wheeled", gait="crawl")
    assert kept.gait == "crawl"
    assert all(timed.command.gait == "crawl" for timed in kept.commands)
    assert kept.commands[0].command.x == rg.find_scenario("wheeled").goal.x


def test_ctrl_c_still_tells_what_was_run(folder: Path) -> None:
    arguments = ["mpc", "--no-kernels", "--duration", "3600", "--record", "log.npz"]
    code = f"import sys; from rollgait.cli.app import run; sys.exit(run({arguments!r}))"
    # a terminal of its own shows when the run has begun
    master, slave = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=folder, stdout=subprocess.PIPE, stderr=slave, text=True
    )
    os.close(slave)
    seen, begin = b"", time.monotonic()
    while b"running" not in seen and time.monotonic() - begin < 600.0:
        seen += os.read(master, 1000)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=300.0)
    os.close(master)
    assert process.returncode == 130
    assert "missed deadlines" in out
    assert MpcLog.load(folder / "log.npz").time.size >= 1


RAMP = "parts: [{kind: ramp, x: -3, length: 6, slope_deg: 8}]\n"
SLOPE = np.tan(np.radians(8.0))


@pytest.mark.parametrize("where", ["keys", "scenario", "command"])
def test_it_runs_on_the_ground_that_is_named(folder: Path, where: str) -> None:
    """A file of keys, a scenario of which only the ground is taken, a scenario whose goals are followed."""
    scenario = f"robot: centauro\ngoal: {{x: 0.2}}\nhorizon: 2\ngait: {{kind: drive}}\nground:\n  {RAMP}"
    (folder / "ground.yaml").write_text(RAMP if where == "keys" else scenario)
    options = ["--command" if where == "command" else "--ground", "ground.yaml", "--record", "log.npz"]
    more = [] if where == "command" else ["--command", "forward=0.1"]
    assert run([*QUICK, *options, *more]) == 0
    log = MpcLog.load("log.npz")
    z = log.foot_position[:, :, 2]
    away = np.ptp(log.foot_position[:, :, 0], axis=1)
    np.testing.assert_allclose(z[:, :2].mean(axis=1) - z[:, 2:].mean(axis=1), away * SLOPE, atol=2e-3)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--ground", "kerbb"], "valid: "),
        (["--ground", "none.yaml"], "none.yaml"),
        (["--ground", "bad-ground.yaml"], "slope_deg"),
        (["--ground", "riser.yaml"], "start"),
    ],
)
def test_bad_grounds_are_one_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str], options: list[str], said: str
) -> None:
    (folder / "bad-ground.yaml").write_text(RAMP.replace("8}", "80}"))
    (folder / "riser.yaml").write_text("parts: [{kind: step, x: 0.3, height: 0.2}]\n")
    assert run([*QUICK, "--command", "forward=0.1", *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
