"""Rules of the robot's data, and statics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.errors import InputError, UnknownNameError
from rollgait.robot import GRAVITY, LEG_NAMES, Inertia, Robot, find_robot, robot_names
from rollgait.robot.robot import LegName

LIBRARY = [find_robot(name) for name in robot_names()]
library = pytest.mark.parametrize("robot", LIBRARY, ids=robot_names())
sizes = st.floats(0.05, 2.0)


def with_value(key: str, value: Any) -> dict[str, Any]:
    """The data of CENTAURO with one dotted key changed."""
    data = find_robot("centauro").model_dump(mode="json")
    *path, last = key.split(".")
    node = data
    for name in path:
        node = node[name]
    node[last] = value
    return data


@library
def test_the_library_holds_robots(robot: Robot) -> None:
    assert Robot(**robot.model_dump(mode="json")) == robot
    assert robot.description
    assert np.all(robot.static_forces() > 0.05 * robot.weight)
    assert np.linalg.eigvalsh(robot.inertia_matrix).min() > 0.0


@library
def test_the_library_holds_symmetric_stances(robot: Robot) -> None:
    fl, fr, hl, hr = robot.stance
    np.testing.assert_array_equal(fl * [1, -1, 1], fr)
    np.testing.assert_array_equal(hl * [1, -1, 1], hr)


@library
def test_names_are_those_of_the_files(robot: Robot) -> None:
    assert find_robot(robot.name) == robot


def test_a_robot_in_a_file_of_ones_own(tmp_path: Any) -> None:
    from rollgait.config import dump_yaml

    path = tmp_path / "mine.yaml"
    path.write_text(dump_yaml(with_value("name", "mine")))
    assert find_robot(str(path)).name == "mine"
    path.write_text(dump_yaml(with_value("mass", -1.0)))
    with pytest.raises(InputError, match=r"robot\.mass: -1\.0 must be greater than 0"):
        find_robot(str(path))


def test_unknown_robots_list_the_library_nearest_first() -> None:
    with pytest.raises(UnknownNameError) as caught:
        find_robot("centauro2020")
    assert caught.value.choices[0] == "centauro-2020"
    assert set(caught.value.choices) == set(robot_names())


@given(a=sizes, b=sizes, c=sizes, mass=st.floats(0.1, 500.0), seed=st.integers(0, 2**32 - 1))
def test_the_inertia_of_any_box_in_any_direction_is_taken(
    a: float, b: float, c: float, mass: float, seed: int
) -> None:
    principal = mass / 12.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    axes = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    tensor = axes @ np.diag(principal) @ axes.T
    inertia = Inertia(
        xx=tensor[0, 0], yy=tensor[1, 1], zz=tensor[2, 2], xy=tensor[0, 1], xz=tensor[0, 2], yz=tensor[1, 2]
    )
    np.testing.assert_allclose(inertia.matrix(), tensor, rtol=0.0, atol=1e-9 * principal.max())
    np.testing.assert_array_equal(inertia.matrix(), inertia.matrix().T)


@given(a=sizes, b=sizes, excess=st.floats(1e-3, 10.0))
def test_no_principal_moment_exceeds_the_sum_of_the_others(a: float, b: float, excess: float) -> None:
    with pytest.raises(InputError, match="must be the inertia of a body"):
        Inertia(xx=a, yy=b, zz=(a + b) * (1.0 + excess))


@pytest.mark.parametrize("products", [{"xy": 3.0}, {"xz": -2.5}, {"yz": 2.5}])
def test_products_of_inertia_too_large_for_a_body(products: dict[str, float]) -> None:
    with pytest.raises(InputError, match="must be the inertia of a body"):
        Inertia(xx=2.0, yy=2.0, zz=2.0, **products)


@pytest.mark.parametrize(
    ("key", "value", "rule"),
    [
        ("mass", -1.0, "must be greater than 0"),
        ("mass", 0.0, "must be greater than 0"),
        ("mass", "80 kg", "must be a number"),
        ("mass", True, "must be a number"),
        ("mass", float("nan"), "finite"),
        ("box", [0.1, 0.1], "box"),
        ("box", [0.1, 0.1, -0.1], "must be greater than 0"),
        ("legs.FL.foot", "wheel", "steerable"),
        ("legs.FL.wheel_radius", None, "must have a wheel_radius, as its foot is steerable"),
        ("legs.HR.wheel_radius", -0.1, "must be greater than 0"),
        ("legs.FR.stance", [0.3, -0.3, 0.7], "must have its stance below the CoM"),
        ("legs.FR.stance", [0.3, -0.3, -0.3], "nominal contact points of all legs at one height"),
        ("legs.HL.steering", [1.0, -1.0], "must be \\[smallest, largest\\]"),
        ("legs.HL.force_max", 0, "must be greater than 0"),
        ("legs.HL.wings", 2, "wings"),
        ("inertia.zz", 500.0, "must be the inertia of a body"),
    ],
)
def test_what_is_no_robot_is_one_sentence(key: str, value: Any, rule: str) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        Robot(**with_value(key, value))
    assert "\n" not in str(caught.value)
    assert caught.value.field.split(".")[0] in key or caught.value.field == "robot"


def test_the_robot_must_stand() -> None:
    data = find_robot("centauro").model_dump()
    for leg in data["legs"].values():
        leg["stance"] = (leg["stance"][0] + 1.0, *leg["stance"][1:])
    with pytest.raises(InputError, match="must stand"):
        Robot(**data)


@library
def test_static_forces_balance(robot: Robot) -> None:
    force = robot.static_forces()
    np.testing.assert_allclose(force.sum(), robot.mass * GRAVITY)
    np.testing.assert_allclose(force @ robot.stance[:, :2], 0.0, atol=1e-9)
    fl, fr, hl, hr = force
    np.testing.assert_allclose([fl, hl], [fr, hr])  # a symmetric robot stands symmetrically


@given(seed=st.integers(0, 2**32 - 1), count=st.sampled_from([3, 4]))
def test_static_forces_balance_on_any_feet(seed: int, count: int) -> None:
    robot, random = LIBRARY[0], np.random.default_rng(seed)
    p = robot.stance[random.permutation(4)[:count]] + random.uniform(-0.1, 0.1, (count, 3))
    force = robot.static_forces(p)
    np.testing.assert_allclose(force.sum(), robot.weight)
    np.testing.assert_allclose(force @ p[:, :2], 0.0, atol=1e-8)
    if count == 4:  # of all balances that of smallest norm: nothing of it lies in the null space
        null = np.linalg.svd(np.vstack([np.ones(4), p[:, 0], p[:, 1]]))[2][3]
        assert abs(force @ null) < 1e-8 * robot.weight


@pytest.mark.parametrize("foot", ["steerable", "fixed", "point"])
def test_other_feet_are_another_robot(foot: Any) -> None:
    robot = find_robot("centauro").with_feet(foot)
    assert [leg.foot for leg in robot.leg_list] == [foot] * 4
    assert robot.with_feet("steerable") == find_robot("centauro")


def test_the_legs_come_in_order() -> None:
    robot = find_robot("centauro")
    for name, leg, place in zip(LEG_NAMES, robot.leg_list, robot.stance, strict=True):
        assert leg == getattr(robot.legs, name)
        assert (place[0] > 0) == (name[0] == "F")
        assert (place[1] > 0) == (name[1] == "L")


def test_data_are_frozen() -> None:
    with pytest.raises(Exception, match="frozen"):
        find_robot("centauro").mass = 1.0  # type: ignore[misc]


@given(st.floats(1.0, 500.0), st.sampled_from(LEG_NAMES))
def test_values_that_are_set_are_there_and_all_others_stay(mass: float, leg: LegName) -> None:
    robot = find_robot("centauro")
    other = robot.with_values({"mass": mass, f"legs.{leg}.speed_max": 0.5})
    assert (other.mass, getattr(other.legs, leg).speed_max) == (mass, 0.5)
    back = {"mass": robot.mass, f"legs.{leg}.speed_max": getattr(robot.legs, leg).speed_max}
    assert other.with_values(back) == robot


def test_a_wrong_value_of_a_robot_is_one_sentence() -> None:
    for key, value in (("mass", -1.0), ("mas", 1.0), ("legs.FL.foot", "wheel"), ("legs.XX", "point")):
        with pytest.raises(InputError, match=key.replace(".", r"\.")):
            find_robot("centauro").with_values({key: value})
