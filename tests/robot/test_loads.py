"""What a robot carries: laws of mass, CoM and inertia, and the keys of `loads:`, one sentence per mistake."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.dynamics.wrench import external, wrench_numbers
from rollgait.errors import InputError
from rollgait.robot.library import find_robot
from rollgait.robot.loads import Loads, Wrench
from rollgait.robot.robot import GRAVITY, Robot
from rollgait.scenario import Scenario, find_scenario
from tests.expressions import vectors

ROBOT = find_robot("centauro")
masses = st.floats(0.5, 30.0)
places = vectors(3, 0.2)


def points(robot: Robot, at: NDArray[np.float64]) -> list[tuple[float, NDArray[np.float64]]]:
    """Point masses about an origin `at` that have the robot's mass and inertia, its CoM where it is."""
    inertia = robot.inertia_matrix
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    sizes, axes = np.linalg.eigh(second)
    arms = (axes * np.sqrt(3.0 * sizes / robot.mass)).T
    return [(robot.mass / 6.0, at + sign * arm) for arm in arms for sign in (1.0, -1.0)]


def assert_same(a: Robot, b: Robot) -> None:
    assert a.mass == pytest.approx(b.mass)
    np.testing.assert_allclose(a.stance, b.stance, atol=1e-12)
    np.testing.assert_allclose(a.inertia_matrix, b.inertia_matrix, atol=1e-9)
    for one, other in zip(a.leg_list, b.leg_list, strict=True):
        assert one.limb is not None
        assert other.limb is not None
        np.testing.assert_allclose(one.limb.hip, other.limb.hip, atol=1e-12)


def from_first_foot(robot: Robot) -> NDArray[np.float64]:
    """Corners of the boxes and centres of the spheres of a robot's underside, (n, 3), m."""
    boxes = [[box.x[k], box.y[k], box.z] for box in robot.underside.belly for k in (0, 1)]
    centres = [list(sphere.centre) for sphere in robot.underside.limbs]
    assert boxes
    assert centres
    return np.array(boxes + centres) - robot.stance[0]


@given(masses, places)
def test_a_load_has_the_mass_and_inertia_of_all_its_points(mass: float, at: NDArray[np.float64]) -> None:
    loaded = ROBOT.with_payload(mass, at.tolist())
    parts = [*points(ROBOT, np.zeros(3)), (mass, at)]
    total = sum(m for m, _ in parts)
    com = sum(m * x for m, x in parts) / total
    inertia = sum(m * ((x - com) @ (x - com) * np.eye(3) - np.outer(x - com, x - com)) for m, x in parts)
    assert loaded.mass == pytest.approx(total)
    np.testing.assert_allclose(loaded.com_offset, com, atol=1e-12)
    np.testing.assert_allclose(loaded.inertia_matrix, inertia, atol=1e-9)
    np.testing.assert_allclose(loaded.stance, ROBOT.stance - com, atol=1e-12)


@given(masses)
def test_a_point_at_the_com_only_adds_mass(mass: float) -> None:
    loaded = ROBOT.with_payload(mass)
    assert loaded.mass == pytest.approx(ROBOT.mass + mass)
    np.testing.assert_array_equal(loaded.stance, ROBOT.stance)
    np.testing.assert_allclose(loaded.inertia_matrix, ROBOT.inertia_matrix)


@given(masses, places, masses, places)
def test_loads_add_in_any_order(m: float, a: NDArray[np.float64], n: float, b: NDArray[np.float64]) -> None:
    both = ROBOT.with_payload(m, a.tolist()).with_payload(n, b.tolist())
    assert_same(both, ROBOT.with_payload(n, b.tolist()).with_payload(m, a.tolist()))
    assert_same(both.bare, ROBOT)


@given(masses, places)
def test_halves_at_one_place_are_the_whole(mass: float, at: NDArray[np.float64]) -> None:
    half = ROBOT.with_payload(0.5 * mass, at.tolist())
    whole = ROBOT.with_payload(mass, at.tolist())
    assert_same(half.with_payload(0.5 * mass, at.tolist()), whole)


def test_a_box_is_the_sum_of_its_bricks() -> None:
    edges, at, bricks = np.array([0.4, 0.2, 0.1]), np.array([0.05, -0.02, 0.2]), ROBOT
    for x in (-0.25, 0.25):
        for y in (-0.25, 0.25):
            place = at + edges * [x, y, 0.0]
            bricks = bricks.with_payload(2.0, place.tolist(), (edges * [0.5, 0.5, 1.0]).tolist())
    assert_same(bricks, ROBOT.with_payload(8.0, at.tolist(), edges.tolist()))


def test_feet_carry_what_is_added() -> None:
    loaded = ROBOT.with_payload(20.0, (0.1, 0.15, 0.3))
    forces = loaded.static_forces()
    assert forces.sum() == pytest.approx(ROBOT.weight + 20.0 * GRAVITY)
    moment = (forces[:, None] * (loaded.stance + loaded.com_offset)[:, :2]).sum(axis=0)
    np.testing.assert_allclose(moment, 20.0 * GRAVITY * np.array([0.1, 0.15]), atol=1e-9)


@given(masses, places)
def test_shapes_stay_over_the_feet_under_a_load(mass: float, at: NDArray[np.float64]) -> None:
    laden = ROBOT.with_payload(mass, at.tolist())
    for one in (laden, laden.bare):
        np.testing.assert_allclose(from_first_foot(one), from_first_foot(ROBOT), atol=1e-9)


