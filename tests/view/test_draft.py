"""A draft is a scenario with a past; what it becomes as a file comes back from it."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from rollgait.errors import InputError  # isort: skip  # the line above skips where viser is absent
from rollgait.ocp.problem import standard_terms  # isort: skip
from rollgait.robot.library import robot_names  # isort: skip
from rollgait.scenario import Scenario, find_scenario, scenario_names  # isort: skip
from rollgait.terrain.parts import PART_KINDS  # isort: skip
from rollgait.view.clip import clip_of_plan  # isort: skip
from rollgait.view.design.draft import STROKE, Draft  # isort: skip
from rollgait.view.design.files import (  # isort: skip
    MAPS_MAX,
    as_python,
    kept_map,
    scenario_file,
    scenario_from_page,
)
from rollgait.view.design.handles import Selection  # isort: skip
from rollgait.view.design.loads import (  # isort: skip
    KINDS,
    Kind,
    Place,
    places,
    with_load,
    without_load,
)
from rollgait.view.design.parts import (  # isort: skip
    footprint,
    with_copy_of_part,
    with_goal,
    with_part,
    without_goal,
    without_part,
)
from rollgait.view.design.runs import RUNS_MAX, Runs, differences, figures  # isort: skip
from rollgait.view.exports import exported  # isort: skip
from rollgait.view.panels.design.terms import removable  # isort: skip
from tests.view.builders import motion_plan  # isort: skip

BASE = find_scenario("wheeled")
PLAN = motion_plan(find_scenario("hybrid-forward"))
changes = st.sampled_from(
    [
        {"goal.x": 0.4},
        {"goal.y": -0.2},
        {"start.yaw_deg": 10.0},
        {"horizon": 12.0},
        {"gait.kind": "crawl"},
        {"weights.acc": 2.0},
        {"bounds.force_min": 30.0},
        {"ground.friction": 0.7},
    ]
)
draft_changes = st.lists(changes, max_size=8)
kinds = st.sampled_from(PART_KINDS)


class Clock:
    """Seconds that go on when told to."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def new_draft(scenario: Scenario = BASE, clock: Clock | None = None) -> Draft:
    return Draft(scenario, "mine", lambda: None, clock or Clock())


@given(draft_changes)
def test_undo_goes_all_the_way_back_and_redo_all_the_way_ahead(values: list[dict[str, Any]]) -> None:
    draft, seen = new_draft(), [BASE]
    for each in values:
        draft.change(each)
        if draft.scenario != seen[-1]:
            seen.append(draft.scenario)
    for wanted in seen[-2::-1]:
        draft.undo()
        assert draft.scenario == wanted
    assert not draft.can_undo
    for wanted in seen[1:]:
        draft.redo()
        assert draft.scenario == wanted
    assert not draft.can_redo


@given(st.lists(st.floats(0.1, 1.0), min_size=2, max_size=20))
def test_a_drag_is_undone_at_once_and_two_drags_one_after_the_other(ways: list[float]) -> None:
    clock = Clock()
    draft = new_draft(clock=clock)
    for way in ways:
        draft.change({"goal.x": way}, "goal 0")
    clock.now += STROKE + 0.1
    middle = draft.scenario
    draft.change({"goal.x": 1.5}, "goal 0")
    draft.undo()
    assert draft.scenario == middle
    draft.undo()
    assert draft.scenario == BASE


def test_what_cannot_be_leaves_the_draft_and_what_cannot_stand_is_said() -> None:
    draft = new_draft()
    for values in ({"horizon": -1.0}, {"goal.x": "far"}, {"nothing": 1}, {"ground.parts.0.x": 1.0}):
        with pytest.raises(InputError):
            draft.change(values)
        assert draft.scenario is BASE
    assert draft.fault == ""
    draft.change({"goal.x": 900.0})
    assert "goal" in draft.fault
    draft.undo()
    assert draft.fault == ""


@given(st.lists(kinds, min_size=1, max_size=3), st.floats(-180.0, 180.0))
def test_a_new_part_leaves_the_robot_its_place(parts: list[str], yaw: float) -> None:
    scenario = BASE.edited({"start.yaw_deg": yaw, "goal.x": 0.0, "goal.y": 0.0, "goal.yaw_deg": yaw})
    for kind in parts:
        scenario = scenario.edited(with_part(scenario, kind))
    scenario.check()
    assert [part.kind for part in scenario.ground.parts] == parts
    for part in scenario.ground.parts:
        outline = footprint(part)
        assert np.isfinite(outline).all()
        np.testing.assert_array_equal(outline[0], outline[-1])
    copied = scenario.edited(with_copy_of_part(scenario, 0))
    assert copied.edited(without_part(copied, len(parts))) == scenario


