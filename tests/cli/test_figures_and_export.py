"""`rollgait plot` and `rollgait export` write what they say they write."""

from pathlib import Path

import pytest

import rollgait
from rollgait.cli.app import run


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> str:
    values = {"horizon": 2.0, "goal": {"x": 0.2}, "interval": 0.2}
    plan = rollgait.plan(rollgait.find_scenario("wheeled").with_values(values))
    return str(plan.save(tmp_path_factory.mktemp("plan") / "short.npz"))


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_plot(suffix: str, plan_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "figures"
    assert run(["plot", plan_file, "--out", str(folder), "--format", suffix]) == 0
    listed = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert sorted(listed) == sorted(folder.iterdir())
    assert {path.suffix for path in listed} == {f".{suffix}"}


@pytest.mark.parametrize("arguments", [("--format", "gif"), ("--style", "baroque")])
def test_plot_refuses_what_it_does_not_know(
    arguments: tuple[str, str], plan_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["plot", plan_file, "--out", str(tmp_path / "figures"), *arguments]) == 2
    assert f"'{arguments[1]}'" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_export(plan_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "plan.csv"
    assert run(["export", plan_file, "--rate", "10", "--out", str(target)]) == 0
    assert capsys.readouterr().out == f"{target}\n"
    lines = target.read_text().splitlines()
    assert lines[0].startswith("time,com_x,com_y")
    assert len(lines) == 1 + 21


def test_export_refuses_an_unknown_format(
    plan_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["export", plan_file, "--format", "xls", "--out", str(tmp_path / "a.xls")]) == 2
    assert "'xls'" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
