"""Distances of bodies from the ground and of legs from one another, against what bounds them."""

from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from scipy.spatial import ConvexHull

import rollgait as rg
from rollgait.robot.hulls import SPACING, Hull, hulls_of
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_shapes import directions
from rollgait.robot.whole_body import library_whole_body, load_whole_body
from rollgait.tracking.clearance import COARSE, Clearances, nearest
from rollgait.tracking.report import joint_rows

ROLLER = Path(__file__).parent.parent / "fixtures" / "roller.yaml"


@pytest.fixture(scope="module")
def model() -> WholeBodyModel:
    return WholeBodyModel(library_whole_body("centauro"))


@pytest.fixture(scope="module")
def clearances(model: WholeBodyModel) -> Clearances:
    return Clearances(model)


def standing(model: WholeBodyModel, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> np.ndarray:
    """The model's posture on the plane z = 0, for a short while, (3, nv + 1)."""
    q = model.posture.copy()
    q[:2] = x, y
    q[2] -= model.state(q).p_foot[:, 2].min()
    q[3:7] = 0.0, 0.0, np.sin(0.5 * yaw), np.cos(0.5 * yaw)
    return np.tile(q, (3, 1))


TIME = np.array([0.0, 0.1, 0.2])


def in_world(model: WholeBodyModel, hull: Hull, q: np.ndarray, points: np.ndarray) -> np.ndarray:
    model.state(q)
    placement = model._data.oMi[hull.joint]
    return points @ placement.rotation.T + placement.translation


# -- hulls --


def test_samples_lie_on_their_hulls_and_close_to_each_other(model: WholeBodyModel) -> None:
    for hull in hulls_of(model)[::5]:
        planes = ConvexHull(hull.corners).equations
        depth = hull.surface @ planes[:, :3].T + planes[:, 3]
        assert np.allclose(depth.max(axis=1), 0.0, atol=1e-9)
        triangles = hull.corners[ConvexHull(hull.corners).simplices]
        rng = np.random.default_rng(0)
        weights = rng.dirichlet(np.ones(3), size=(len(triangles), 5))
        anywhere = np.einsum("tkc,tcx->tkx", weights, triangles).reshape(-1, 3)
        gaps = np.linalg.norm(anywhere[:, None] - hull.surface, axis=2).min(axis=1)
        assert gaps.max() < 2.0 * SPACING


def test_each_leg_has_shapes_and_one_wheel(model: WholeBodyModel) -> None:
    hulls = hulls_of(model)
    for leg in range(4):
        own = [hull for hull in hulls if hull.leg == leg]
        assert len(own) > 4
        assert [hull.link for hull in own if hull.touches] == [list(model.config.leg_list())[leg][1].wheel]
    assert any(hull.leg is None and hull.joint == 1 for hull in hulls)


# -- ground --


def test_clearance_is_the_height_of_the_lowest_point(model: WholeBodyModel, clearances: Clearances) -> None:
    q = standing(model)
    found = clearances.ground(TIME, q, rg.Terrain())
    assert found is not None
    low = {
        hull.link: in_world(model, hull, q[0], hull.corners)[:, 2].min()
        for hull in hulls_of(model)
        if not hull.touches
    }
    assert found.distance == pytest.approx(min(low.values()), abs=1e-9)
    assert low[found.where] == pytest.approx(found.distance)


@pytest.mark.parametrize("height", [-0.3, 0.04, 0.5])
def test_higher_ground_is_nearer_by_as_much(
    model: WholeBodyModel, clearances: Clearances, height: float
) -> None:
    q = standing(model)
    level, raised = (clearances.ground(TIME, q, rg.Terrain(level=z)) for z in (0.0, height))
    assert level is not None
    assert raised is not None
    assert level.distance - raised.distance == pytest.approx(height, abs=1e-9)


def test_a_block_under_the_belly_is_seen(model: WholeBodyModel, clearances: Clearances) -> None:
    """Where nothing but the belly is above it, and by as much as it is too high."""
    q = standing(model)
    body = [hull for hull in hulls_of(model) if hull.leg is None and hull.joint == 1]
    low = min(in_world(model, hull, q[0], hull.surface)[:, 2].min() for hull in body)
    height = low + 0.03
    block = {"kind": "block", "x": 0.0, "y": 0.0, "length": 0.2, "width": 0.2, "height": height}
    found = clearances.ground(TIME, q, rg.Terrain.from_parts([block]))
    assert found is not None
    assert found.where in {hull.link for hull in body}
    assert found.distance == pytest.approx(-0.03, abs=0.01)


def test_a_turned_world_is_as_near(model: WholeBodyModel, clearances: Clearances) -> None:
    parts = [
        {"kind": "ramp", "x": 0.1, "length": 3.0, "slope_deg": 12.0},
        {"kind": "step", "x": 0.6, "height": 0.3},
    ]
    ground = rg.Terrain.from_parts(parts)
    straight = clearances.ground(TIME, standing(model), ground)
    turned = clearances.ground(TIME, standing(model, yaw=0.9), ground.turned(0.9))
    assert straight is not None
    assert turned is not None
    assert straight.distance == pytest.approx(turned.distance, abs=1e-6)
    assert straight.where == turned.where


def test_unknown_ground_is_not_measured(model: WholeBodyModel, clearances: Clearances) -> None:
    q, heights = standing(model), np.full((60, 60), np.nan)
    heights[29:32, 29:32] = 0.0  # under the belly
    below, beside = (rg.Terrain.from_map(heights, 0.05, (x, -1.5)) for x in (-1.5, 8.5))
    everywhere, belly = (clearances.ground(TIME, q, ground) for ground in (rg.Terrain(), below))
    assert belly is not None
    assert everywhere is not None
    assert everywhere.distance < belly.distance
    assert clearances.ground(TIME, q, beside) is None


# -- legs --


def test_legs_are_as_far_apart_as_their_hulls_allow(model: WholeBodyModel, clearances: Clearances) -> None:
    """Not farther than any two corners, nor nearer than a plane between them says."""
    rng, legs = np.random.default_rng(1), [hull for hull in hulls_of(model) if hull.leg is not None]
    axes = directions(400)
    for _ in range(3):
        q = standing(model)
        q[:, 7:] += 0.15 * rng.normal(size=q.shape[1] - 7)
        found = clearances.legs(TIME, q)
        assert found is not None
        one, other = (
            next(in_world(model, hull, q[0], hull.corners) for hull in legs if hull.link == link)
            for link in found.where.split(", ")
        )
        corners = np.linalg.norm(one[:, None] - other, axis=2).min()
        between = ((other @ axes.T).min(axis=0) - (one @ axes.T).max(axis=0)).max()
        assert between - 1e-6 <= found.distance <= corners + 1e-6
        assert between > 0.9 * found.distance


def test_legs_that_run_into_each_other_are_seen(model: WholeBodyModel, clearances: Clearances) -> None:
    """Both front legs swung inwards about their hip_yaw axes until their wheels meet in the middle."""
    q = standing(model)
    for leg in (0, 1):
        angle = 1 + model.legs[leg].joints[0]
        trials = np.repeat(q[:1], 61, axis=0)
        trials[:, angle] += np.linspace(-2.0, 2.0, len(trials))
        aside = [abs(model.state(trial).p_foot[leg, 1]) for trial in trials]
        q[:, angle] = trials[int(np.argmin(aside)), angle]
    apart, met = clearances.legs(TIME, standing(model)), clearances.legs(TIME, q)
    assert apart is not None
    assert met is not None
    assert met.distance < 0.0 < apart.distance


def test_a_robot_of_primitives_has_clearances_too() -> None:
    model = WholeBodyModel(load_whole_body(ROLLER))
    found = Clearances(model)
    ground, legs = found.ground(TIME, standing(model), rg.Terrain()), found.legs(TIME, standing(model))
    assert ground is not None
    assert legs is not None
    assert ground.distance > 0.0
    assert legs.distance > 0.0


# -- over time --


@given(when=st.floats(0.0, 3.0), width=st.floats(0.2, 2.0))
def test_a_dip_between_two_looks_is_found(when: float, width: float) -> None:
    time = np.arange(601) / 200.0
    seen = np.abs(time - when) / width

    found = nearest(time, lambda chosen: (seen[chosen][:, None], ["only"]))
    assert found.distance == seen.min()
    assert found.time == time[np.argmin(seen)]
    assert time[1] < COARSE


@given(use=npst.arrays(bool, st.integers(2, 60)))
def test_the_time_at_the_limit_is_the_longest_run(use: np.ndarray) -> None:
    time = np.arange(len(use)) / 200.0
    share = np.where(use, 1.0, 0.5)[:, None]
    still = np.zeros((len(use) - 1, 1))
    rows = joint_rows(time, ("knee",), np.ones((len(use), 1)), still, np.ones(1), share)
    row = next(row for row in rows if row.name == "torque at limit")
    runs = [sum(1 for _ in run) for at_limit, run in groupby(use.tolist()) if at_limit]
    longest = max(runs, default=0) / 200.0
    assert row.worst == pytest.approx(longest)
    assert row.passed == (longest <= 0.05 + 1e-12)
