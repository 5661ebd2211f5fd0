"""The whole body as kinematics: Jacobians against differences, contact points against their definition."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from rollgait.robot.urdf_model import BASE_V, KNEE_BEND_MIN, WholeBodyModel
from rollgait.robot.whole_body import library_whole_body, load_whole_body

FIXTURES = Path(__file__).parent.parent / "fixtures"
STEP = 1e-6


@pytest.fixture(scope="module", params=["centauro", "roller", "hyq"])
def model(request) -> WholeBodyModel:
    if request.param == "centauro":
        return WholeBodyModel(library_whole_body("centauro"))
    return WholeBodyModel(load_whole_body(FIXTURES / f"{request.param}.yaml"))


def configurations(model: WholeBodyModel, count: int = 10) -> list[tuple[np.ndarray, np.ndarray]]:
    """Configurations all about the posture, and directions in which they move."""
    rng = np.random.default_rng(0)
    spread = [model.integrate(model.posture, 0.3 * rng.normal(size=model.nv)) for _ in range(count)]
    return [(q, rng.normal(size=model.nv)) for q in spread]


@pytest.mark.parametrize("name", ["p_com", "p_base", "p_foot", "heading", "tilt", "camber"])
def test_jacobians_against_differences(model: WholeBodyModel, name: str) -> None:
    for q, v in configurations(model):
        after, before = (getattr(model.state(model.integrate(q, s * STEP * v)), name) for s in (1, -1))
        J = getattr(model.state(q), f"J_{name.removeprefix('p_')}")
        assert np.allclose(J @ v, (after - before) / (2 * STEP), atol=1e-7)


def test_angular_velocity_of_the_base(model: WholeBodyModel) -> None:
    for q, v in configurations(model, 3):
        state = model.state(q)
        R_after = model.state(model.integrate(q, STEP * v)).R_world_base
        R_rate = (R_after - state.R_world_base) / STEP
        S = R_rate @ state.R_world_base.T
        omega = np.array([S[2, 1], S[0, 2], S[1, 0]])
        assert np.allclose(state.J_base_angular @ v, omega, atol=1e-4)


def test_the_material_point_moves_against_the_rolling(model: WholeBodyModel) -> None:
    """Along the heading of an upright wheel: speed of the place of contact, less R times the rate."""
    state, rng = model.state(model.posture), np.random.default_rng(0)
    for v in rng.normal(size=(5, model.nv)):
        for i, leg in enumerate(model.legs):
            if leg.wheel is None:
                continue
            forward = np.array([np.cos(state.heading[i]), np.sin(state.heading[i]), 0.0])
            rolled = leg.radius * state.J_roll[i] @ v
            assert forward @ (state.J_contact[i] - state.J_foot[i]) @ v == pytest.approx(-rolled, abs=1e-4)


def test_contact_points_are_the_lowest_of_the_rim(model: WholeBodyModel) -> None:
    q = model.posture
    state = model.state(q)
    assert np.allclose(state.p_foot[:, 2], state.p_foot[:, 2].mean(), atol=1e-3)
    for i, leg in enumerate(model.legs):
        if leg.wheel is None:
            continue
        turned = q.copy()
        turned[leg.wheel + 1] += 1.234
        assert np.allclose(model.state(turned).p_foot[i], state.p_foot[i], atol=1e-9)


def test_each_leg_moves_only_its_own_foot(model: WholeBodyModel) -> None:
    state = model.state(model.posture)
    for i in range(4):
        for k, leg in enumerate(model.legs):
            moved = np.abs(state.J_foot[i][:, list(leg.joints)]).max()
            assert (moved > 1e-3) == (i == k)


def test_wheels_turn_without_limit(model: WholeBodyModel) -> None:
    for leg in model.legs:
        if leg.wheel is not None:
            assert model.position_lower[leg.wheel - BASE_V] == -np.inf
            assert model.position_upper[leg.wheel - BASE_V] == np.inf


def test_five_joints_control_heading_and_tilt_three_neither() -> None:
    centauro = WholeBodyModel(library_whole_body("centauro"))
    assert centauro.orientation_rows == (("heading", "tilt"),) * 4
    roller = WholeBodyModel(load_whole_body(FIXTURES / "roller.yaml"))
    assert roller.orientation_rows == ((),) * 4


def test_knees_stay_on_their_side() -> None:
    model = WholeBodyModel(library_whole_body("centauro"))
    for number in range(1, 5):
        knee = model.joint_names.index(f"knee_pitch_{number}")
        angle = model.posture[BASE_V + 1 + knee]
        low, high = model.position_lower[knee], model.position_upper[knee]
        assert low < angle < high
        assert min(abs(low), abs(high)) == pytest.approx(KNEE_BEND_MIN, abs=1e-6)  # straight is at 0


def test_a_welded_root_moves_freely() -> None:
    model = WholeBodyModel(load_whole_body(FIXTURES / "roller.yaml"))
    assert model.nv == BASE_V + 16
    assert model.mass == pytest.approx(40.0)


def test_centauro_is_the_model_of_the_facts() -> None:
    model = WholeBodyModel(library_whole_body("centauro"))
    assert (model.nv, len(model.joint_names)) == (45, 39)
    assert model.mass == pytest.approx(117.118, abs=1e-3)
    assert {leg.radius for leg in model.legs} == {0.124}