@pytest.mark.parametrize("robot", robot_names())
def test_every_robot_carries_what_the_page_gives_it(robot: str) -> None:
    scenario = BASE.edited({"robot": robot, "goal": {"x": 0.0}})
    mass = scenario.body.mass
    for kind in KINDS:
        scenario = scenario.edited(with_load(scenario, kind))
    scenario.check()
    (payload,), (pull,) = scenario.loads.payload, scenario.loads.wrench
    assert scenario.body.mass == pytest.approx(mass + payload.mass)
    assert pull.force[0] < 0.0 > pull.at[0]  # something behind it that it draws
    again = scenario_from_page(scenario_file(scenario, "mine", Path())[1], "mine.yaml")
    assert again.to_dict() == scenario.to_dict()


@given(st.lists(st.sampled_from(KINDS), min_size=1, max_size=5), st.data())
def test_a_load_more_and_that_load_less_is_the_same(kinds: list[Kind], data: Any) -> None:
    scenario = BASE
    for number, kind in enumerate(kinds):
        scenario = scenario.edited(with_load(scenario, kind))
        place = Place(kind, kinds[:number].count(kind))
        scenario = scenario.edited({f"{place.key}.at": [0.01 * number, 0.0, 0.0]})
    kind = data.draw(st.sampled_from(KINDS))
    more = scenario.edited(with_load(scenario, kind))
    assert more.edited(without_load(more, Place(kind, kinds.count(kind)))) == scenario
    there = places(scenario)
    assert len(there) == len(kinds)
    gone = data.draw(st.sampled_from(there))
    less = scenario.edited(without_load(scenario, gone))
    assert [place.of(less) for place in places(less)] == [
        place.of(scenario) for place in there if place != gone
    ]


@pytest.mark.parametrize("name", scenario_names())
def test_what_can_be_left_out_is_a_constraint_of_the_problem(name: str) -> None:
    scenario = find_scenario(name)
    names = removable(scenario)
    assert {"box", "friction"} <= set(names)
    assert not {"acc", "ground", "stance_motion"} & set(names)  # a cost, and what is no limit
    assert set(names) <= {term.name for term in standard_terms(scenario)}


@given(st.integers(1, 3), st.data())
def test_a_goal_more_and_that_goal_less_is_the_same(count: int, data: Any) -> None:
    scenario = BASE
    for _ in range(count):
        scenario = scenario.edited(with_goal(scenario))
    assert len(scenario.goal.then) == count
    times = [0.0, *(later.at for later in scenario.goal.then), scenario.horizon]
    assert times == sorted(times)
    more = scenario.edited(with_goal(scenario))
    assert more.edited(without_goal(more, count + 1)) == scenario
    number = data.draw(st.integers(0, count))
    places = [(goal.x, goal.y) for goal in (scenario.goal, *scenario.goal.then)]
    less = scenario.edited(without_goal(scenario, number))
    assert [(goal.x, goal.y) for goal in (less.goal, *less.goal.then)] == (
        places[:number] + places[number + 1 :]
    )
    assert without_goal(BASE, 0) == {}


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-170.0, 170.0))
def test_what_is_selected_goes_where_it_is_dragged(x: float, y: float, yaw: float) -> None:
    scenario = BASE.edited(with_part(BASE, "block"))
    scenario = scenario.edited(with_goal(scenario))
    pose = {"x": x, "y": y, "yaw_deg": yaw}
    for what in (Selection("start"), Selection("goal"), Selection("goal", 1), Selection("part")):
        moved = what.of(scenario.edited(what.values(pose)))
        assert (moved.x, moved.y, moved.yaw_deg) == (x, y, yaw)
    assert Selection("part", 1).of(scenario) is None


@pytest.mark.parametrize("name", scenario_names())
def test_a_scenario_comes_back_from_its_file_and_from_its_program(name: str, tmp_path: Path) -> None:
    scenario = find_scenario(name)
    file, content = scenario_file(scenario, name, tmp_path)
    assert file == f"{name}.yaml"
    assert scenario_from_page(content, file).resolved().to_dict() == scenario.resolved().to_dict()
    if name != "rough":  # its map lies elsewhere
        assert told_by(as_python(scenario, name)).resolved() == scenario.resolved()


def told_by(program: str) -> Scenario:
    """The scenario that a program plans."""
    names: dict[str, Any] = {}
    exec(program.partition("plan = ")[0], names)
    scenario = names["scenario"]
    assert isinstance(scenario, Scenario)
    return scenario


