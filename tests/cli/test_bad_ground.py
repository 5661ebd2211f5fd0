"""Grounds that are none, on the command line: one sentence that names the field, status 2, no file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rollgait.cli.app import run
from rollgait.config import dump_yaml

SAND = 0.001 * np.random.default_rng(2).standard_normal((101, 101))
HERE = {"file": "sand.npy", "resolution": 0.04, "origin": [-2.0, -2.0]}

BAD: dict[str, tuple[Any, str]] = {
    # the ground, what the sentence must contain
    "text": ("hills", "ground: 'hills' must be a mapping"),
    "part": ({"parts": [{"kind": "stair", "x": 1.0}]}, "valid: stairs"),
    "length": ({"parts": [{"kind": "gap", "x": 1.0}]}, "ground.parts.0.length: must be given"),
    "friction": ({"friction": 50.0}, "ground.friction: 50"),
    "kind": ({"kind": "flat", "map": HERE}, "'map': leave it out"),
    "no file": ({"map": {"resolution": 0.04}}, "ground.map.file: must be given"),
    "absent": ({"map": {**HERE, "file": "hills.npy"}}, "ground.map.file: 'hills.npy' cannot be read"),
    "out": ({"map": {**HERE, "file": "../sand.npy"}}, "must not leave the scenario's folder"),
    "absolute": ({"map": {**HERE, "file": "/etc/passwd"}}, "not an absolute path"),
    "resolution": ({"map": {"file": "sand.npy"}}, "ground.map.resolution: must be given"),
    "unit": ({"map": {**HERE, "scale": 1.0e4}}, "0.001 for mm"),
    "digest": ({"map": {**HERE, "digest": "0" * 64}}, "ground.map.digest"),
    "start off": ({"map": {**HERE, "origin": [0.0, -2.0]}}, "HL stands: that is off the map"),
    "goal off": ({"map": {**HERE, "origin": [-3.3, -2.0]}}, "FL stands: that is off the map"),
    "start in riser": ({"parts": [{"kind": "step", "x": 0.3, "height": 0.2}]}, "start: "),
    "goal in riser": ({"parts": [{"kind": "step", "x": 0.8, "height": 0.2}]}, "goal: "),
    "over a gap": ({"parts": [{"kind": "gap", "x": 0.2, "length": 0.3}]}, "over an edge"),
    "too steep": (
        {"parts": [{"kind": "ramp", "x": -2.0, "length": 5.0, "slope_deg": 40.0}]},
        "too steep",
    ),
    "stairs without end": (
        {"parts": [{"kind": "stairs", "x": 1.0, "steps": 100, "rise": 0.1, "tread": 0.3}] * 5},
        "at most 400 planar pieces",
    ),
    "hole at the goal": ({"map": {**HERE, "file": "hole.npy"}}, "FL stands: the ground there is not known"),
    "nothing known": ({"map": {**HERE, "file": "empty.npy"}}, "all its heights are NaN"),
    "too large": ({"map": {**HERE, "file": "large.npy"}}, "at most 4000000 cells, not 100000 × 100000"),
    "no grid": ({"map": {**HERE, "file": "deep.npy"}}, "must be a grid of heights"),
    "no bag": ({"map": {**HERE, "file": "bag"}}, "'bag' is not a ROS 2 bag"),
    "no picture": ({"map": {**HERE, "file": "text.png", "scale": 0.001}}, "is not a PNG that can be read"),
    "no format": ({"map": {**HERE, "file": "asked.yaml"}}, "valid: .npy"),
    "noise in mm": (
        {"map": {**HERE, "noise": 10.0}},
        "ground.map.noise: 10.0 must be a standard deviation from 0 to 0.1 m, or auto",
    ),
    "noise in words": (
        {"map": {**HERE, "noise": "loud"}},
        "ground.map.noise: 'loud' must be a standard deviation",
    ),
}
SECONDS = 5.0
"""CPU time within which each is refused, once all is imported."""


def _files(folder: Path) -> None:
    """The maps of the cases above."""
    np.save(folder / "sand.npy", SAND)
    hole = SAND.copy()
    hole[65:] = np.nan  # from x = 0.6 m on
    np.save(folder / "hole.npy", hole)
    np.save(folder / "empty.npy", np.nan * SAND)
    np.save(folder / "deep.npy", np.zeros((3, 3, 3)))
    with (folder / "large.npy").open("wb") as stream:  # a header that promises 80 GB
        header = {"descr": "<f8", "fortran_order": False, "shape": (100000, 100000)}
        np.lib.format.write_array_header_1_0(stream, header)
    (folder / "text.png").write_text("hills")
    (folder / "bag").mkdir()


@pytest.mark.parametrize("name", BAD)
def test_one_sentence(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ground, sentence = BAD[name]
    scenario = {"robot": "centauro", "goal": {"x": 0.5}, "ground": ground}
    (tmp_path / "asked.yaml").write_text(dump_yaml(scenario))
    _files(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    begin = time.process_time()
    assert run(["plan", "asked.yaml"]) == 2
    assert time.process_time() - begin < SECONDS
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert sentence in err
    assert sorted(tmp_path.rglob("*")) == before


def test_a_scenario_of_the_library_has_no_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", "wheeled", "--set", "ground.map={file: sand.npy, resolution: 0.04}"]) == 2
    assert "ground.map.file: 'sand.npy' needs a scenario in a file" in capsys.readouterr().err


def test_ground_is_shown_as_it_was_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What `rollgait show` prints is a scenario that shows itself."""
    ground = {"map": HERE, "parts": [{"kind": "step", "x": 1.5, "height": 0.1}]}
    (tmp_path / "asked.yaml").write_text(
        dump_yaml({"robot": "centauro", "goal": {"x": 0.1}, "ground": ground})
    )
    np.save(tmp_path / "sand.npy", SAND)
    monkeypatch.chdir(tmp_path)
    assert run(["show", "asked.yaml"]) == 0
    shown = capsys.readouterr().out
    assert "kind: step" in shown
    assert "file: sand.npy" in shown
    (tmp_path / "again.yaml").write_text(shown)
    assert run(["show", "again.yaml"]) == 0
    again = capsys.readouterr().out
    assert again.partition("\n")[2] == shown.partition("\n")[2]


def test_a_style_without_a_picture_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["ground", "show", "kerb", "--style", "paper"]) == 2
    assert "--style: 'paper' is of the picture that --out draws" in " ".join(capsys.readouterr().err.split())


def test_an_unknown_style_is_told_before_any_work(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(["ground", "show", "kerb", "--style", "dark", "--out", str(tmp_path / "kerb.png")]) == 2
    assert "valid: paper, screen" in " ".join(capsys.readouterr().err.split())
