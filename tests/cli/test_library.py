"""The commands that list and show what comes with the package."""

import json
from pathlib import Path

import pytest

import rollgait
from rollgait.cli.app import run
from rollgait.config import parse_yaml
from rollgait.robot import robot_names
from rollgait.scenario import Scenario, find_scenario, scenario_names

COMMANDS = ("plan", "many", "check", "plot", "export", "scenarios", "robots", "show", "cache")


def output(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert run(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


@pytest.mark.parametrize("profile", ["paper", "executable"])
@pytest.mark.parametrize("name", scenario_names())
def test_what_show_prints_is_the_same_scenario(
    name: str, profile: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    text = output(capsys, "show", name, "--profile", profile)
    asked = find_scenario(name).with_values({"profile": profile})
    assert Scenario.from_dict(parse_yaml(text, "text")) == asked.resolved()
    (tmp_path / "my.yaml").write_text(text)
    again = output(capsys, "show", str(tmp_path / "my.yaml"))
    assert again.splitlines()[1:] == text.splitlines()[1:]


def test_show_takes_settings(capsys: pytest.CaptureFixture[str]) -> None:
    text = output(capsys, "show", "wheeled", "--set", "goal.x=0.25", "--set", "robot=centauro-2020")
    scenario = Scenario.from_dict(parse_yaml(text, "text"))
    assert (scenario.goal.x, scenario.robot) == (0.25, "centauro-2020")


@pytest.mark.parametrize(("command", "names"), [("scenarios", scenario_names()), ("robots", robot_names())])
def test_lists_name_everything(command: str, names: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    lines = output(capsys, command).splitlines()
    assert [line.split()[0] for line in lines] == ["name", *names]
    assert [entry["name"] for entry in json.loads(output(capsys, command, "--json"))] == names


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert output(capsys, "--version") == f"rollgait {rollgait.__version__}\n"
    general = output(capsys)
    assert general == output(capsys, "--help")
    for command in COMMANDS:
        assert f"\n  {command} " in general
        assert "Usage: rollgait " + command in output(capsys, command, "--help")
