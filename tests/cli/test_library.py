"""The commands that list and show what comes with the package."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import rollgait
from rollgait.cli.app import run
from rollgait.config import parse_yaml
from rollgait.robot import find_robot, robot_names
from rollgait.scenario import Scenario, find_scenario, scenario_names

COMMANDS = ("plan", "many", "check", "plot", "export", "scenarios", "robots", "show", "cache")
EVERY_COMMAND = (
    *(*COMMANDS, "search", "execute", "track", "simulate", "run", "mpc", "view", "drive", "record"),
    *("robot import", "robot show", "ground show"),
)
ROOT = Path(__file__).parents[2]


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


def test_no_summary_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    for group in ((), ("robot",), ("ground",), ("dataset",)):
        assert "..." not in output(capsys, *group, "--help").replace("[ARGS]...", "")


def test_a_shown_robot_is_that_robot_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in robot_names():
        file = tmp_path / "shown.yaml"
        file.write_text(output(capsys, "robot", "show", name), encoding="utf-8")
        assert find_robot(str(file)) == find_robot(name)
        assert json.loads(output(capsys, "robot", "show", name, "--json"))["mass"] == find_robot(name).mass


@pytest.mark.parametrize(
    ("words", "found"), [("show hybrid-f", "hybrid-forward"), ("robot show cent", "centauro")]
)
def test_the_shell_completes_names(words: str, found: str) -> None:
    shell = {"_ROLLGAIT_COMPLETE": "complete_bash", "COMP_WORDS": f"rollgait {words}"}
    shell["COMP_CWORD"] = str(len(words.split()))
    command = [sys.executable, "-c", "from rollgait.cli import main; main()"]
    done = subprocess.run(command, env=os.environ | shell, capture_output=True, text=True, check=False)
    assert found in done.stdout.split()


def options_of(command: str, capsys: pytest.CaptureFixture[str]) -> set[str]:
    """Options in the help of a command."""
    text = output(capsys, *command.split(), "--help")
    return set(re.findall(r"(?<=[ /])--[a-z][a-z-]+", text.partition("\nOptions:")[2])) - {"--help"}


@pytest.mark.parametrize("page", ["docs/command-line.md", "CHANGELOG.md"])
def test_every_command_is_in_the_documents(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    listed = text if page.startswith("docs") else text.partition("- Command line: ")[2].partition("\n- ")[0]
    for command in EVERY_COMMAND:
        assert (f"`rollgait {command}" if page.startswith("docs") else command) in listed.replace("\n  ", " ")


@pytest.mark.parametrize("command", EVERY_COMMAND)
def test_every_option_is_in_the_documents(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "docs/command-line.md").read_text(encoding="utf-8")
    missing = {option for option in options_of(command, capsys) if f"`{option}" not in text}
    assert not missing
