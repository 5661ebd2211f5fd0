"""The ground is seen where it is: it hides what is behind it, and what lies on it follows its heights."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from PIL import Image
from viser import SceneApi

from rollgait.cli.app import run
from rollgait.config import dump_yaml
from rollgait.scenario import find_scenario
from rollgait.terrain import Terrain
from rollgait.view.backdrop import BACKGROUND
from rollgait.view.camera import Camera
from rollgait.view.clip import clip_of_plan
from rollgait.view.figures import figure
from rollgait.view.layers.ground import FARTHEST, add_terrain
from rollgait.view.motion import goal_poses
from rollgait.view.on_ground import ABOVE, frames, grid_lines, laid_segments, normals
from rollgait.view.paths import TOLERANCE
from rollgait.view.scene import Scene
from rollgait.view.shapes import ball
from rollgait.view.software import SoftwareScene, render
from rollgait.view.standing_clip import clip_of_scenario
from rollgait.view.video import still
from tests.terrain.surface import away_from_edges
from tests.terrain.worlds import places, rounded, seeds, worlds
from tests.view.builders import laid_on, motion_plan, plan_on

PLAN = motion_plan(find_scenario("hybrid-forward"))
STAIRS = Terrain.from_parts([{"kind": "stairs", "x": 0.6, "steps": 3, "rise": 0.12, "tread": 0.4}])
CLIP = laid_on(STAIRS, clip_of_plan(PLAN, "stairs"))
RED = (210, 20, 20)


def red_in(image: Image.Image) -> int:
    r, g, b = np.moveaxis(np.asarray(image, dtype=float), -1, 0)
    return int(((r > 60.0) & (g < 0.4 * r) & (b < 0.4 * r)).sum())


@pytest.mark.parametrize(("x", "seen"), [(0.1, True), (1.0, False)], ids=["before", "behind"])
def test_a_wall_hides_what_is_behind_it(x: float, seen: bool) -> None:
    wall = Terrain.from_parts([{"kind": "block", "x": 0.5, "length": 0.2, "width": 3.0, "height": 1.0}])
    scene = SoftwareScene(wall)
    add_terrain(cast(SceneApi, scene), "/ground", wall, np.array([-1.0, -2.0]), np.array([2.0, 2.0]))
    vertices, faces = ball()
    scene.add_mesh_simple(
        "/ball", vertices=0.2 * vertices, faces=faces, color=RED, position=(x, 0.0, 0.2), cast_shadow=False
    )
    camera = Camera(np.array([-3.0, 0.0, 0.9]), np.array([0.5, 0.0, 0.3]))
    assert (red_in(render(scene, camera, (160, 120))) > 0) == seen


@pytest.mark.parametrize("far", [30.0, -1e6, 1e9])
def test_a_goal_that_is_anywhere_does_not_make_the_drawn_ground_endless(far: float) -> None:
    scenario = find_scenario("stairs-discover").edited({"goal.x": far, "goal.y": -far})
    scene = SoftwareScene(scenario.terrain)
    Scene(cast(SceneApi, scene), "/motion", clip_of_scenario(scenario, "far"))
    ground = [node for name, node in scene.nodes.items() if "/ground/" in name]
    drawn = [node.points if node.kind == "lines" else node.vertices for node in ground]
    assert {node.kind for node in ground} == {"lines", "mesh"}
    assert max(np.abs(np.asarray(each)[..., :2]).max() for each in drawn) < FARTHEST + 5.0


def test_a_shadow_falls_on_the_ground_where_it_is() -> None:
    """The same picture, all of it so much higher."""
    shift = np.array([0.0, 0.0, 0.7])
    pictures = []
    for up in (0.0 * shift, shift):
        ground = Terrain.from_parts(
            [{"kind": "block", "x": 5.0, "length": 1.0, "width": 1.0, "height": 0.2}], up[2]
        )
        scene = SoftwareScene(ground)
        add_terrain(cast(SceneApi, scene), "/ground", ground, np.array([-2.0, -2.0]), np.array([2.0, 2.0]))
        vertices, faces = ball()
        place = np.array([0.0, 0.0, 0.5]) + up
        scene.add_mesh_simple("/ball", vertices=0.2 * vertices, faces=faces, color=RED, position=tuple(place))
        camera = Camera(np.array([-3.0, -1.0, 1.5]) + up, np.array([0.0, 0.0, 0.2]) + up)
        pictures.append(np.asarray(render(scene, camera, (160, 120)), dtype=float))
    assert (pictures[0] != BACKGROUND).any()
    assert np.abs(pictures[0] - pictures[1]).mean() < 0.5


@settings(max_examples=30, deadline=None)
@given(worlds, seeds, rounded(-3.0, 3.0))
def test_what_lies_on_the_ground_is_on_it(terrain: Terrain, seed: int, heading: float) -> None:
    points = away_from_edges(terrain, places(seed, 20))
    R = frames(terrain, points, np.full(len(points), heading))
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.broadcast_to(np.eye(3), R.shape), atol=1e-9)
    np.testing.assert_allclose(R[..., 2], normals(terrain, points))
    np.testing.assert_allclose(np.arctan2(R[:, 1, 0], R[:, 0, 0]), heading, atol=1e-9)
    drawn = laid_segments(terrain, places(seed, 3)).mean(axis=1)
    drawn = drawn[np.isin(drawn[:, 0], away_from_edges(terrain, drawn[:, :2])[:, 0])]
    off = np.abs(drawn[:, 2] - ABOVE - terrain.height(*drawn[:, :2].T))
    assert np.median(off, axis=0) <= TOLERANCE if len(off) else True


def test_lines_on_a_map_end_where_it_is_not_known() -> None:
    heights = np.zeros((41, 41))
    heights[10:20, 10:20] = np.nan
    terrain = Terrain.from_map(heights, 0.05)
    lines = grid_lines(terrain, np.zeros(2), np.full(2, 2.0), 0.25)
    middles = lines.mean(axis=1)
    assert terrain.known(*middles[:, :2].T).all()
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()
    assert length == pytest.approx(18 * 2.0 - 4 * 0.55, abs=0.05)  # two each way meet what is not known


def test_the_robot_stands_on_the_ground_in_a_film() -> None:
    picture = np.asarray(still(CLIP, 0.0, (320, 180)), dtype=float)
    flat = np.asarray(still(clip_of_plan(PLAN, "flat"), 0.0, (320, 180)), dtype=float)
    sand = (picture[..., 0] > picture[..., 2] + 20.0).mean()
    assert sand > 0.1
    assert (flat[..., 0] > flat[..., 2] + 20.0).mean() < 0.05


def test_the_profile_shows_the_ground_under_each_foot() -> None:
    plan = plan_on(STAIRS, PLAN)
    picture = figure(plan, "profile")
    for leg, axes in enumerate(picture.axes):
        ground, path, stands = axes.lines
        x, z = np.asarray(ground.get_xdata()), np.asarray(ground.get_ydata())
        inside = np.abs(np.abs(x - 1.0) - 0.2) > 0.21
        y = PLAN.sample(0.0).foot_position[leg, 1]
        np.testing.assert_allclose(z[inside], STAIRS.height(x[inside], y), atol=1e-9)
        assert len(path.get_xdata()) == len(stands.get_xdata())
        assert np.isnan(np.asarray(stands.get_ydata())).any()
        assert axes.get_ylabel().endswith("z (m)")


def test_goals_are_as_high_and_tilted_as_their_ground() -> None:
    slope = np.radians(10.0)
    ramp = Terrain.from_parts([{"kind": "ramp", "x": 0.0, "length": 9.0, "slope_deg": 10.0}])
    (far,) = goal_poses(plan_on(ramp, PLAN).scenario, np.array([PLAN.horizon]))
    (flat,) = goal_poses(PLAN.scenario, np.array([PLAN.horizon]))
    np.testing.assert_allclose(far[[0, 1, 3]], flat[[0, 1, 3]])
    assert far[2] - flat[2] == pytest.approx(np.tan(slope) * far[0], abs=0.03)
    assert -slope < far[4] < -0.4 * slope


@pytest.mark.parametrize("name", ["top", "paths", "forces"])
def test_figures_show_the_ground_without_a_picture_in_them(name: str, tmp_path: Path) -> None:
    picture = figure(plan_on(STAIRS, PLAN), name)
    picture.savefig(tmp_path / "a.svg")
    content = (tmp_path / "a.svg").read_bytes()
    assert b"image/png" not in content or name == "top"  # there the scale of heights is one
    if name == "top":
        (bar,) = picture.axes[0].child_axes
        assert bar.get_ylabel() == "height (m)"


# -- rollgait ground show --

GROUND: dict[str, Any] = {
    "parts": [{"kind": "block", "x": 1.0, "length": 1.0, "width": 1.0, "height": 0.2}],
    "friction": 0.6,
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def asked(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert run(["ground", "show", *arguments, "--json"]) == 0
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    return result


def test_a_scenario_and_its_ground_alone_say_the_same(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("ground.yaml").write_text(dump_yaml(GROUND))
    Path("scenario.yaml").write_text(dump_yaml({"robot": "centauro", "goal": {"x": 0.1}, "ground": GROUND}))
    one, other = asked(capsys, "ground.yaml"), asked(capsys, "scenario.yaml")
    assert one.pop("file") != other.pop("file")
    assert one == other
    assert one["height"] == {"min": 0.0, "max": 0.2}
    assert one["regions"] == 2
    top = (1.0 - 0.06) ** 2
    below = one["size"][0] * one["size"][1] - (1.0 + 2 * (0.124 + 0.03)) ** 2
    assert one["standable"] == pytest.approx((top + below) / np.prod(one["size"]), abs=0.01)
    wider = asked(capsys, "ground.yaml", "--robot", "centauro-2020")
    assert wider["standable"] > one["standable"]


def test_a_map_is_shown_with_what_is_not_known(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = np.tile(np.linspace(0.0, 0.4, 81)[:, None], (1, 41))
    heights[:, :10] = np.nan
    np.save("ramp.npy", heights)
    options = ["ramp.npy", "--set", "map.resolution=0.05", "--set", "map.origin=[1, 2]", "--out", "ramp.png"]
    facts = asked(capsys, *options)
    assert facts["low"] == [1.0, 2.0]
    assert facts["size"] == pytest.approx([4.0, 2.0])
    assert facts["known"] == pytest.approx(0.75, abs=0.02)
    assert facts["slope_deg"]["max"] == pytest.approx(np.degrees(np.arctan(0.1)))
    assert facts["picture"] == "ramp.png"
    with Image.open("ramp.png") as picture:
        assert picture.size[0] > 600


WRONG = {
    "nothing.npy": "cannot be read",
    "ground.yaml --set height=abc": "ground.height",
    "ground.yaml --robot zebra": "robot: 'zebra'",
    "ground.yaml --out a.gif": "format: 'gif'",
    "meadow": "scenario: 'meadow'",
    "hills.npy": "ground.map.resolution",
}


@pytest.mark.parametrize("arguments", WRONG)
def test_a_wrong_ground_is_one_sentence(
    arguments: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("ground.yaml").write_text(dump_yaml(GROUND))
    np.save("hills.npy", np.zeros((20, 20)))
    before = sorted(folder.iterdir())
    assert run(["ground", "show", *arguments.split()]) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert error.startswith("error: ")
    assert error.count("\n") == 1
    assert WRONG[arguments] in error
    assert sorted(folder.iterdir()) == before
