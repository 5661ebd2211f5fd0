"""`rollgait dataset`: what a user types."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.dataset.builders import spec

import rollgait as rg
from rollgait.cli.app import run
from rollgait.config import dump_yaml

pytest.importorskip("pyarrow")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cli") / "few.yaml"
    path.write_text(dump_yaml(spec(3)), encoding="utf-8")
    assert run(["dataset", str(path), "--workers", "1"]) == 0
    return path


def test_the_commands_say_what_the_table_says(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(file.with_suffix(""))
    library = rg.Dataset(folder)
    assert run(["dataset", "stats", folder, "--json", "--plot", str(tmp_path / "all.png")]) == 0
    assert json.loads(capsys.readouterr().out)["statuses"] == {"certified": 3}
    assert (tmp_path / "all.png").stat().st_size > 10_000
    assert run(["dataset", "stats", folder]) == 0
    assert "3 of 3 rows" in capsys.readouterr().out
    assert run(["dataset", "check", folder, "--rows", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["passed"]
    assert run(["dataset", "show", folder, "1", "--out", str(tmp_path / "one.npz")]) == 0
    assert "goal_distance" in capsys.readouterr().out
    assert rg.Plan.load(tmp_path / "one.npz").statistics == library.plan(1).statistics
    assert run(["dataset", "export", folder, "--out", str(tmp_path / "lerobot")]) == 0
    assert "3 motions" in capsys.readouterr().out


def test_a_sample_is_what_is_planned_then(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["dataset", "sample", str(file), "--json"]) == 0
    drawn = json.loads(capsys.readouterr().out)
    library = rg.Dataset(file.with_suffix(""))
    assert [one["values"] for one in drawn] == [dict(library.sampler.asked(row).values) for row in range(3)]
    assert run(["dataset", "sample", str(file), "--rows", "1"]) == 0
    assert "goal.x=" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stat", "x"], "dataset: is not a command"),
        (["stats", "x"], "is no data set"),
        (["none.yaml"], "cannot be read"),
        (["run", "none.yaml", "--workers", "0"], "workers: 0"),
    ],
)
def test_mistakes_are_told_in_a_line(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["dataset", *arguments]) == 2
    assert message.removeprefix("dataset: ") in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stats", "{}", "--plot", "all.txt"], "format: 'txt' is not known; valid: p"),
        (["stats", "{}", "--plot", "file/all.png"], "cannot be written"),
        (["show", "{}", "1", "--out", "one.txt"], "out: 'one.txt' must end in .npz"),
        (["export", "{}", "--out", "file/all"], "cannot be written"),
    ],
)
def test_files_that_cannot_be_written_are_told_before_any_work(
    arguments: list[str],
    message: str,
    file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    assert run(["dataset", *(word.format(file.with_suffix("")) for word in arguments)]) == 2
    said = capsys.readouterr()
    assert message in said.err
    assert said.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
