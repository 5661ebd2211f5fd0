"""Wrong input of every kind: one sentence on stderr that names the field, status 2, nothing else anywhere."""

import subprocess
import sys
from pathlib import Path

import pytest

from rollgait.cli.app import run

FORWARD = ["plan", "hybrid-forward", "--set"]
FLYING = "gait={kind: schedule, FL: [[1, 2]], FR: [[1, 2]], HL: [[1, 2]], HR: [[1, 2]]}"

CASES = {
    # arguments: what the sentence must contain
    ("plann",): "plann",
    ("plan",): "SCENARIO",
    ("plan", "hybrid-forward", "--ot", "x.npz"): "valid: --out",
    ("plan", "hybrid-forward", "--set"): "--set",
    ("plan", "hybrid-forward", "surplus"): "surplus",
    ("plan", "hybrid-froward"): "valid: hybrid-forward",
    ("plan", "no-such.yaml"): "no-such.yaml",
    ("plan", "list.yaml"): "mapping",
    ("plan", "broken.yaml"): "line 3",
    ("plan", "binary.yaml"): "not text",
    ("plan", "hybrid-forward", "--profile", "papr"): "valid: paper",
    ("plan", "hybrid-forward", "--out", "."): "folder",
    ("plan", "hybrid-forward", "--out", "list.yaml/a.npz"): "not a folder",
    ("plan", "hybrid-forward", "--out", "x.txt"): "must end in .npz",
    ("search", "hybrid-forward", "--out", "x.txt"): "out: 'x.txt' must end in .npz",
    ("simulate", "x.npz", "--record", "x.txt"): "record: 'x.txt' must end in .npz",
    (*FORWARD, "loads.payload.mass=-3"): "loads.payload.mass: 'mass' is no place: the list is empty",
    ("robot", "show", "centaur"): "valid: centauro",
    ("show", "wheele"): "valid: wheeled",
    ("check", "no-such.npz"): "no-such.npz",
    ("check", "list.yaml"): "list.yaml",
    ("plot", "no-such.npz"): "no-such.npz",
    ("export", "no-such.npz"): "no-such.npz",
    ("export", "x.npz", "--rate", "fast"): "rate",
    ("export", "x.npz", "--rate", "-1"): "rate",
    (*FORWARD, "goal.x"): "key=value",
    (*FORWARD, "=1"): "key=value",
    (*FORWARD, "gaol.x=1"): "valid: goal",
    (*FORWARD, "goal.z=1"): "goal.z",
    (*FORWARD, "goal.x=far"): "goal.x: 'far' must be a number",
    (*FORWARD, "goal.x='1'"): "goal.x",
    (*FORWARD, "goal.x=true"): "goal.x",
    (*FORWARD, "goal.x=.nan"): "goal.x: nan must be a finite number",
    (*FORWARD, "goal.x=1e999"): "goal.x: inf",
    (*FORWARD, "goal.x=50"): "speed limits",
    (*FORWARD, "goal.then.0.x=1"): "goal.then.0.x",
    (*FORWARD, "goal.then=[{at: 1}]"): "goal.then.0.x: must be given",
    (*FORWARD, "goal.then=[{at: 3, x: 0}, {at: 2, x: 0}]"): "rising order",
    (*FORWARD, "goal.then=[{at: 30, x: 0}]"): "goal.then.0.at",
    (*FORWARD, "profile=paperr"): "valid: paper",
    (*FORWARD, "horizon=-1"): "horizon: -1 must be greater than 0",
    (*FORWARD, "horizon=1"): "pauses",
    (*FORWARD, "interval=100"): "interval",
    (*FORWARD, "interval=1e-300"): "intervals",
    (*FORWARD, "gait=gallop"): "gait.kind: 'gallop'",
    (*FORWARD, "gait.kind=gallop"): "gait.kind: 'gallop'",
    (*FORWARD, "gait.clearence=0.1"): "valid: clearance",
    (*FORWARD, "gait.steps=2.5"): "gait.steps",
    (*FORWARD, "gait.steps=90"): "intervals",
    (*FORWARD, "gait.order=[FL, XX]"): "gait.order.1",
    (*FORWARD, "gait.order=[]"): "order",
    (*FORWARD, "gait={kind: schedule, FL: [[2, 1]]}"): "gait.FL",
    (*FORWARD, "gait={kind: schedule, FL: [[1, 11]]}"): "gait.FL",
    (*FORWARD, "gait={}"): "kind",
    (*FORWARD, FLYING): "at least one must be on the ground",
    (*FORWARD, "robot=centaur"): "valid: centauro",
    (*FORWARD, "robot=mine.yaml"): "mine.yaml",
    (*FORWARD, "robot=7"): "robot",
    (*FORWARD, "robot.mass=-90"): "robot.mass: -90 must be greater than 0",
    (*FORWARD, "robot.inertia.xx=1e6"): "robot.inertia",
    (*FORWARD, "robot.legs.FL.foot=steerabel"): "valid: steerable",
    (*FORWARD, "robot.legs.FL.stance=[1, 2]"): "robot.legs.FL.stance",
    (*FORWARD, "robot.legs.FL.stance=[0.3, 0.3, 0.5]"): "below the CoM",
    (*FORWARD, "ground.friction=0"): "ground.friction",
    (*FORWARD, "weights.acc=-1"): "weights.acc",
    (*FORWARD, "weights.aac=1"): "valid: acc",
    (*FORWARD, "bounds.box=[0.1, 0.1]"): "bounds.box",
    (*FORWARD, "bounds.steering_deg=[30, -30]"): "bounds.steering_deg",
    (*FORWARD, "bounds.steering_deg=[10, 20]"): "start.heading_deg",
    (*FORWARD, "start.heading_deg.FL=170"): "start.heading_deg.FL",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "list.yaml").write_text("- 1\n")
    (tmp_path / "broken.yaml").write_text("robot: centauro\ngoal: {x: 1\n")
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("arguments", CASES, ids=" ".join)
def test_one_sentence(arguments: tuple[str, ...], folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(folder.iterdir())
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert CASES[arguments] in err
    assert sorted(folder.iterdir()) == before


def test_the_process_itself_exits_so(folder: Path) -> None:
    command = [sys.executable, "-m", "rollgait", *FORWARD, "goal.x=far", "--json"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: goal.x: 'far' must be a number\n"
