"""The ground of a scenario: it survives files, processes and changes, and the robot can stand on it."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from rollgait.archive import ArchiveFormat
from rollgait.config import dump_yaml, parse_yaml
from rollgait.errors import FileError, InputError
from rollgait.plan.plan import Plan
from rollgait.scenario import Scenario, find_scenario
from rollgait.terrain import Block, Ground, Step, Terrain
from tests.terrain.worlds import worlds
from tests.view.builders import motion_plan

ASKED: dict[str, Any] = {"robot": "centauro", "goal": {"x": 0.3}, "horizon": 2.0}
STEP = {"kind": "step", "x": 2.0, "height": 0.1}
MAP = {"file": "hills.npy", "resolution": 0.04, "origin": [-2.0, -2.0]}
HEIGHTS = 0.001 * np.random.default_rng(1).standard_normal((101, 101))


def hills() -> Terrain:
    return Terrain.from_map(HEIGHTS, 0.04, (-2.0, -2.0))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A scenario on a map, in a folder of its own."""
    folder = tmp_path / "mine"
    folder.mkdir()
    np.save(folder / "hills.npy", HEIGHTS)
    path = folder / "hills.yaml"
    path.write_text(dump_yaml({**ASKED, "ground": {"map": MAP, "friction": 0.7}}))
    return path


def without_file(scenario: Scenario, file: Path) -> Scenario:
    file.with_suffix(".npy").unlink()
    return scenario


# -- keys --


def test_the_old_keys_mean_a_plane() -> None:
    scenario = Scenario.from_dict({**ASKED, "ground": {"kind": "flat", "height": 0.2, "friction": 0.4}})
    assert scenario.terrain == Terrain(0.2, 0.4)
    assert scenario == Scenario.from_dict({**ASKED, "ground": {"height": 0.2, "friction": 0.4}})


@settings(max_examples=30, deadline=None)
@given(terrain=worlds)
def test_parts_go_through_yaml_and_back(terrain: Terrain) -> None:
    ground = Ground.of(terrain)
    scenario = Scenario.model_validate({**ASKED, "ground": ground})
    assert scenario.terrain == terrain
    again = Scenario.model_validate(parse_yaml(scenario.to_yaml(), "again"))
    assert again == scenario
    assert again.terrain == terrain
    assert hash(again) == hash(scenario)