def test_a_robot_keeps_its_loads_through_yaml() -> None:
    loaded = ROBOT.with_payload(20.0, (0.1, 0.15, 0.3), (0.2, 0.2, 0.2))
    assert Robot(**loaded.model_dump(mode="json")) == loaded


# -- wrenches --------------------------------------------------------------------------------------------


@given(
    st.lists(st.tuples(vectors(3, 100.0), vectors(3, 20.0), places, st.booleans()), min_size=1, max_size=4),
    vectors(3, 1.2),
    places,
)
def test_numbers_of_wrenches_are_their_sum(given_: list[Any], theta: Any, offset: Any) -> None:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("ZYX", theta)
    force, torque, wrenches = np.zeros(3), np.zeros(3), []
    for f, t, at, in_base in given_:
        f = f + np.array([1.0, 0.0, 0.0]) * (not f.any() and not t.any())
        frame = "base" if in_base else "world"
        wrenches.append(Wrench(force=tuple(f), torque=tuple(t), at=tuple(at), frame=frame))
        own, twist = (turn.apply(f), turn.apply(t)) if in_base else (f, t)
        force, torque = force + own, torque + twist + np.cross(turn.apply(at - offset), own)
    numbers = wrench_numbers(wrenches, offset, np.zeros(1), np.ones(1))[:, 0]
    found = external(numbers, turn.as_matrix().tolist())
    np.testing.assert_allclose(found[0], force, atol=1e-9)
    np.testing.assert_allclose(found[1], torque, atol=1e-9)


@given(st.floats(0.0, 5.0), st.floats(0.01, 3.0))
def test_shares_add_up_to_the_time_that_a_wrench_acts(start: float, lasts: float) -> None:
    wrench = Wrench(force=(1.0, 0.0, 0.0), start=start, end=start + lasts)
    nodes = np.linspace(0.0, 10.0, 38)
    total = wrench.share_of(nodes[:-1], nodes[1:]) @ np.diff(nodes)
    assert total == pytest.approx(lasts)


# -- keys ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("loads", "field", "words"),
    [
        ({"payload": {"mass": -1.0}}, "loads.payload.0.mass", "greater than 0"),
        ({"payload": {"at": [0, 0, 0]}}, "loads.payload.0.mass", "must be given"),
        ({"payload": {"mass": 1.0, "place": [0, 0, 0]}}, "loads.payload.0.place", "not a known key"),
        ({"payload": {"mass": 1.0, "at": [0, 0]}}, "loads.payload.0.at", "must have 3 values"),
        ({"payload": {"mass": 60.0, "at": [1.5, 0, 0]}}, "loads.payload", "the CoM over the feet"),
        ({"payload": {"mass": 500.0, "at": [0, 0, -2.0]}}, "loads.payload", "cannot stand"),
        ({"wrench": {}}, "loads.wrench.0", "a force or a torque"),
        ({"wrench": {"force": [1, 0, 0], "frame": "robot"}}, "loads.wrench.0.frame", "world"),
        ({"wrench": {"force": [1, 0, 0], "start": 3, "end": 2}}, "loads.wrench.0", "after it starts"),
        ({"wrench": {"force": [1, 0, 0], "start": 99}}, "loads.wrench.0.start", "within the horizon"),
        ({"wrench": {"force": [1, 0, 0], "start": 1, "end": 1.01}}, "loads.wrench.0.end", "an interval"),
        ({"wrench": [3]}, "loads.wrench.0", "must be a mapping"),
        ({"cart": {}}, "loads.cart", "not a known key"),
    ],
)
def test_a_mistake_is_one_sentence(loads: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(InputError) as error:
        find_scenario("wheeled").with_values({"loads": loads})
    assert error.value.field == field
    assert words in str(error.value)


def test_times_need_times() -> None:
    data = {"robot": "centauro", "goal": {"x": 0.5}, "gait": "discover"}
    pull = {"force": [-10, 0, 0]}
    Scenario.from_dict(data | {"loads": {"wrench": pull}})
    with pytest.raises(InputError, match="yet to be found"):
        Scenario.from_dict(data | {"loads": {"wrench": pull | {"end": 2.0}}})


def test_wrenches_go_from_node_to_node() -> None:
    pull = {"force": [-10, 0, 0], "start": 2.04, "end": 3.06}
    (put,) = find_scenario("wheeled").with_values({"loads": {"wrench": pull}}).wrenches
    assert (put.start, put.end) == pytest.approx((2.0, 3.1))
    (put,) = find_scenario("wheeled").with_values({"loads": {"wrench": pull | {"end": 99.0}}}).wrenches
    assert put.end == 99.0


def test_a_scenario_keeps_its_loads_through_yaml() -> None:
    from rollgait.config import parse_yaml

    loads = {"payload": {"mass": 20, "at": [0.1, 0.15, 0.3]}, "wrench": {"force": [-100, 0, 0], "end": 3}}
    scenario = find_scenario("wheeled").with_values({"loads": loads})
    for brief in (False, True):
        assert Scenario.from_dict(parse_yaml(scenario.to_yaml(brief), "text")) == scenario
    assert scenario.loads == Loads.model_validate(loads)
    assert scenario.with_values({"loads.payload.0.mass": 10.0}).body.mass == ROBOT.mass + 10.0
