"""`rollgait simulate` and `rollgait run`, from files to files; wrong input answered by one sentence."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.cli.app import run

SHORT = ["--set", "goal.x=0.2", "--set", "goal.y=0", "--set", "goal.yaw_deg=0", "--set", "horizon=2"]


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scenario = rg.Scenario(robot="centauro", goal={"x": 0.2}, horizon=2.0, gait={"kind": "drive"})
    return rg.plan(scenario).save(tmp_path_factory.mktemp("plans") / "plan.npz")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_plan_and_its_joints_give_the_same(plan_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["track", str(plan_file), "--out", "joints.npz"]) == 0
    capsys.readouterr()
    reports = []
    for motion in (str(plan_file), "joints.npz"):
        assert run(["simulate", motion, "--json", "--record", "log.npz"]) == 0
        reports.append(json.loads(capsys.readouterr().out))
    for report in reports:
        del report["real_time_factor"]
    assert reports[0] == reports[1]
    assert not reports[0]["fallen"]
    assert reports[0]["files"] == ["log.npz"]
    assert set(reports[0]["force_rms"]) == {"FL", "FR", "HL", "HR"}
    assert rg.SimulationLog.load("log.npz").report().final_distance == reports[0]["final_distance"]


def test_what_a_person_reads(plan_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--push", "20N:-x@1s", "--payload", "2kg", "--radius-error", "1%", "--latency", "2ms"]
    assert run(["simulate", str(plan_file), "--feedback", *arguments, "--slope", "1deg"]) == 0
    out = capsys.readouterr().out
    for words in ("feedback", "push 20 N to 180 deg", "payload 2 kg", "latency 2 ms", "slope 1 deg"):
        assert words in out
    assert "stays on its feet" in out


def test_a_fall_is_status_1(plan_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", str(plan_file), "--push", "8000N@0.5s:0.5s"]) == 1
    assert "falls after" in capsys.readouterr().out


def test_run_writes_everything_and_one_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["run", "wheeled", *SHORT, "--out", "all"]) == 0
    out = capsys.readouterr().out
    for words in ("certified", "position margin", "stays on its feet"):
        assert words in out
    names = {path.name for path in Path("all").iterdir()}
    assert names == {"plan.npz", "joints.npz", "simulation.npz", "report.html"}
    page = Path("all/report.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml;base64,") == 8
    for outside in ("http://", "https://", "<script"):
        assert outside not in page
    assert "stays on its feet" in page


def test_run_says_before_it_plans_what_is_not_installed(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert run(["run", "wheeled", *SHORT]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "needs the extra 'whole-body'" in err
    assert list(folder.iterdir()) == []


def test_a_plan_that_is_not_certified_is_executed_only_by_force(
    plan_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = rg.Plan.load(plan_file)
    replace(plan, statistics=replace(plan.statistics, solved=False)).save("spoilt.npz")
    assert run(["simulate", "spoilt.npz"]) == 1
    assert "--force" in capsys.readouterr().err
    assert run(["simulate", "spoilt.npz", "--force"]) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no-such.npz"], "no-such.npz"),
        (["text.npz"], "neither a plan nor"),
        (["other.npz"], "neither a plan nor"),
        (["PLAN", "--push", "50"], "50N@3s"),
        (["PLAN", "--push", "50N@99s"], "must begin within [0, "),
        (["PLAN", "--payload", "heavy"], "5kg"),
        (["PLAN", "--friction", "0"], "friction"),
        (["PLAN", "--friction", "slippery"], "0.6"),
        (["PLAN", "--latency", "3min"], "ms"),
        (["PLAN", "--radius-error", "90%"], "radius_error"),
        (["PLAN", "--slope", "steep"], "2deg"),
        (["PLAN", "--wheels", "square"], "angle"),
        (["PLAN", "--record", "."], "folder"),
        (["PLAN", "--video", "film.txt"], ".mp4"),
        (["PLAN", "--whole-body", "no-such.yaml"], "no-such.yaml"),
    ],
)
def test_wrong_input(
    arguments: list[str], words: str, plan_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("text.npz").write_text("no plan")
    np.savez("other.npz", header=np.array("[]"))
    before = set(Path().iterdir())
    assert run(["simulate", *[str(plan_file) if a == "PLAN" else a for a in arguments]]) == 2
    text = capsys.readouterr()
    assert words in text.err
    assert text.err.startswith("error: ")
    assert text.err.count("\n") == 1
    assert text.out == ""
    assert set(Path().iterdir()) == before


def test_a_viewer_needs_a_display(
    plan_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert run(["simulate", str(plan_file), "--viewer"]) == 2
    assert "display" in capsys.readouterr().err


@pytest.mark.slow
def test_a_film(plan_file: Path) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="needs the extra video")
    pytest.importorskip("OpenGL", reason="needs the extra video")
    from imageio import v3
    from imageio_ffmpeg import count_frames_and_secs
    from PIL import Image

    from rollgait.robot.whole_body import find_whole_body
    from rollgait.simulation.video import FRAME_RATE, HEIGHT, PAGE_RATE, WIDTH, RenderingError, save_video

    plan = rg.Plan.load(plan_file)
    fall = rg.Disturbances(pushes=({"force": 20000.0, "start": 0.0, "duration": 1.0},))
    short = rg.simulate(plan, fall)  # as short as a log can be
    assert short.fallen_at is not None
    body = find_whole_body(plan.robot)
    try:
        save_video(short, "film.gif", body)
    except RenderingError as error:
        pytest.skip(str(error))
    frames = v3.imread("film.gif")
    assert frames.shape[1:] == (HEIGHT, WIDTH, 3)
    assert frames.std() > 5.0
    middle = frames[0, HEIGHT // 2 - 20 : HEIGHT // 2 + 20, WIDTH // 2 - 20 : WIDTH // 2 + 20]
    assert middle.mean() < 120.0  # the dark trunk, not cut away to the pale ground behind it
    save_video(short, "film.webp", body)
    with Image.open("film.webp") as moving:
        assert moving.n_frames == len(frames)
    save_video(short, "film.mp4", body)
    count, _ = count_frames_and_secs("film.mp4")
    assert len(frames) == -(-count // round(FRAME_RATE / PAGE_RATE))
    assert abs(count - short.fallen_at * FRAME_RATE) <= 1.0
