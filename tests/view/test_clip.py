"""What the viewer makes of files: clips, marks, margins, plots, places of links; and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rollgait
from rollgait.cli.app import run
from rollgait.errors import FileError, InputError
from rollgait.robot.link_poses import link_poses
from rollgait.robot.urdf_files import read_urdf
from rollgait.scenario import find_scenario
from rollgait.view.clip import clip_of_joints, clip_of_log, clip_of_plan, frame_times
from rollgait.view.design.files import scenario_from_page
from rollgait.view.margins import friction_use, support_margin
from rollgait.view.marks import MOST
from rollgait.view.meshes import simplified
from rollgait.view.opening import open_clip
from rollgait.view.paths import TOLERANCE, segments_of
from rollgait.view.plots import cursor, draw, plots_of
from rollgait.view.shapes import ball, cylinder, prism, revolved, rim, tyre
from rollgait.view.standing_clip import clip_of_scenario
from tests.view.builders import motion_plan

PLAN = motion_plan(find_scenario("hybrid-forward"))
CLIP = clip_of_plan(PLAN, "hybrid-forward")
URDF = Path(__file__).parents[1] / "fixtures" / "roller.urdf"


def test_a_clip_is_the_plan_at_its_frames() -> None:
    assert CLIP.time[0] == 0.0
    assert CLIP.time[-1] == PLAN.horizon
    for time in (0.0, 3.3, PLAN.horizon):
        index = CLIP.frame(time)
        np.testing.assert_allclose(
            CLIP.samples.com_position[index], PLAN.sample(CLIP.time[index]).com_position
        )
        assert abs(CLIP.time[index] - time) <= 0.51 * CLIP.time[1]
    np.testing.assert_allclose(np.diff(frame_times(3.21)), frame_times(3.21)[1])


def test_a_wheel_turns_by_the_way_it_rolls() -> None:
    straight = clip_of_plan(motion_plan(find_scenario("wheeled").with_values({"goal": {"x": 1.0}})), "")
    s, radius = straight.samples, straight.robot.leg_list[0].wheel_radius or 0.0
    way = np.diff(s.foot_position[:, 0, :2], axis=0)
    rolled = np.linalg.norm(way, axis=1).sum()
    assert abs(straight.wheel_angle[-1, 0]) * radius == pytest.approx(rolled, rel=0.02)


def test_marks_are_the_worst_rows_of_the_certificate() -> None:
    rows = {row.name: row for row in PLAN.certificate().rows}
    assert 0 < len(CLIP.marks) <= MOST
    for mark in CLIP.marks:
        assert mark.time == rows[mark.title].time
        assert mark.failed == (rows[mark.title].verdict == "fail")
    failed = [mark.failed for mark in CLIP.marks]
    assert failed == sorted(failed, reverse=True)


def test_margins_by_their_definitions() -> None:
    use, margin = friction_use(CLIP), support_margin(CLIP)
    s = CLIP.samples
    assert np.isnan(use[~s.contact]).all()
    moved = clip_of_plan(PLAN, "")
    np.testing.assert_allclose(use, friction_use(moved))
    stance = s.foot_position[0, :, :2]
    side = stance[[0, 2], 1].min() - s.com_position[0, 1]  # the left edge runs along x at first
    assert margin[0] <= side + 1e-9
    assert margin[0] > 0.0


def test_plots_say_the_values_at_the_cursor() -> None:
    plots = plots_of(CLIP)
    assert [plot.title for plot in plots][:2] == ["normal force (N)", "wheel speed (m/s)"]
    index = CLIP.frame(4.0)
    html = cursor(plots[0], CLIP, index)
    for leg in range(4):
        assert f">{CLIP.samples.force[index, leg, 2]:z.0f}<" in html.replace("−", "-")
    assert "<script" not in draw(plots[0], CLIP)


@pytest.mark.parametrize(
    "shape", [cylinder(), ball(), tyre(0.1), prism(np.array([[1, 0], [0, 1], [-1, -1]]), 0, 1)]
)
def test_shapes_look_outwards(shape: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = shape
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = (np.cross(a, b) * c).sum() / 6.0  # of the divergence theorem: positive if all face outwards
    assert volume > 0.0
    assert rim(0.1)[1].max() < len(rim(0.1)[0])


def test_a_simplified_mesh_keeps_its_place_and_size() -> None:
    vertices, faces = ball(64)
    fewer, kept = simplified(vertices, faces, grid=0.15)
    assert len(fewer) < 0.5 * len(vertices)
    assert kept.max() < len(fewer)
    np.testing.assert_allclose(fewer.min(axis=0), vertices.min(axis=0), atol=0.1)
    np.testing.assert_allclose(fewer.max(axis=0), vertices.max(axis=0), atol=0.1)


def test_a_simplified_mesh_keeps_its_edges() -> None:
    profile = np.array(
        [[r, 0.0] for r in np.linspace(0.0, 1.0, 30)] + [[1.0, z] for z in np.linspace(0.05, 1.0, 20)]
    )
    vertices, faces = revolved(profile, 96)  # a cup with an edge all around
    fewer, _ = simplified(vertices, faces, grid=0.17)
    low = fewer[fewer[:, 2] < 0.1]
    assert np.linalg.norm(low[:, :2], axis=1).max() > 0.98
    np.testing.assert_allclose(low[:, 2], 0.0, atol=0.02)


def test_a_path_is_drawn_within_its_tolerance() -> None:
    for leg in range(4):
        line = CLIP.samples.foot_position[:, leg]
        ends = segments_of(line)
        assert len(ends) < 0.3 * len(line)
        for a, b in ends:
            chord, way = line[b] - line[a], line[a : b + 1] - line[a]
            share = np.clip(way @ chord / (chord @ chord), 0.0, 1.0)
            assert np.linalg.norm(way - share[:, None] * chord, axis=1).max() <= TOLERANCE
        drawn = np.linalg.norm(line[ends[:, 1]] - line[ends[:, 0]], axis=1).sum()
        assert drawn == pytest.approx(np.linalg.norm(np.diff(line, axis=0), axis=1).sum(), rel=0.05)


@pytest.mark.slow
def test_joints_and_logs_show_where_their_plan_ends() -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    pytest.importorskip("mujoco", reason="the extra 'simulation' is not installed")
    plan = rollgait.plan(
        find_scenario("wheeled").with_values({"horizon": 2.0, "goal": {"x": 0.3, "yaw_deg": 5.0}})
    )
    joints = rollgait.track(plan)
    goal = clip_of_plan(plan, "").goals[-1].pose
    for clip in (clip_of_joints(joints, ""), clip_of_log(rollgait.simulate(joints), "")):
        np.testing.assert_allclose(clip.goals[-1].pose[:4], goal[:4], atol=5e-3)


def test_links_are_where_pinocchio_has_them() -> None:
    pin = pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    urdf = read_urdf(URDF)
    model = pin.buildModelFromXML(urdf.text, pin.JointModelFreeFlyer())
    data, rng = model.createData(), np.random.default_rng(0)
    q = pin.neutral(model)
    q[7:] = rng.uniform(-1.0, 1.0, model.nq - 7)
    q[:3] = rng.normal(size=3)
    q[3:7] = rng.normal(size=4)
    q[3:7] /= np.linalg.norm(q[3:7])
    pin.framesForwardKinematics(model, data, q)
    poses = link_poses(urdf, tuple(model.names[2:]), q[None, 7:], q[None, :3], q[None, 3:7])
    for name, pose in poses.items():
        frame = data.oMf[model.getFrameId(name, pin.FrameType.BODY)]
        np.testing.assert_allclose(pose.p[0], frame.translation, atol=1e-9)
        np.testing.assert_allclose(pose.R[0], frame.rotation, atol=1e-9)


def spoilt(folder: Path, kind: str) -> Path:
    """A file that cannot be shown."""
    path = folder / f"{kind}.npz"
    if kind == "text":
        path.write_text("no plan")
    elif kind == "pickle":
        np.savez(path, header=np.array([{"format": "rollgait-plan"}], dtype=object))
    elif kind == "newer":
        PLAN.save(path)
        with np.load(path) as data:
            arrays = {key: data[key] for key in data.files}
        header = json.loads(str(arrays["header"])) | {"version": 99}
        np.savez(path, **(arrays | {"header": np.array(json.dumps(header))}))
    return path


@pytest.mark.parametrize("kind", ["text", "pickle", "newer", "missing"])
@pytest.mark.parametrize("command", ["view", "record"])
def test_what_is_no_motion_is_refused(
    kind: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    path = spoilt(tmp_path, kind)
    with pytest.raises(FileError):
        open_clip(path)
    options = ["--port", "0"] if command == "view" else ["--out", str(tmp_path / "a.html")]
    assert run([command, str(path), *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert error.count("\n") == 1
    assert not (tmp_path / "a.html").exists()


@pytest.mark.parametrize("port", ["-1", "70000", "http", "1.5"])
def test_a_port_must_be_one(port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    path = PLAN.save(tmp_path / "plan.npz")
    assert run(["view", str(path), f"--port={port}"]) == 2
    assert "[0, 65535]" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["hybrid-goback", "stairs"])
def test_a_scenario_stands_still_on_its_ground_at_its_start(name: str) -> None:
    scenario = find_scenario(name)
    clip = clip_of_scenario(scenario, name)
    s, start = clip.samples, scenario.start
    for values in (s.com_position, s.euler, s.foot_position):
        assert np.ptp(values, axis=0).max() == 0.0
    np.testing.assert_allclose(s.com_position[0, :2], [start.x, start.y], atol=1e-9)
    x, y, z = s.foot_position[0].T
    assert (z >= clip.terrain.height(x, y) - 1e-6).all()
    np.testing.assert_allclose(s.force[0].sum(axis=0), [0.0, 0.0, clip.robot.weight], atol=1e-6)
    assert len(clip.goals) == 1 + len(scenario.goal.then)
    assert clip.horizon == pytest.approx(scenario.horizon)


def test_a_draft_whose_gait_does_not_fit_is_shown_all_the_same() -> None:
    draft = find_scenario("hybrid-forward").edited(
        {
            "gait": {"kind": "schedule", "FL": [[1.0125, 1.05]]},
            "interval": 0.25,
            "loads.wrench": [{"force": [50, 0, 0], "start": 1.0}],
        }
    )
    with pytest.raises(InputError, match="2 intervals"):
        draft.check()
    assert clip_of_scenario(draft, "draft").wrenches == draft.loads.wrench


def test_a_scenario_in_a_file_opens_and_what_is_wrong_with_it_is_said(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(find_scenario("wheeled").to_yaml(brief=True))
    assert open_clip(file).scenario == find_scenario("wheeled")
    for content, said in (
        (b"robot: secret.yaml\ngoal: {x: 1}", "names a file"),
        (b"\xff\xfe", "not text"),
        (b"- 1", "mapping"),
        (b"robot: centauro\ngoal: {x: far}", "goal.x"),
    ):
        with pytest.raises(InputError, match=said):
            scenario_from_page(content, "x.yaml")
