"""`rollgait execute`: what it prints, its exit status, and one sentence for what is wrong."""

import json
from pathlib import Path

import pytest

import rollgait as rg
from rollgait.cli.app import run
from rollgait.mpc.log import MpcLog


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Two short drives, one after the other."""
    folder = tmp_path_factory.mktemp("plans")
    drive = {"horizon": 0.8, "gait": {"kind": "drive"}, "robot": "centauro"}
    return [
        str(rg.plan(rg.Scenario(start={"x": x}, goal={"x": x + 0.04}, **drive)).save(folder / f"{x}.npz"))
        for x in (0.0, 0.04)
    ]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


QUICK = ["execute", "--plant", "rigid", "--no-kernels"]


def test_plans_are_carried_out(files: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, *files, "--record", "log.npz", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["passed"]
    assert data["final_distance"] < 0.01
    assert data["planned"] == pytest.approx(1.6)
    log = MpcLog.load("log.npz")
    assert log.com_position[-1, 0] == pytest.approx(0.08, abs=0.01)


def test_a_person_reads_what_became_of_it(files: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, files[0], "--push", "20N@0.2s"]) == 0
    printed = capsys.readouterr().out
    assert "the robot stays on its feet and ends" in printed
    assert "footholds" in printed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--plant", "paper"], "valid: rigid, mujoco"),
        (["--payload", "5kg"], "has no payload"),
        (["--push", "hard"], "push"),
        (["--push", "50N@2.3s"], "push: '50N@2.3s' must begin within [0, 2.3) s"),
        (["--push", "50N/3s"], "must push more often than every 2.3 s"),
        (["--estimator", "psychic"], "estimator"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(
    files: list[str], arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*QUICK, files[0], *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_plans_that_do_not_join_are_refused(files: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, files[0], files[0]]) == 0  # 4 cm are made good
    capsys.readouterr()
    far = rg.plan(
        rg.Scenario(robot="centauro", start={"x": 1.0}, goal={"x": 1.0}, horizon=0.8, gait={"kind": "drive"})
    ).save("far.npz")
    assert run([*QUICK, files[0], str(far)]) == 2
    assert "must begin where the plan before it ends" in capsys.readouterr().err
