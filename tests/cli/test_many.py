"""`rollgait many`: several scenarios, each with its own file and its own line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rollgait.cli.app import run
from rollgait.plan.plan import Plan

SHORT = ("--set", "horizon=2", "--set", "interval=0.2", "--set", "gait=drive", "--set", "goal={x: 0.2}")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROLLGAIT_CACHE", "off")
    return tmp_path


def many(*arguments: str) -> int:
    return run(["many", *arguments, *SHORT, "--workers", "1"])


def test_each_scenario_has_its_plan(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert many("wheeled", "hybrid-forward", "--out", "mine") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[1:]] == [
        ["wheeled", "certified"],
        ["hybrid-forward", "certified"],
    ]
    files = [Path(line.split()[-1]) for line in lines[1:]]
    assert sorted(files) == sorted(Path("mine").iterdir())
    assert all(Plan.load(file).certificate().passed for file in files)

    written = [file.stat().st_mtime_ns for file in files]
    assert many("wheeled", "hybrid-forward", "--out", "mine", "--json") == 0
    report = json.loads(capsys.readouterr().out)
    assert [report[name]["result"] for name in ("wheeled", "hybrid-forward")] == ["certified"] * 2
    assert [file.stat().st_mtime_ns for file in files] == written


def test_a_wrong_scenario_has_a_line_and_a_status(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert many("wheeled", "wheelde") == 2
    out, err = capsys.readouterr()
    assert err == ""
    assert "wheelde   wrong input" in out
    assert "valid: wheeled" in out
    assert "wheeled   certified" in out


def test_what_is_not_solved_has_status_1(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert many("wheeled", "--set", "bounds.force_max=50") == 1
    assert "wheeled   not solved" in capsys.readouterr().out
    assert not (folder / "plans").exists()
