"""Ground in MuJoCo: what is dropped on it rests where `WheelSurface` says."""

import numpy as np
import pytest
from hypothesis import given, settings

pytest.importorskip("mujoco", reason="needs the extra whole-body")

import mujoco

from rollgait.simulation.ground_bodies import add_terrain
from rollgait.terrain import Terrain, WheelSurface
from tests.terrain import worlds

RADIUS = worlds.RADIUS
STEP = 1e-3
ABOVE = 0.01
"""m: so far above its place each ball is let go."""


def rest(terrain: Terrain, points: np.ndarray, disc: float | None = None) -> np.ndarray:
    """Heights of the lowest points of balls that have fallen, each on its own smooth vertical rail, (n,), m.

    Args:
        terrain: the ground.
        points: places of the rails, (n, 2), m.
        disc: yaw of a wheel in place of each ball, rad.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    add_terrain(spec, terrain, np.zeros(2), 1e-3, visual=False)
    radius = RADIUS
    begin = WheelSurface(terrain, radius).height(*points.T) + radius + ABOVE
    for (x, y), z in zip(points, begin, strict=True):
        body = spec.worldbody.add_body(pos=[x, y, z])
        body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0.0, 0.0, 1.0])
        common = {"contype": 1, "conaffinity": 0, "mass": 30.0}
        if disc is None:
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0.0, 0.0], **common)
        else:
            half = 0.25 * radius * np.array([-np.sin(disc), np.cos(disc), 0.0])
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=[radius] * 3, fromto=[*-half, *half], **common
            )
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(400):
        mujoco.mj_step(model, data)
    return np.asarray(data.qpos + begin - radius)


PARTS = {
    "plane": [],
    "ramp": [{"kind": "ramp", "x": 0.0, "length": 1.5, "width": 1.0, "slope_deg": 15.0}],
    "step": [{"kind": "step", "x": 0.2, "height": 0.15, "yaw_deg": 30.0}],
    "step down": [{"kind": "step", "x": 0.2, "height": -0.15, "yaw_deg": 30.0}],
    "stairs": [{"kind": "stairs", "x": -0.5, "steps": 3, "rise": 0.12, "tread": 0.4}],
    "gap": [{"kind": "gap", "x": 0.0, "length": 0.15, "depth": 0.5}],
    "block": [{"kind": "block", "x": 0.0, "length": 0.4, "width": 0.6, "height": 0.2, "yaw_deg": 20.0}],
    "pothole": [{"kind": "block", "x": 0.0, "length": 0.4, "width": 0.6, "height": -0.1, "yaw_deg": 20.0}],
}


@pytest.mark.parametrize("kind", PARTS)
def test_a_ball_rests_on_each_part_and_on_its_edges(kind: str) -> None:
    terrain = Terrain.from_parts(PARTS[kind], height=0.3)
    points = worlds.places(1, 40, half=0.6)
    assert np.allclose(rest(terrain, points), WheelSurface(terrain, RADIUS).height(*points.T), atol=1e-3)


@settings(max_examples=15, deadline=None)
@given(worlds.worlds)
def test_a_ball_rests_on_any_world_of_parts(terrain: Terrain) -> None:
    points = worlds.places(2, 30)
    touch = WheelSurface(terrain, RADIUS).touch(points)
    rests = touch.normal[:, 2] > 0.3  # else it hangs on an edge by its side, and slips past it
    assert np.allclose(rest(terrain, points)[rests], touch.height[rests], atol=1e-3)


@pytest.mark.parametrize("kind", PARTS)
def test_a_wheel_along_a_part_rests_as_a_ball_does(kind: str) -> None:
    """Upright, its heading along the slope or across the edge, where a ball's touch lies in its plane."""
    terrain = Terrain.from_parts([part | {"yaw_deg": 0.0} for part in PARTS[kind]])
    points = np.column_stack([np.linspace(-0.9, 0.9, 40), np.zeros(40)])
    found = rest(terrain, points, disc=0.0)
    assert np.allclose(found, WheelSurface(terrain, RADIUS).height(*points.T), atol=1e-3)


