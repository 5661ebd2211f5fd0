"""What learning people load is what the plans say."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rollgait as rg
from rollgait.dataset.exports import export
from rollgait.errors import FileError, UnknownNameError

pandas = pytest.importorskip("pandas")
RATE = 50


def test_a_lerobot_data_set_holds_the_samples_of_the_plans(library: rg.Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "lerobot"
    written = export(library, folder, "lerobot", RATE)
    info = json.loads((folder / "meta/info.json").read_text(encoding="utf-8"))
    frames = pandas.read_parquet(folder / info["data_path"].format(chunk_index=0, file_index=0))
    episodes = pandas.read_parquet(folder / "meta/episodes")
    tasks = pandas.read_parquet(folder / "meta/tasks.parquet")
    assert (written.motions, written.frames) == (info["total_episodes"], info["total_frames"])
    assert (len(episodes), len(frames)) == (written.motions, written.frames)
    assert (frames["index"] == np.arange(len(frames))).all()
    columns = set(info["features"])
    assert columns == set(frames.columns)
    state = info["features"]["observation.state"]["names"]
    for episode, row in enumerate(r for r in library.rows if r < 5):
        one = episodes.iloc[episode]
        mine = frames[one.dataset_from_index : one.dataset_to_index]
        assert (mine.episode_index == episode).all()
        assert len(mine) == one.length
        np.testing.assert_allclose(mine.timestamp * RATE, mine.frame_index, atol=1e-4)
        plan = library.plan(row)
        at = plan.sample(np.minimum(np.arange(one.length) / RATE, plan.horizon))
        values = np.stack(mine["observation.state"].to_numpy())
        np.testing.assert_allclose(values[:, :3], at.com_position, atol=1e-6)
        hind = state.index("HR_x")
        np.testing.assert_allclose(values[:, hind : hind + 3], at.foot_position[:, 3], atol=1e-6)
        assert tasks.index[mine.task_index.iloc[0]].startswith(library.sampler.asked(int(row)).family)
    stats = json.loads((folder / "meta/stats.json").read_text(encoding="utf-8"))
    actions = np.stack(frames.action.to_numpy()).astype(float)
    np.testing.assert_allclose(stats["action"]["mean"], actions.mean(axis=0), atol=1e-4)
    np.testing.assert_allclose(stats["action"]["std"], actions.std(axis=0), atol=1e-2)
    np.testing.assert_allclose(stats["action"]["max"], actions.max(axis=0), rtol=1e-6)
    with pytest.raises(FileError, match="is not an empty folder"):
        export(library, folder)


def test_wrong_wishes_are_refused(library: rg.Dataset, tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="valid: lerobot"):
        export(library, tmp_path / "x", "lerobt")
    with pytest.raises(rg.InputError, match="whole number of frames per second"):
        export(library, tmp_path / "x", rate=12.5)
    assert not (tmp_path / "x").exists()


def test_isaac_lab_gets_bodies_that_move_as_their_velocities_say(library: rg.Dataset, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    pytest.importorskip("daqp")
    from scipy.spatial.transform import Rotation

    written = export(library, tmp_path / "isaac", "isaaclab", RATE, rows=[1], workers=1)
    assert (written.motions, written.left_out) == (1, [])
    with np.load(tmp_path / "isaac" / "row-00000001.npz") as data:
        motion = dict(data)
    n, d, b = written.frames, len(motion["dof_names"]), len(motion["body_names"])
    assert motion["fps"] == RATE
    assert motion["dof_positions"].shape == motion["dof_velocities"].shape == (n, d)
    assert motion["body_positions"].shape == (n, b, 3)
    assert len(set(motion["body_names"])) == b
    assert all(array.dtype == np.float32 for name, array in motion.items() if name[:4] in ("dof_p", "body_p"))
    # the middle of a smooth motion, by central differences
    p, v = motion["body_positions"].astype(float), motion["body_linear_velocities"]
    w = motion["body_angular_velocities"]
    turn = Rotation.from_quat(motion["body_rotations"][..., [1, 2, 3, 0]].reshape(-1, 4))
    matrices = turn.as_matrix().reshape(n, b, 3, 3)
    step = matrices[2:] @ matrices[:-2].swapaxes(-1, -2)
    rate = Rotation.from_matrix(step.reshape(-1, 3, 3)).as_rotvec().reshape(n - 2, b, 3) * RATE / 2
    np.testing.assert_allclose((p[2:] - p[:-2]) * RATE / 2, v[1:-1], atol=0.005)
    np.testing.assert_allclose(rate, w[1:-1], atol=0.02)
    assert np.abs(v).max() > 0.05
    assert np.abs(w).max() > 0.2
