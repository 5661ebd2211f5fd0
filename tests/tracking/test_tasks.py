"""Every task: its Jacobian is how its error falls, and at its target the error is nothing."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import library_whole_body
from rollgait.tracking import tasks

STEP = 1e-6


@pytest.fixture(scope="module")
def model() -> WholeBodyModel:
    return WholeBodyModel(library_whole_body("centauro"))


def all_tasks(model: WholeBodyModel) -> list[tasks.Task]:
    return [
        tasks.FootPosition(),
        tasks.WheelHeading(model),
        tasks.FootTilt(model),
        tasks.WheelCamber(model),
        tasks.CentreOfMass(),
        tasks.WaistPosition(np.array([0.1, -0.2, 0.3])),
        tasks.WaistOrientation(),
        tasks.Posture(model, model.posture, tasks.upper_body(model)),
        tasks.Posture(model, model.posture, tasks.leg_joints(model)),
    ]


def target_at(state) -> tasks.Target:
    return tasks.Target(state.p_com, state.R_world_base, state.p_foot, state.heading, np.zeros(4))


@pytest.mark.parametrize("number", range(9))
def test_the_error_falls_by_the_jacobian(model: WholeBodyModel, number: int) -> None:
    task, rng = all_tasks(model)[number], np.random.default_rng(number)
    for _ in range(5):
        q, v = model.integrate(model.posture, 0.2 * rng.normal(size=model.nv)), rng.normal(size=model.nv)
        state = model.state(q)
        target = target_at(state)
        after, before = (task.error(model.state(model.integrate(q, s * STEP * v)), target) for s in (1, -1))
        assert np.allclose(task.jacobian(state) @ v, (before - after) / (2 * STEP), atol=1e-6)


def test_at_the_target_nothing_is_missing(model: WholeBodyModel) -> None:
    state = model.state(model.posture)
    target = target_at(state)
    for task in (
        tasks.FootPosition(),
        tasks.WheelHeading(model),
        tasks.CentreOfMass(),
        tasks.WaistOrientation(),
    ):
        assert np.allclose(task.error(state, target), 0.0, atol=1e-12)


def test_headings_are_compared_round_the_circle(model: WholeBodyModel) -> None:
    state = model.state(model.posture)
    turned = replace(target_at(state), heading=state.heading + 2.0 * np.pi + 0.1)
    assert np.allclose(tasks.WheelHeading(model).error(state, turned), 0.1)


def test_a_leg_of_five_joints_is_not_asked_for_camber(model: WholeBodyModel) -> None:
    state = model.state(model.posture)
    assert tasks.WheelCamber(model).jacobian(state).shape == (0, model.nv)


def test_rolling_turns_the_wheel_forward(model: WholeBodyModel) -> None:
    """Forward is +q̇ on the left and −q̇ on the right of CENTAURO."""
    J = tasks.WheelRolling(model).jacobian(model.state(model.posture))
    own = [J[i, leg.wheel] for i, leg in enumerate(model.legs)]
    assert own == pytest.approx([1.0, -1.0, 1.0, -1.0], abs=1e-6)


def test_the_postures_share_the_joints(model: WholeBodyModel) -> None:
    upper, legs = set(tasks.upper_body(model)), set(tasks.leg_joints(model))
    assert not upper & legs
    assert len(upper) + len(legs) + 4 == len(model.joint_names)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.5, 3.0])
def test_rotation_vector(angle: float) -> None:
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    S = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    R = np.eye(3) + np.sin(angle) * S + (1.0 - np.cos(angle)) * S @ S
    assert np.allclose(tasks.rotation_vector(R), angle * axis, atol=1e-12)
