"""The ground as the controller looks it up: a raster that agrees with the ground, and swings over edges."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.mpc.clock import GaitClock
from rollgait.mpc.ground.landings import Landing, Landings
from rollgait.mpc.ground.raster import CELL, HEIGHT, ROLL_ROOM, SLOPE, STEP_ROOM, Raster
from rollgait.mpc.ground.terrain import TerrainGround, base_along
from rollgait.mpc.standing import within_cone
from rollgait.robot.library import find_robot
from rollgait.terrain import Terrain, base_reference, regions_of
from rollgait.terrain.terrain import normal_of
from tests.terrain import worlds

RADIUS = worlds.RADIUS
SMALL = 0.6
"""Half the side of a raster that is quickly made, m."""
KERB = Terrain.from_parts([{"kind": "step", "x": 0.5, "height": 0.1}])
RAMP = Terrain.from_parts([{"kind": "ramp", "x": -2.0, "length": 4.0, "slope_deg": 15.0, "yaw_deg": 30.0}])


@pytest.fixture(scope="module")
def kerb() -> TerrainGround:
    return TerrainGround(KERB, find_robot("centauro"))


@settings(max_examples=15, deadline=None)
@given(worlds.worlds, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_nodes_know_the_surface_and_where_feet_may_be(terrain: Terrain, x: float, y: float) -> None:
    regions = regions_of(terrain, RADIUS)
    raster = Raster.around(regions, np.array([x, y]), SMALL)
    nodes = CELL * np.round((np.array([x, y]) + worlds.places(0, 50, half=0.5 * SMALL)) / CELL)
    seen = raster.look(nodes)
    np.testing.assert_allclose(seen[:, HEIGHT], regions.surface.height(*nodes.T), atol=1e-9)
    if np.ptp(seen[:, STEP_ROOM]) > 0.0:  # both kinds of ground are there
        np.testing.assert_array_equal(seen[:, STEP_ROOM] > 0.0, regions.free(nodes))


@settings(max_examples=15, deadline=None)
@given(worlds.worlds, st.floats(-0.3, 0.3))
def test_two_rasters_agree_where_both_know_the_ground(terrain: Terrain, shift: float) -> None:
    regions = regions_of(terrain, RADIUS)
    one, other = (Raster.around(regions, np.array([x, 0.0]), SMALL) for x in (0.0, shift))
    points = worlds.places(1, 50, half=0.25)
    np.testing.assert_allclose(one.look(points)[:, HEIGHT], other.look(points)[:, HEIGHT], atol=1e-12)


def test_a_plane_is_exact_between_nodes() -> None:
    regions = regions_of(RAMP, RADIUS)
    raster, points = Raster.around(regions, np.zeros(2), SMALL), worlds.places(2, 100, half=0.5)
    seen = raster.look(points)
    np.testing.assert_allclose(seen[:, HEIGHT], regions.surface.height(*points.T), atol=1e-9)
    slope = np.tan(np.radians(15.0)) * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    np.testing.assert_allclose(seen[:, SLOPE], np.broadcast_to(slope, (100, 2)), atol=1e-9)


def test_the_nearest_foothold_is_allowed_and_no_other_is_much_nearer() -> None:
    regions = regions_of(KERB, RADIUS)
    raster, nodes = Raster.around(regions, np.array([0.5, 0.0]), SMALL), worlds.places(3, 400, half=0.5)
    nodes = nodes + np.array([0.5, 0.0])
    allowed = nodes[regions.free(nodes)]
    for point in nodes[~regions.free(nodes)]:
        found = raster.nearest_foothold(point)
        assert regions.free(found[None])[0]
        nearest = np.linalg.norm(allowed - point, axis=1).min()
        assert np.linalg.norm(found - point) < nearest + 2.0 * CELL


@pytest.mark.parametrize(("height", "rolls"), [(0.02, True), (0.03, True), (0.06, False), (0.1, False)])
def test_wheels_roll_over_low_sills_and_keep_off_high_kerbs(height: float, rolls: bool) -> None:
    terrain = Terrain.from_parts([{"kind": "step", "x": 0.0, "height": height}])
    raster = Raster.around(regions_of(terrain, RADIUS), np.zeros(2), SMALL)
    way = np.column_stack([np.linspace(-0.3, 0.3, 61), np.zeros(61)])
    room = raster.look(way)
    assert (room[:, ROLL_ROOM].min() > 0.0) == rolls
    assert room[:, STEP_ROOM].min() < 0.0  # a foot is set down on neither edge


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.floats(-3.0, 3.0))
def test_the_base_of_many_moments_is_that_of_each(seed: int, yaw: float) -> None:
    random = np.random.default_rng(seed)
    corners = np.array([[0.3, 0.3], [0.3, -0.3], [-0.4, 0.3], [-0.4, -0.3]])
    feet = np.concatenate([corners + random.uniform(-0.1, 0.1, (5, 4, 2)), random.normal(size=(5, 4, 1))], -1)
    found = base_along(feet, np.full(5, yaw))
    for moment, place in zip(found.T, feet, strict=True):
        wanted = base_reference(place, yaw)
        np.testing.assert_allclose(moment, [wanted.ground, wanted.pitch, wanted.roll], atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31), st.floats(0.1, 1.0))
def test_forces_are_brought_into_the_cone_about_the_normal(seed: int, friction: float) -> None:
    random = np.random.default_rng(seed)
    force, normals = random.normal(size=(4, 3)), normal_of(random.uniform(-0.5, 0.5, (4, 2)))
    found = within_cone(force, friction, normals)
    pressing = (found * normals).sum(axis=1)
    along = np.linalg.norm(found - pressing[:, None] * normals, axis=1)
    assert (pressing >= -1e-12).all()
    assert (along <= friction * pressing + 1e-9).all()
    np.testing.assert_allclose(within_cone(found, friction, normals), found, atol=1e-9)


# -- swings ----------------------------------------------------------------------------------------------


def swings_over(ground: TerrainGround, landing_x: float, chosen_before: Landings | None = None) -> Landing:
    """The landing of FL's next swing at a place along x."""
    landings = chosen_before or Landings(ground.around)
    clock = GaitClock("crawl", 0.0)
    xy = np.zeros((51, 4, 2))
    xy[..., 0] = landing_x
    found = landings.update(clock, 0.0, 0.1, xy, xy)
    return next(landing for swing, landing in found if swing.leg == 0)


