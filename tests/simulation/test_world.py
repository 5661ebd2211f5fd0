"""MuJoCo's robot is pinocchio's robot, and obeys the laws of mechanics."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import mujoco

from rollgait.errors import InputError
from rollgait.plant.disturbances import Disturbances, Payload
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import WholeBody, library_whole_body, load_whole_body
from rollgait.simulation.world import TIME_STEP, World, build_world

FIXTURES = Path(__file__).parent.parent / "fixtures"
ROBOTS = ("centauro", "roller", "hyq")


def whole_body(name: str) -> WholeBody:
    return library_whole_body(name) if name == "centauro" else load_whole_body(FIXTURES / f"{name}.yaml")


@pytest.fixture(scope="module", params=ROBOTS)
def model(request: pytest.FixtureRequest) -> WholeBodyModel:
    return WholeBodyModel(whole_body(request.param))


@pytest.fixture(scope="module")
def world(model: WholeBodyModel) -> World:
    return build_world(model.config, model.joint_names)


def put(world: World, data: "mujoco.MjData", q: np.ndarray) -> None:
    """A configuration in pinocchio's order."""
    world.put(data, q[:3], q[3:7], q[7:])


def some_configuration(model: WholeBodyModel, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return model.integrate(model.posture, rng.uniform(-0.3, 0.3, model.nv))


def test_centauro_has_45_velocities_and_117_kg() -> None:
    model = WholeBodyModel(library_whole_body("centauro"))
    world = build_world(model.config, model.joint_names)
    assert world.model.nv == 45
    assert world.model.body_mass.sum() == pytest.approx(117.118, abs=1e-3)


def test_mass_and_velocities_are_the_models(world: World, model: WholeBodyModel) -> None:
    assert world.model.nv == model.nv
    assert world.model.body_mass.sum() == pytest.approx(model.mass)
    assert np.array_equal(world.effort_max, model.effort_max)


def test_both_libraries_see_the_same_robot(world: World, model: WholeBodyModel) -> None:
    """CoM and feet at random postures: joints are mapped by name, quaternions in the right order."""
    data = mujoco.MjData(world.model)
    for seed in range(3):
        q = some_configuration(model, seed)
        put(world, data, q)
        mujoco.mj_forward(world.model, data)
        state = model.state(q)
        assert np.allclose(data.subtree_com[world.base], state.p_com, atol=1e-6)
        for leg, (foot, chain) in enumerate(zip(world.feet, model.legs, strict=True)):
            away = np.linalg.norm(data.geom_xpos[foot] - state.p_foot[leg])
            assert away == pytest.approx(chain.radius, abs=1e-6)
            if chain.wheel is not None:
                axle = data.geom_xmat[foot].reshape(3, 3)[:, 2]
                heading = np.arctan2(-axle[0], axle[1])
                assert abs(np.sin(heading - state.heading[leg])) < 1e-6


def test_both_libraries_see_the_same_gravity(world: World, model: WholeBodyModel) -> None:
    data = mujoco.MjData(world.model)
    q = some_configuration(model, 5)
    put(world, data, q)
    mujoco.mj_forward(world.model, data)
    expected = model.inverse_dynamics(q, np.zeros(model.nv), np.zeros(model.nv))
    assert np.allclose(data.qfrc_bias[world.velocity], expected[6:], atol=1e-4)
    assert data.qfrc_bias[2] == pytest.approx(model.mass * GRAVITY)


def test_in_free_fall_the_com_falls_and_momentum_stays(world: World, model: WholeBodyModel) -> None:
    data = mujoco.MjData(world.model)
    put(world, data, some_configuration(model, 1))
    data.qpos[2] += 10.0
    rng = np.random.default_rng(2)
    data.qvel[:6] = rng.uniform(-0.5, 0.5, 6)
    mujoco.mj_forward(world.model, data)
    mujoco.mj_subtreeVel(world.model, data)
    velocity = data.subtree_linvel[world.base].copy()
    momentum = data.subtree_angmom[world.base].copy()
    steps = 200
    for _ in range(steps):
        mujoco.mj_step(world.model, data)
    assert data.ncon == 0
    mujoco.mj_forward(world.model, data)
    mujoco.mj_subtreeVel(world.model, data)
    fallen = velocity - [0.0, 0.0, GRAVITY * steps * TIME_STEP]
    assert np.allclose(data.subtree_linvel[world.base], fallen, atol=0.02)
    assert np.allclose(data.subtree_angmom[world.base], momentum, atol=0.05 * np.linalg.norm(momentum))


def test_only_feet_and_ground_collide(world: World) -> None:
    data = mujoco.MjData(world.model)
    data.qpos[2] = -0.5
    data.qpos[3] = 1.0
    mujoco.mj_forward(world.model, data)
    touching = {max(pair) for pair in data.contact.geom.tolist()}
    assert touching <= set(world.feet)


def test_a_payload_adds_its_mass_and_moves_the_com(model: WholeBodyModel, world: World) -> None:
    place = np.array([0.1, 0.2, 0.3])
    given = Disturbances(payload=Payload(mass=4.0, place=tuple(place)))
    loaded = build_world(model.config, model.joint_names, given)
    assert loaded.model.body_mass.sum() == pytest.approx(model.mass + 4.0)
    data = mujoco.MjData(loaded.model)
    put(loaded, data, model.posture)
    mujoco.mj_forward(loaded.model, data)
    p_com = model.state(model.posture).p_com
    expected = (model.mass * p_com + 4.0 * place) / (model.mass + 4.0)
    assert np.allclose(data.subtree_com[loaded.base], expected, atol=1e-6)


def test_a_radius_error_changes_wheels_and_lifts_the_robot() -> None:
    body = whole_body("roller")
    names = WholeBodyModel(body).joint_names
    world = build_world(body, names, Disturbances(radius_error=0.02))
    assert world.lift == pytest.approx(0.02 * 0.1)
    assert np.allclose(world.radius, 0.1)
    assert np.allclose(world.model.geom_size[list(world.feet), 0], 0.102)


def test_a_joint_that_is_not_there() -> None:
    with pytest.raises(InputError, match="no_such_joint"):
        build_world(whole_body("roller"), ("no_such_joint",))


def test_a_missing_mesh_is_left_out(tmp_path: Path) -> None:
    text = (FIXTURES / "roller.urdf").read_text()
    visual = '<visual><geometry><mesh filename="no-such.stl"/></geometry></visual>'
    broken = tmp_path / "roller.urdf"
    broken.write_text(text.replace('<link name="trunk">', f'<link name="trunk">{visual}', 1))
    body = whole_body("roller").model_copy(update={"urdf": str(broken)})
    names = WholeBodyModel(whole_body("roller")).joint_names
    assert build_world(body, names).model.nv == len(names) + 6
    assert build_world(body, names, visual=True).model.nmesh == 0
