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
from rollgait.cli.report import NEAREST
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
    rows = plan.certificate().rows
    nearest = {row.name for row in plan.certificate().nearest(NEAREST)}
    assert {row.name for row in rows if f"\n  {row.name} " in out} == nearest
    full = ran(capsys, "check", "short.npz", "--full")[1]
    assert all(f"\n  {row.name} " in full for row in rows)

    assert ran(capsys, "check", "short.npz")[0] == 0
    status, report = ran_json(capsys, "check", "short.npz")
    assert (status, report["solved"], report["certified"]) == (0, True, True)
    assert [row["name"] for row in report["certificate"]["rows"]] == [r.name for r in plan.certificate().rows]


def test_a_plan_that_fails_its_certificate_is_marked(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = ran(capsys, *NOT_CERTIFIED)
    assert (status, err) == (1, "")
    assert "  not certified: goal_distance" in out
    assert all(f"\n  {row.name} " in out for row in Plan.load("short.npz").certificate().failures)
    assert "written: short.npz  (not certified)" in out
    status, report = ran_json(capsys, "check", "short.npz")
    assert (status, report["solved"], report["certified"]) == (1, True, False)


def test_a_plan_of_the_same_robot_is_replaced_with_a_word(capsys: pytest.CaptureFixture[str]) -> None:
    assert ran(capsys, *SHORT)[2] == ""
    status, _, err = ran(capsys, *SHORT)
    assert (status, err) == (0, "short.npz was there before and is replaced\n")


@pytest.mark.parametrize("there", ["another robot", "no plan"])
def test_what_else_is_there_stays_unless_it_is_to_be_overwritten(
    there: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = (*SHORT, "--set", "robot=centauro-2020")
    if there == "no plan":
        Path("short.npz").write_text("notes")
    else:
        assert ran(capsys, *other)[0] == 0
    before = Path("short.npz").read_bytes()
    status, out, err = ran(capsys, *SHORT)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("error: out: 'short.npz'")
    assert Path("short.npz").read_bytes() == before
    assert ran(capsys, *SHORT, "--overwrite")[0] == 0
    assert Plan.load("short.npz").robot.name == "centauro"


def test_quiet_prints_errors_and_data_only(capsys: pytest.CaptureFixture[str]) -> None:
    assert ran(capsys, *SHORT, "-q") == (0, "", "")
    assert ran(capsys, "--quiet", *SHORT) == (0, "", "")
    assert ran_json(capsys, *SHORT, "-q")[1]["certified"]
    status, out, err = ran(capsys, "check", "missing.npz", "-q")
    assert (status, out, err.count("\n")) == (2, "", 1)


def test_verbose_keeps_a_line_of_each_iteration(capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = ran(capsys, *SHORT, "-v")
    iterations = Plan.load("short.npz").statistics.iterations
    assert status == 0
    assert sum("iteration" in line for line in err.splitlines()) >= iterations
    assert ran(capsys, *SHORT, "-v", "-q")[0] == 2


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


def test_ctrl_c_while_the_commands_are_loaded_is_told_in_a_line() -> None:
    done = subprocess.run(
        [sys.executable, "-c", CTRL_C_AT_ONCE], capture_output=True, text=True, check=False, timeout=300
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "error: stopped by Ctrl-C; no file is left half-written\n"


CTRL_C_AT_ONCE = """
import sys

class Pressing:
    def find_spec(self, name, *_):
        if name == "rollgait.cli.app":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Pressing())
from rollgait.cli import main
main()
"""
"""Presses Ctrl-C where the commands are imported."""

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