def hills() -> Terrain:
    """Smooth measured ground, turned, a part on it."""
    x, y = np.meshgrid(np.arange(61), np.arange(81), indexing="ij")
    values = 0.05 * np.sin(0.12 * x) * np.cos(0.09 * y) + 0.002 * x
    return Terrain.from_map(values, 0.04, (-1.2, -1.6), yaw=0.2)


def test_a_ball_rests_on_a_map() -> None:
    points = worlds.places(3, 40, half=0.8)
    terrain = hills()
    assert np.allclose(rest(terrain, points), WheelSurface(terrain, RADIUS).height(*points.T), atol=1e-3)


def test_parts_on_a_map_are_what_is_touched() -> None:
    """Raised and sunk ones, away from the cells in which the map goes down under them."""
    parts = [
        {"kind": "block", "x": 0.3, "y": 0.3, "length": 0.5, "width": 0.5, "height": 0.3},
        {"kind": "block", "x": -0.4, "y": -0.3, "length": 0.7, "width": 0.7, "height": -0.2},
    ]
    terrain = Terrain.from_map(hills().map.values, 0.04, (-1.2, -1.6), parts=parts)
    points = np.array([[0.3, 0.3], [0.2, 0.4], [-0.4, -0.3], [-0.45, -0.25], [0.9, -0.9]])
    assert np.allclose(rest(terrain, points), WheelSurface(terrain, RADIUS).height(*points.T), atol=1e-3)


@pytest.mark.parametrize("kind", ["plane", "ramp", "stairs", "block"])
def test_parts_and_the_same_ground_measured_agree(kind: str) -> None:
    """Away from edges, which a raster has within a cell."""
    exact, cell = Terrain.from_parts(PARTS[kind]), 0.02
    measured = exact.raster(cell, (-1.2, -1.2), (1.2, 1.2))
    points = worlds.places(4, 60, half=0.9)
    heights = [rest(terrain, points) for terrain in (exact, measured)]
    reach = RADIUS + cell
    near = points[:, None, :] + np.array([[i, j] for i in (-reach, 0, reach) for j in (-reach, 0, reach)])
    level = np.ptp(exact.slope(near[..., 0], near[..., 1]), axis=1).max(axis=1) < 1e-9
    level &= np.ptp(exact.height(near[..., 0], near[..., 1]), axis=1) < 0.1
    assert level.sum() > 10
    assert np.allclose(*(height[level] for height in heights), atol=1e-3)


def test_unknown_ground_is_a_pit() -> None:
    values = np.zeros((41, 41))
    values[15:26, 15:26] = np.nan
    terrain = Terrain.from_map(values, 0.1, (-2.0, -2.0))
    outside = np.array([[1.0, 1.0], [-1.5, 0.0]])
    assert np.allclose(rest(terrain, outside), 0.0, atol=1e-3)
    spec = mujoco.MjSpec()
    add_terrain(spec, terrain, np.zeros(2), 0.5, visual=False)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for x, y, depth in ((0.0, 0.0, 1.0), (9.0, 0.0, 1.0), (1.0, 1.0, 0.0)):
        geom = np.zeros(1, dtype=np.int32)
        way = mujoco.mj_ray(model, data, np.array([x, y, 1.0]), np.array([0.0, 0.0, -1.0]), None, 1, -1, geom)
        assert way == pytest.approx(1.0 + depth, abs=2e-3)


def test_friction_goes_by_part_and_by_one_factor() -> None:
    parts = [
        {"kind": "block", "x": 0.0, "length": 1.0, "width": 1.0, "height": 0.1, "friction": 0.2},
        {"kind": "block", "x": 2.0, "length": 1.0, "width": 1.0, "height": 0.1},
    ]
    terrain = Terrain.from_parts(parts, friction=0.4)
    spec = mujoco.MjSpec()
    add_terrain(spec, terrain, np.zeros(2), 0.8, visual=False)
    model = spec.compile()
    assert sorted(model.geom_friction[:, 0]) == pytest.approx([0.4, 0.8, 0.8])
    assert np.all(model.geom_priority == 1)  # its friction counts, not the larger one of both