def test_a_foothold_on_an_edge_is_moved_to_where_a_foot_may_stand(kerb: TerrainGround) -> None:
    regions = regions_of(KERB, RADIUS)
    for x in np.arange(0.3, 0.7, 0.03):
        landing = swings_over(kerb, float(x))
        assert regions.free(landing.place[None])[0]
        assert (landing.chosen is None) == bool(regions.free(np.array([[x, 0.0]]))[0])


def test_footholds_do_not_flip_flop(kerb: TerrainGround) -> None:
    """What is wanted moves to and fro about the middle between both sides of the edge: one of them stays."""
    landings, sides = Landings(kerb.around), set()
    for k in range(40):
        landing = swings_over(kerb, 0.44 + 0.015 * (-1.0) ** k, landings)
        assert landing.chosen is not None
        sides.add(bool(landing.chosen[0] > 0.5))
    assert len(sides) == 1


@pytest.mark.parametrize(("begin", "end"), [(0.0, 0.1), (0.1, 0.0), (0.05, 0.05)])
def test_a_swing_leaves_and_lands_on_the_ground_and_clears_what_is_between(begin: float, end: float) -> None:
    swing = GaitClock("crawl").swings(0.0, 5.0)[0]
    landing = Landing(
        swing.lift_off, np.array([0.0, 0.0, begin]), np.zeros(2), np.zeros(2), top=0.12, end=end
    )
    times = np.linspace(swing.lift_off, swing.touch_down, 201)
    z, rate = landing.profile(swing, times)
    assert z[[0, -1]] == pytest.approx([begin, end])
    assert rate[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert z.max() == pytest.approx(0.12 + swing.clearance)
    np.testing.assert_allclose(np.gradient(z, times)[1:-1], rate[1:-1], atol=0.02)
