"""Scripts: the same seed gives the same; what contradicts itself is refused; files say the same again."""

import math
from itertools import groupby
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.config import dump_yaml
from rollgait.errors import InputError
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.script import RandomScript, Script, TimedCommand, TimedPush, script_of
from rollgait.scenario import scenario_names

ONE = TimedCommand(command=VelocityCommand(forward=0.1))


@given(st.integers(0, 10_000), st.floats(0.1, 1.0), st.floats(0.1, 1.0), st.floats(10.0, 200.0))
def test_random_scripts_repeat_by_seed_and_stay_within_what_was_asked(
    seed: int, speed: float, turn: float, push: float
) -> None:
    asked = RandomScript(seed=seed, speed=speed, turn_rate=turn, push=push)
    script = asked.script()
    assert script == asked.script()
    assert script != asked.model_copy(update={"seed": seed + 1}).script()
    script.check()
    for timed in script.commands:
        command = timed.command
        assert isinstance(command, VelocityCommand)
        assert math.hypot(command.forward, command.lateral) <= speed + 1e-9
        assert abs(command.turn_rate) <= turn
        assert command.gait in asked.gaits
    assert [push.at for push in script.pushes] == [5.0 * k for k in range(1, 12)]
    for timed_push in script.pushes:
        assert math.isclose(math.hypot(*timed_push.force), push)
        assert timed_push.force[2] == 0.0


def test_pushes_do_not_change_the_commands() -> None:
    assert RandomScript(push=100.0).script().commands == RandomScript().script().commands


@given(st.floats(0.0, 12.0))
def test_a_command_holds_until_the_next(time: float) -> None:
    commands = tuple(
        TimedCommand(at=at, command=VelocityCommand(forward=at / 10.0)) for at in (0.0, 2.0, 5.5)
    )
    command = Script(duration=12.0, commands=commands).command_at(time)
    assert command.forward == (0.0 if time < 2.0 - 1e-9 else 0.2 if time < 5.5 - 1e-9 else 0.55)


def test_yaml_round_trip(tmp_path: Path) -> None:
    script = Script(
        duration=9.0,
        gait="crawl",
        commands=(ONE, TimedCommand(at=3.0, command=PoseCommand(x=1.0, yaw_deg=90.0, gait="drive"))),
        pushes=(TimedPush(at=2.0, force=(0.0, 50.0, 0.0)),),
    )
    file = tmp_path / "script.yaml"
    file.write_text(dump_yaml(script.model_dump(mode="json")), encoding="utf-8")
    assert Script.from_yaml(file) == script


BAD = {
    "commands: []\nduration: 1": "commands",
    "duration: 1": "commands: must be given",
    "commands: [{command: {kind: velocity}}]": "duration: must be given",
    "duration: -1\ncommands: [{command: {kind: velocity}}]": "duration",
    "duration: 1\ncommands: [{command: {kind: pose}}]": "commands.0.command.x",
    "duration: 1\ncommands: [{command: {kind: speed}}]": "valid: velocity|valid: pose",
    "duration: 1\ncommands: [{command: {kind: velocity, forwad: 1}}]": "forwad",
    "duration: 1\ncommands: [{command: {kind: velocity, gait: gallop}}]": "gallop",
    "duration: 1\ngait: gallop\ncommands: [{command: {kind: velocity}}]": "gallop",
    "duration: 9\ncommands: [{at: 2, command: {kind: velocity}}, {command: {kind: velocity}}]": "order",
    "duration: 1\ncommands: [{command: {kind: velocity}}]\npushes: [{at: 1, force: [1, 2]}]": "force",
    "duration: 1\ncommands: [{command: {kind: velocity}}]\npushes: [{at: 1, force: [3, 4, 0]}]": "5N@1s",
    "[1, 2]": "mapping",
}


@pytest.mark.parametrize("text", sorted(BAD))
def test_what_is_wrong_in_a_file_is_one_sentence(text: str, tmp_path: Path) -> None:
    file = tmp_path / "script.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=BAD[text]) as error:
        Script.from_yaml(file)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", scenario_names())
def test_the_goals_of_a_scenario_come_in_their_order(name: str) -> None:
    scenario = rg.find_scenario(name)
    script = script_of(scenario)
    script.check()
    goals = [scenario.goal, *scenario.goal.then]
    found = [(c.command.x, c.command.y, c.command.yaw_deg) for c in script.commands]
    assert [goal for goal, _ in groupby(found)] == [(goal.x, goal.y, goal.yaw_deg) for goal in goals]
    assert script.duration > script.commands[-1].at + 1.0  # time to arrive
