"""The pieces of the whole body stand where all its links stand."""

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")
pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from dataclasses import replace

from rollgait.mpc.setup import make_loop
from rollgait.robot.library import find_robot
from rollgait.view.clip import Clip
from rollgait.view.driving.chain import Chain
from rollgait.view.driving.messages import Body, Snapshot
from rollgait.view.driving.scene import clip_of
from rollgait.view.driving.session import Session
from rollgait.view.meshes import parts_of
from rollgait.view.rotations import matrix_from_quaternion

LEG_JOINTS = 24
"""Of CENTAURO; they come first among its joints."""


@pytest.fixture(scope="module")
def snapshot() -> Snapshot:
    return Session(lambda: make_loop("centauro", "mujoco")).snapshot()


def corners(clip: Clip) -> np.ndarray:
    """Lower and upper corner of the box around all parts, world."""
    points = [
        part.shape[0] @ matrix_from_quaternion(part.turn[:1, [1, 2, 3, 0]])[0].T + part.position[0]
        for part in parts_of(clip)
    ]
    every = np.concatenate(points)
    return np.stack([every.min(axis=0), every.max(axis=0)])


def pieces_corners(chain: Chain, body: Body) -> np.ndarray:
    R, p = chain.poses(body)
    points = [
        shape[0] @ R[number].T + p[number]
        for number, piece in enumerate(chain.pieces)
        for shape in piece.shapes.values()
    ]
    every = np.concatenate(points)
    return np.stack([every.min(axis=0), every.max(axis=0)])


@pytest.mark.parametrize("seed", range(3))
def test_all_points_are_where_the_links_have_them(snapshot: Snapshot, seed: int) -> None:
    robot = find_robot("centauro")
    chain = Chain(clip_of(robot, snapshot))
    random = np.random.default_rng(seed)
    first = snapshot.body
    assert first is not None
    angles = first.joint_position.copy()
    angles[:LEG_JOINTS] += random.normal(scale=0.5, size=LEG_JOINTS)
    quaternion = random.normal(size=4)
    body = Body(random.normal(size=3), quaternion / np.linalg.norm(quaternion), angles)
    assert pieces_corners(chain, body) == pytest.approx(
        corners(clip_of(robot, replace(snapshot, body=body))), abs=1e-6
    )
    assert len(chain.pieces) == 1 + LEG_JOINTS
