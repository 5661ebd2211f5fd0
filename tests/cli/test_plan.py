"""From a scenario to files on disk: what is solved, what is not certified, what is not solved, and Ctrl-C."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rollgait.cli.app import run
from rollgait.plan.plan import Plan

SHORT = (
    *("plan", "wheeled", "--set", "horizon=2", "--set", "goal={x: 0.2}", "--set", "interval=0.2"),
    *("--out", "short.npz"),
)
NOT_CERTIFIED = (*SHORT, "--set", "bounds.acceleration_max=0.001")
"""Solved, but it cannot reach its goal."""
NOT_SOLVED = (*SHORT, "--set", "bounds.force_max=50")
"""Four feet of 50 N each carry no robot."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROLLGAIT_CACHE", "off")  # no line about compiling, whatever was planned before
    return tmp_path


def ran(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    status = run(arguments)
    out, err = capsys.readouterr()
    return status, out, err


def ran_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, Any]:
    status, out, _ = ran(capsys, *arguments, "--json")
    return status, json.loads(out)


def test_a_good_plan(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = ran(capsys, *SHORT)
    assert (status, err) == (0, "")
    assert "written: short.npz\n" in out
    assert [path.name for path in folder.iterdir()] == ["short.npz"]
    plan = Plan.load("short.npz")
    for term in plan.statistics.costs:
        assert f"\n  {term} " in out
    for row in plan.certificate().rows:
        assert f"\n  {row.name} " in out

    assert ran(capsys, "check", "short.npz")[0] == 0
    status, report = ran_json(capsys, "check", "short.npz")
    assert (status, report["solved"], report["certified"]) == (0, True, True)
    assert [row["name"] for row in report["certificate"]["rows"]] == [r.name for r in plan.certificate().rows]


def test_a_plan_that_fails_its_certificate_is_marked(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = ran(capsys, *NOT_CERTIFIED)
    assert (status, err) == (1, "")
    assert "  not certified: goal_distance" in out
    assert "written: short.npz  (not certified)" in out
    status, report = ran_json(capsys, "check", "short.npz")
    assert (status, report["solved"], report["certified"]) == (1, True, False)


def test_what_is_not_solved_leaves_its_iterate(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = ran(capsys, *NOT_SOLVED)
    assert status == 1
    assert out.startswith("last iterate: short.failed.npz")
    assert err.startswith("error: ")
    assert err.splitlines()[1] == "in the way:"
    iterate = Plan.load("short.failed.npz")
    assert iterate.statistics.worst in err
    assert not iterate.solved
    assert [path.name for path in folder.iterdir()] == ["short.failed.npz"]
    assert ran(capsys, "check", "short.failed.npz")[0] == 1

    status, report = ran_json(capsys, *NOT_SOLVED)
    assert (status, report["solved"], report["file"]) == (1, False, "short.failed.npz")


@pytest.mark.parametrize("option", ["transcription", "solver"])
def test_an_unknown_method_lists_the_known(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = ran(capsys, *SHORT, f"--{option}", "magic")
    assert (status, out) == (2, "")
    assert f"error: {option}: 'magic' is not known; valid: " in err


def test_several_starts_are_listed_with_their_costs(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = ran(capsys, *SHORT, "--starts", "3", "--seed", "1")
    assert status == 0
    plan = Plan.load("short.npz")
    assert len(plan.statistics.starts) == 3
    (chosen,) = [line for line in out.splitlines() if line.endswith("  chosen")]
    assert chosen.startswith(f"  {plan.statistics.start} ")
    for start in plan.statistics.starts:
        assert f"\n  {start.name} " in out
    assert "\nstarts\n" not in ran(capsys, *SHORT)[1]


def test_a_plan_starts_from_another(capsys: pytest.CaptureFixture[str]) -> None:
    assert ran(capsys, *SHORT)[0] == 0
    again = (*SHORT[:-1], "again.npz", "--set", "goal.x=0.25", "--from", "short.npz")
    assert ran(capsys, *again)[0] == 0
    assert Plan.load("again.npz").statistics.start == "warm start"
    status, out, err = ran(capsys, *SHORT, "--from", "missing.npz")
    assert (status, out) == (2, "")
    assert "missing.npz" in err


def test_it_says_in_one_line_that_there_are_no_kernels(folder: Path) -> None:
    environment = os.environ | {"ROLLGAIT_CACHE": str(folder / "cache"), "CC": "no-such-compiler"}
    command = [sys.executable, "-m", "rollgait", *SHORT]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    assert done.stderr == "no C compiler found: planning without compiled kernels\n"
    command.append("--no-kernels")
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    assert Plan.load(folder / "short.npz").solved


@pytest.mark.parametrize("solver", ["fatrop", "ipopt"])
def test_ctrl_c_leaves_nothing(solver: str, folder: Path) -> None:
    command = [sys.executable, "-u", "-c", WITH_CTRL_C, "plan", "hybrid-goback", "--solver", solver]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "error: stopped by Ctrl-C; no file is left half-written\n"
    assert list(folder.iterdir()) == []


WITH_CTRL_C = f"""
import os
from rollgait.cli import main, plan

class Pressing(plan.SolverLine):
    def __call__(self, iteration):
        if iteration.number == 2:
            os.kill(os.getpid(), {int(signal.SIGINT)})

plan.SolverLine = Pressing
main()
"""
"""Presses Ctrl-C while the solver works: at its second iteration."""


def test_the_time_for_the_reason_can_be_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, report = ran_json(capsys, *NOT_SOLVED, "--diagnose-seconds", "0.001")
    assert status == 1
    assert not report["diagnosis"]["complete"]
    status, out, err = ran(capsys, *SHORT, "--diagnose-seconds", "nan")
    assert (status, out) == (2, "")
    assert "diagnose_seconds: nan must be a positive number of seconds" in err
