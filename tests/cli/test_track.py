"""`rollgait track` and `rollgait robot import`, from files to files."""

import json
from pathlib import Path

import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.cli.app import run

FIXTURES = Path(__file__).parent.parent / "fixtures"


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return rg.plan("hybrid-forward").save(tmp_path_factory.mktemp("plans") / "plan.npz")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_track_writes_joints_beside_a_report(plan_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["track", str(plan_file), "--rate", "50"]) == 0
    joints = rg.JointTrajectory.load("plan.joints.npz")
    assert len(joints.time) == 501
    out = capsys.readouterr().out
    assert "position margin" in out
    assert "ms per step" in out


def test_track_as_json(plan_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["track", str(plan_file), "--rate", "50", "--json", "--out", "j.npz"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["passed"]
    assert report["file"] == "j.npz"
    assert {"foot", "heading", "com"} <= {row["name"] for row in report["rows"]}


def test_import_writes_a_robot_that_plans(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["robot", "import", str(FIXTURES / "roller.urdf"), "--out", "robot.yaml"]) == 0
    out = capsys.readouterr().out
    assert "not in the URDF" in out
    assert "contact force" in out
    assert rg.find_robot("robot.yaml").name == "roller"
    assert (
        run(["plan", "hybrid-forward", "--set", "robot=robot.yaml", "--set", "goal.x=1", "--out", "p"]) == 0
    )
    assert run(["track", "p.npz"]) == 0  # the robot remembers where its whole body is


def test_import_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["robot", "import", "centauro", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["robot"]["mass"] == pytest.approx(117.118, abs=1e-3)
    assert any(not finding["known"] for finding in report["findings"])


BAD = {
    ("track", "none.npz"): (2, "none.npz"),
    ("track", "PLAN", "--rate", "fast"): (2, "rate"),
    ("track", "PLAN", "--waist", "bass"): (2, "valid: base"),
    ("track", "PLAN", "--whole-body", "none.yaml"): (2, "none.yaml"),
    ("track", "PLAN", "--out", "."): (2, "folder"),
    ("robot", "imprt"): (2, "valid: import"),
    ("robot", "import", "nobody"): (2, "valid: centauro"),
    ("robot", "import", "none.urdf"): (2, "none.urdf"),
    ("robot", "import", "lonely.urdf"): (2, "lonely.urdf"),
    ("robot", "import", "ROLLER", "--posture", "sit"): (2, "valid: stand"),
    ("robot", "import", "ROLLER", "--srdf", "none.srdf"): (2, "none.srdf"),
}


@pytest.mark.parametrize("arguments", BAD, ids=" ".join)
def test_bad_input(
    arguments: tuple[str, ...], plan_file: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "lonely.urdf").write_text("<robot><link name='a'/></robot>")
    places = {"PLAN": str(plan_file), "ROLLER": str(FIXTURES / "roller.urdf")}
    status, said = BAD[arguments]
    assert run([places.get(word, word) for word in arguments]) == status
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert [file.name for file in folder.iterdir()] == ["lonely.urdf"]