def test_a_map_goes_with_its_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own, other = tmp_path / "own", tmp_path / "other"
    own.mkdir(), other.mkdir()
    x, y = np.meshgrid(np.linspace(-2.0, 2.0, 81), np.linspace(-2.0, 2.0, 81), indexing="ij")
    np.save(own / "hills.npy", 0.02 * np.sin(x) * np.cos(y))
    keys = {"file": "hills.npy", "resolution": 0.05, "origin": [-2.0, -2.0]}
    scenario = Scenario.from_dict({**BASE.to_brief_dict(), "goal": {"x": 0.5}, "ground": {"map": keys}}, own)
    file, content = scenario_file(scenario, "my hills", own)
    assert file == "my-hills.zip"
    assert sorted(zipfile.ZipFile(io.BytesIO(content)).namelist()) == ["hills.npy", "my-hills.yaml"]
    back = scenario_from_page(content, file, other)
    heights = back.ground.heights
    assert heights is not None
    assert scenario.ground.heights is not None
    assert heights.digest == scenario.ground.heights.digest
    planned = scenario.self_contained()  # as a plan holds it: heights, and no file
    file, content = scenario_file(planned, "again", other)
    assert file == "again.zip"
    third = scenario_from_page(content, file, other)
    assert third.ground.heights is not None
    assert third.ground.heights.digest == heights.digest
    monkeypatch.chdir(own)
    assert told_by(as_python(scenario, "hills")).ground.heights == scenario.ground.heights


def test_maps_of_one_name_stay_apart_and_are_not_too_many(tmp_path: Path) -> None:
    names = [kept_map(tmp_path, "../hills.NPY", bytes([number])) for number in range(MAPS_MAX)]
    assert len(set(names)) == MAPS_MAX
    assert all((tmp_path / name).read_bytes() == bytes([number]) for number, name in enumerate(names))
    assert kept_map(tmp_path, "hills.npy", bytes([3])) == names[3]
    with pytest.raises(InputError, match="too many"):
        kept_map(tmp_path, "hills.npy", b"another")
    with pytest.raises(InputError, match="too many"):
        kept_map(tmp_path, "valley.npy", b"another")


@pytest.mark.parametrize(
    "entries",
    [{"a.yaml": b"", "b.yaml": b""}, {"../a.yaml": b"robot: centauro\ngoal: {x: 0.5}"}, {"a.npy": b""}, {}],
)
def test_a_zip_that_is_no_scenario_is_refused(entries: dict[str, bytes], tmp_path: Path) -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    with pytest.raises(InputError, match="must hold one scenario"):
        scenario_from_page(stream.getvalue(), "mine.zip", tmp_path)
    with pytest.raises(InputError, match="not a zip"):
        scenario_from_page(stream.getvalue()[:10] + b"cut", "mine.zip", tmp_path)
    assert list(tmp_path.iterdir()) == []


@given(draft_changes)
def test_two_scenarios_differ_by_what_was_changed(values: list[dict[str, Any]]) -> None:
    other = BASE
    for each in values:
        other = other.edited(each)
    found = differences(BASE, other)
    assert {key: pair[::-1] for key, pair in found.items()} == differences(other, BASE)
    assert bool(found) == (BASE.to_brief_dict() != other.to_brief_dict())
    assert {key for key in found if key.startswith("goal")} <= {"goal.x", "goal.y"}


def test_runs_are_numbered_and_the_oldest_goes_first() -> None:
    runs, clip = Runs(), clip_of_plan(PLAN, "walk")
    added = [runs.add(clip_of_plan(PLAN, "walk"), PLAN.scenario) for _ in range(RUNS_MAX + 2)]
    assert [run.name for run in runs] == [run.name for run in added[2:]]
    assert len({run.name for run in added}) == len(added)
    assert runs.of(clip) is None
    assert runs.of(added[-1].clip) is added[-1]
    runs.remove(added[-1])
    assert runs.named(added[-1].name) is None
    told = figures(clip)
    assert told["steps"] == str(sum(1 for _ in PLAN.schedule.swings()))
    assert float(told["cost"]) == pytest.approx(PLAN.statistics.cost, rel=1e-3)


@pytest.mark.parametrize("format", ["csv", "json", "mcap", "rosbag2", "page (html)", "GIF"])
def test_every_format_of_a_plan_is_a_file_that_can_be_read(format: str) -> None:
    if format in ("mcap", "rosbag2"):
        pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    short = motion_plan(find_scenario("wheeled").with_values({"horizon": 1.0, "goal.x": 0.2, "goal.y": 0.0}))
    name, content = exported(clip_of_plan(short, "walk"), format, "walk")
    if format == "csv":
        rows = list(csv.DictReader(io.StringIO(content.decode())))
        assert float(rows[-1]["time"]) == pytest.approx(short.horizon)
    elif format == "json":
        assert json.loads(content)["format"] == "rollgait-motion"
    elif format == "rosbag2":
        assert {"walk.bag/metadata.yaml"} < set(zipfile.ZipFile(io.BytesIO(content)).namelist())
    begins = {"mcap": b"\x89MCAP0", "page (html)": b"<!doctype", "GIF": b"GIF8", "rosbag2": b"PK"}
    assert content.lower().startswith(begins.get(format, b"").lower())
    assert name.startswith("walk.")


def test_a_log_has_no_plan_to_be_exported() -> None:
    from dataclasses import replace

    clip = replace(clip_of_plan(PLAN, "log"), plan=None)
    with pytest.raises(InputError, match="holds plans and joints"):
        exported(clip, "csv", "log")
