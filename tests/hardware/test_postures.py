"""From any posture to the stance, bounded."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rollgait.hardware.postures import RISE_STEP, JointMotion, rise_of
from rollgait.mpc.mpc import Mpc
from rollgait.plant.stance import standing_state
from rollgait.robot.library import find_robot
from rollgait.robot.urdf_model import load_model
from rollgait.robot.whole_body import find_whole_body
from tests.hardware.rig import Rig


@pytest.mark.parametrize("name", ["centauro", "rover", "strider"])
def test_the_base_rises_over_feet_that_stay_where_they_are(name: str) -> None:
    robot = find_robot(name)
    model = load_model(find_whole_body(robot))
    rise = rise_of(model, robot)
    stance = standing_state(robot)
    wanted = stance.foot_position - stance.com_position
    states = [model.state(np.concatenate([np.zeros(3), [0.0, 0.0, 0.0, 1.0], row])) for row in rise.postures]
    feet = np.array([state.p_foot - state.p_com for state in states])
    np.testing.assert_allclose(feet[..., :2], np.broadcast_to(wanted[:, :2], feet[..., :2].shape), atol=1e-4)
    heights = -feet[..., 2].mean(axis=1)
    np.testing.assert_allclose(np.diff(heights), RISE_STEP, atol=1e-4)
    assert heights[-1] == pytest.approx(robot.height, abs=1e-4)
    assert heights[-1] - heights[0] >= 0.1
    others = [k for k in range(rise.postures.shape[1]) if k not in rise.wheels]
    assert np.all(rise.postures[:, others] >= model.position_lower[others] - 1e-6)
    assert np.all(rise.postures[:, others] <= model.position_upper[others] + 1e-6)


ROWS = arrays(float, st.tuples(st.integers(2, 5), st.just(4)), elements=st.floats(-3.0, 3.0))


@given(ROWS, st.floats(0.05, 2.0))
def test_no_joint_is_faster_than_its_bound_and_all_arrive(postures: np.ndarray, speed: float) -> None:
    motion = JointMotion(postures, speed)
    times = np.linspace(0.0, motion.duration, 200)
    rows = np.array([motion.at(time) for time in times])
    np.testing.assert_allclose(rows[0], postures[0], atol=1e-9)
    np.testing.assert_allclose(motion.at(motion.duration + 1.0), postures[-1], atol=1e-9)
    assert np.all(np.abs(np.diff(rows, axis=0)) <= speed * np.diff(times)[:, None] * (1.0 + 1e-6) + 1e-9)


@pytest.mark.parametrize("seed", [0, 1])
def test_from_a_posture_that_nobody_chose_the_robot_comes_to_its_stance(mpc: Mpc, seed: int) -> None:
    rise = rise_of(load_model(find_whole_body(mpc.robot)), mpc.robot)
    random = np.random.default_rng(seed)
    posture = rise.postures[4] + random.uniform(-0.12, 0.12, rise.postures.shape[1])
    rig = Rig(mpc, posture=posture)
    rig.enable()
    rig.until("active", 10.0)
    rig.run(0.5)
    assert rig.stands()
    truth = rig.robot.truth
    assert truth.com_position[2] - truth.foot_position[:, 2].mean() == pytest.approx(
        mpc.robot.height, abs=0.01
    )
    bounds = rig.bridge.plant._bounds
    position = np.array([each["position"] for each in rig.told])
    assert np.all(np.abs(np.diff(position, axis=0)) <= np.maximum(bounds.speed, 0.25) * 0.01 + 1e-9)