def test_a_map_is_read_from_the_folder_of_its_scenario(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = Scenario.from_yaml(file)
    assert scenario.terrain == Terrain(0.0, 0.7, (), hills().map)
    monkeypatch.chdir(file.parent)
    assert Scenario.from_yaml("hills.yaml") == scenario
    again = file.with_name("again.yaml")
    again.write_text(scenario.resolved().to_yaml())
    assert Scenario.from_yaml(again) == scenario.resolved()


def test_a_map_is_read_for_no_scenario_without_a_folder(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As those that a page sends."""
    monkeypatch.chdir(file.parent)
    for scenario in (Scenario.from_yaml(file), Scenario.from_yaml(file).self_contained()):
        with pytest.raises(InputError, match=r"ground\.map\.file: 'hills\.npy' needs a scenario in a file"):
            Scenario.from_dict(parse_yaml(scenario.to_yaml(), "a page"))
    with pytest.raises(InputError, match="needs a scenario in a file"):
        Scenario.model_validate({**ASKED, "ground": {"map": MAP}}).check()


def test_a_terrain_of_python_is_a_ground() -> None:
    base = Scenario.from_dict(ASKED)
    terrain = Terrain.from_map(HEIGHTS, 0.04, (-2.0, -2.0), yaw=0.1, parts=[STEP], friction=0.6)
    scenario = base.with_terrain(terrain)
    assert scenario.terrain == terrain
    assert Scenario.from_dict({**ASKED, "ground": terrain}) == scenario
    assert scenario.with_terrain(Terrain()) == base
    with pytest.raises(InputError, match="these heights are in no file"):
        Scenario.from_dict(scenario.to_dict())


# -- what happens to scenarios --

COPIES: dict[str, Callable[[Scenario], Scenario]] = {
    "pickle": lambda s: pickle.loads(pickle.dumps(s)),
    "deepcopy": copy.deepcopy,
    "model_copy": lambda s: s.model_copy(),
    "with_values": lambda s: s.with_values({"description": s.description}),
    "resolved": lambda s: s.resolved(),
    "self_contained": lambda s: s.self_contained(),
    "to another process": lambda s: pickle.loads(pickle.dumps(s.self_contained())).with_values(
        {"goal.x": 0.1}
    ),
}


@pytest.mark.parametrize("way", COPIES)
def test_the_ground_survives_without_its_file(file: Path, way: str) -> None:
    scenario = Scenario.from_yaml(file)
    changed = COPIES[way](without_file(scenario, file))
    assert changed.terrain == scenario.terrain
    if way in ("pickle", "deepcopy", "model_copy", "with_values"):
        assert changed == scenario
        assert hash(changed) == hash(scenario)


def test_scenarios_on_different_maps_differ(file: Path) -> None:
    one = Scenario.from_yaml(file)
    np.save(file.with_suffix(".npy"), 2.0 * HEIGHTS)
    other = Scenario.from_yaml(file)
    assert one.to_dict() == other.to_dict()
    assert one != other
    assert one.self_contained().to_dict() != other.self_contained().to_dict()


def test_other_keys_of_the_map_read_it_again(file: Path) -> None:
    scenario = Scenario.from_yaml(file).with_values({"ground.map.scale": 2.0, "ground.map.offset": 0.1})
    assert scenario.terrain == Terrain(
        0.0, 0.7, (), Terrain.from_map(HEIGHTS * 2.0 + 0.1, 0.04, [-2, -2]).map
    )
    with pytest.raises(FileError, match=r"'other\.npy' cannot be read"):
        scenario.with_values({"ground.map.file": "other.npy"})
    with pytest.raises(InputError, match="needs a scenario in a file"):
        scenario.self_contained().with_values({"ground.map.scale": 3.0})


def test_a_map_may_be_added_to_a_scenario_in_a_file(file: Path) -> None:
    wanted = Scenario.from_yaml(file).terrain
    file.write_text(dump_yaml({**ASKED, "ground": {"friction": 0.7}}))
    assert Scenario.from_yaml(file).with_values({"ground.map": MAP}).terrain == wanted


def test_another_file_than_was_meant_is_refused(file: Path) -> None:
    text = Scenario.from_yaml(file).self_contained().to_yaml()
    file.write_text(text)
    Scenario.from_yaml(file)
    np.save(file.with_suffix(".npy"), 2.0 * HEIGHTS)
    with pytest.raises(InputError, match=r"ground\.map\.digest: .* not those that were meant"):
        Scenario.from_yaml(file)


# -- plans --


def plan_on(scenario: Scenario) -> Plan:
    """A motion, made up, that says that it is on this ground."""
    flat = motion_plan(scenario.with_terrain(Terrain()))
    return replace(flat, scenario=scenario.self_contained())


def test_a_plan_carries_its_map(file: Path, tmp_path: Path) -> None:
    plan = plan_on(Scenario.from_yaml(file))
    path = plan.save(tmp_path / "plan.npz")
    file.with_suffix(".npy").unlink()
    loaded = Plan.load(path)
    assert loaded.scenario == plan.scenario
    assert loaded.scenario.terrain == Terrain(0.0, 0.7, (), hills().map)
    assert Plan.load(loaded.save(tmp_path / "again.npz")).scenario == plan.scenario


def test_a_plan_carries_ground_of_python(tmp_path: Path) -> None:
    heights = HEIGHTS.copy()
    heights[70:, 70:] = np.nan
    terrain = Terrain.from_map(heights, 0.04, (-2.0, -2.0), yaw=0.01, parts=[STEP])
    plan = plan_on(Scenario.from_dict(ASKED).with_terrain(terrain))
    assert Plan.load(plan.save(tmp_path / "plan.npz")).scenario.terrain == terrain


def _bent(name: str, change: Callable[[dict[str, Any], dict[str, Any]], None]) -> Any:
    return pytest.param(change, id=name)


@pytest.mark.parametrize(
    "change",
    [
        _bent("heights", lambda header, arrays: arrays.update({"ground/heights": 2.0 * HEIGHTS})),
        _bent("place", lambda header, arrays: header["map"].update(yaw=1.0)),
        _bent("no map", lambda header, arrays: header.pop("map")),
        _bent("no heights", lambda header, arrays: arrays.pop("ground/heights")),
        _bent("no ground", lambda header, arrays: header["scenario"]["ground"].pop("map")),
        _bent("three axes", lambda header, arrays: arrays.update({"ground/heights": np.zeros((3, 3, 3))})),
    ],
)
def test_a_plan_with_another_map_is_damaged(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Callable[[Any, Any], None]
) -> None:
    plan = plan_on(Scenario.from_yaml(file))
    write = ArchiveFormat.write

    def bent(self: ArchiveFormat, path: Path, header: Any, arrays: Any) -> Path:
        header = json.loads(json.dumps(header))
        change(header, arrays)
        return write(self, path, header, arrays)

    with monkeypatch.context() as patch:
        patch.setattr(ArchiveFormat, "write", bent)
        path = plan.save(tmp_path / "plan.npz")
    with pytest.raises(FileError, match="is damaged") as caught:
        Plan.load(path)
    assert "\n" not in str(caught.value)


# -- standing --


def test_a_goal_may_be_nearer_to_an_edge_than_a_start() -> None:
    front = find_scenario("hybrid-forward").body.stance[:, 0].max()
    scenario = Scenario.from_dict(ASKED)
    near = 0.14  # m: a step of 0.1 m touches this wheel from √(2 · 0.124 · 0.1 − 0.1²) = 0.122 m on
    at_goal = Terrain.from_parts([Step(x=0.3 + front + near, height=0.1)])
    assert scenario.with_terrain(at_goal).terrain == at_goal
    with pytest.raises(InputError, match=r"^start: .* at least 0\.03 m away from edges"):
        scenario.with_terrain(Terrain.from_parts([Step(x=front + near, height=0.1)]))
    with pytest.raises(InputError, match=r"^goal: .* stand in a riser"):
        scenario.with_terrain(Terrain.from_parts([Step(x=0.3 + front + 0.05, height=0.1)]))


def test_only_the_last_goal_is_stood_at() -> None:
    block = Terrain.from_parts([Block(x=0.75, y=0.0, length=0.2, width=4.0, height=0.1)])
    scenario = Scenario.from_dict({**ASKED, "horizon": 8.0})
    with pytest.raises(InputError, match=r"^goal:"):
        scenario.with_terrain(block)
    back = scenario.with_values({"goal.then": [{"at": 3.0, "x": 0.0}]})
    assert back.with_terrain(block).terrain == block
    there = scenario.with_values({"goal.x": 0.0, "goal.then": [{"at": 3.0, "x": 0.3}]})
    with pytest.raises(InputError, match=r"^goal\.then\.0:"):
        there.with_terrain(block)
