"""Laws of the dilation by the wheel."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rollgait.terrain import Block, Ramp, Step, Terrain, WheelSurface
from rollgait.terrain.polygons import contains
from tests.terrain.worlds import RADIUS, Array, ball, places, rounded, seeds, turned, worlds

radii = rounded(0.02, 0.3)
HIGHEST = 2.0
"""m: over all that the parts of a random world rise to."""


@given(radii, rounded(-1.0, 1.0), seeds)
def test_flat_stays_flat(radius: float, height: float, seed: int) -> None:
    touch = WheelSurface(Terrain(level=height), radius).touch(places(seed))
    np.testing.assert_allclose(touch.height, height, atol=1e-12)
    np.testing.assert_allclose(touch.normal, np.broadcast_to([0.0, 0.0, 1.0], (200, 3)), atol=1e-12)
    assert touch.face.all()


@given(worlds, radii, seeds)
@settings(max_examples=60)
def test_the_wheel_touches_the_ground_and_nothing_is_in_it(world: Terrain, radius: float, seed: int) -> None:
    points = places(seed, 40)
    touch = WheelSurface(world, radius).touch(points)
    centre = np.column_stack([points, touch.height + radius])
    np.testing.assert_allclose(np.linalg.norm(centre - touch.contact, axis=1), radius, atol=1e-9)
    np.testing.assert_allclose(touch.normal, (centre - touch.contact) / radius, atol=1e-9)
    columns = ball(radius)
    bottom = np.sqrt(radius**2 - (columns**2).sum(axis=1))
    on_ground = np.zeros(len(points), dtype=bool)
    for plane in world.planes:
        xy, z = touch.contact[:, :2], touch.contact[:, 2]
        on_ground |= contains(plane.polygon, xy, slack=1e-7) & (np.abs(plane.z(xy) - z) < 1e-7)
    assert on_ground.all()
    for k, point in enumerate(points):
        ground = world.height(*(point + columns).T)
        assert (ground <= centre[k, 2] - bottom + 1e-9).all()


@given(worlds, seeds)
def test_without_a_radius_it_is_the_ground(world: Terrain, seed: int) -> None:
    points = places(seed)
    ground = world.height(*points.T)
    np.testing.assert_allclose(WheelSurface(world, 0.0).height(*points.T), ground, atol=1e-9)
    small = WheelSurface(world, 1e-6).height(*points.T)
    away = np.abs(small - ground) < 1e-5  # all but the points within 1e-6 m of an edge
    assert away.mean() > 0.95


@given(worlds, radii, radii, seeds)
def test_a_larger_wheel_is_never_lower(world: Terrain, a: float, b: float, seed: int) -> None:
    points = places(seed)
    small, large = (WheelSurface(world, r).height(*points.T) for r in sorted((a, b)))
    assert (large >= small - 1e-9).all()
    assert (small >= world.height(*points.T) - 1e-9).all()


@given(worlds, radii, seeds)
def test_more_ground_is_never_lower(world: Terrain, radius: float, seed: int) -> None:
    points = places(seed)
    tower = Block(x=0.1, y=-0.2, yaw_deg=20.0, length=0.4, width=0.3, height=HIGHEST)
    more = Terrain.from_parts([*world.parts, tower])
    before, after = (WheelSurface(w, radius).height(*points.T) for w in (world, more))
    assert (after >= before - 1e-9).all()


@given(worlds, rounded(-np.pi, np.pi), radii, seeds)
def test_turning_a_world_turns_its_surface(world: Terrain, yaw: float, radius: float, seed: int) -> None:
    points = places(seed)
    here = WheelSurface(world, radius).touch(points)
    there = WheelSurface(world.turned(yaw), radius).touch(turned(points, yaw))
    np.testing.assert_allclose(there.height, here.height, atol=1e-7)


@given(worlds, radii, rounded(-np.pi, np.pi), seeds)
@settings(max_examples=30)
def test_a_disc_is_never_higher_than_the_ball(
    world: Terrain, radius: float, heading: float, seed: int
) -> None:
    points = places(seed, 40)
    s = np.linspace(-radius, radius, 201)
    along = s[:, None] * np.array([np.cos(heading), np.sin(heading)])
    rim = np.sqrt(np.maximum(radius**2 - s**2, 0.0)) - radius
    disc = [np.max(world.height(*(p + along).T) + rim) for p in points]
    assert (WheelSurface(world, radius).height(*points.T) >= np.array(disc) - 1e-9).all()


@given(rounded(-25.0, 25.0), radii)
def test_on_a_slope_the_contact_is_beside_the_lowest_point(slope_deg: float, radius: float) -> None:
    assume(abs(slope_deg) > 0.1)
    alpha = np.radians(slope_deg)
    ramp = Terrain.from_parts([Ramp(x=-5.0, length=10.0, slope_deg=slope_deg)])
    touch = WheelSurface(ramp, radius).touch(np.array([[0.3, 0.1]]))
    np.testing.assert_allclose(touch.normal[0], [-np.sin(alpha), 0.0, np.cos(alpha)], atol=1e-12)
    np.testing.assert_allclose(touch.contact[0, :2], [0.3 + radius * np.sin(alpha), 0.1], atol=1e-12)
    lifted = touch.height[0] - ramp.height(0.3, 0.1)
    assert lifted == pytest.approx(radius * (1.0 / np.cos(alpha) - 1.0))


@given(rounded(0.01, 0.12), rounded(0.0, 0.2))
def test_before_a_kerb_the_wheel_climbs_along_a_circle(height: float, distance: float) -> None:
    """At a distance s it is where the rim meets the corner: h + √(R² − s²) − R, not below 0."""
    surface = WheelSurface(Terrain.from_parts([Step(x=0.0, height=height)]), RADIUS)
    corner = height + np.sqrt(RADIUS**2 - distance**2) - RADIUS if distance < RADIUS else -np.inf
    assert surface.height(-distance, 0.0) == pytest.approx(max(corner, 0.0), abs=1e-12)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=8)
def test_a_raster_has_the_surface_of_its_parts(seed: int) -> None:
    """Within what a raster of 1 cm knows of edges: they lie between its nodes."""
    rng = np.random.default_rng(seed)
    world = Terrain.from_parts(
        [
            Ramp(x=-0.5, length=0.6, width=1.0, slope_deg=rng.uniform(5, 20)),
            Block(x=0.5, yaw_deg=rng.uniform(0, 90), length=0.4, width=0.3, height=rng.uniform(0.02, 0.2)),
        ]
    )
    raster = world.raster(0.01, (-1.5, -1.5), (1.5, 1.5))
    points = places(seed, 300, 1.2)
    exact, rough = (WheelSurface(w, RADIUS).height(*points.T) for w in (world, raster))
    lower, upper = _envelope(world, points)
    assert (rough >= lower - 1e-3).all()
    assert (rough <= upper + 1e-3).all()
    assert np.median(np.abs(rough - exact)) < 2e-4


def _envelope(world: Terrain, points: Array) -> tuple[Array, Array]:
    """Lowest and highest surface within some cells about each point."""
    surface = WheelSurface(world, RADIUS)
    around = [points + 0.025 * np.array([np.cos(a), np.sin(a)]) for a in np.linspace(0, 2 * np.pi, 13)]
    heights = np.array([surface.height(*p.T) for p in [points, *around]])
    return heights.min(axis=0), heights.max(axis=0)


def test_parts_on_a_map_are_one_surface() -> None:
    block = Block(x=0.0, length=0.5, width=0.5, height=0.1)
    on_map = Terrain.from_map(np.zeros((101, 101)), 0.02, [-1.0, -1.0], parts=[block])
    points = places(3, 300, 0.7)
    np.testing.assert_allclose(
        WheelSurface(on_map, RADIUS).height(*points.T),
        WheelSurface(Terrain.from_parts([block]), RADIUS).height(*points.T),
        atol=5e-4,
    )


def test_a_window_changes_nothing_inside() -> None:
    rng = np.random.default_rng(4)
    world = Terrain.from_map(0.02 * rng.standard_normal((100, 80)), 0.04, [-2.0, -1.5], yaw=0.4)
    points = rng.uniform([-0.3, -0.2], [0.4, 0.3], (200, 2))
    whole = WheelSurface(world, RADIUS).height(*points.T)
    part = WheelSurface(world, RADIUS, ((-0.3, -0.2), (0.4, 0.3)))
    np.testing.assert_allclose(part.height(*points.T), whole, atol=1e-12)
    assert part.grid is not None
    assert part.grid.values.size < 0.2 * 400 * 320


def test_a_cliff_in_a_small_window_is_ground() -> None:
    """Two metres down within a window of half a metre: a part of a map may be steeper than a map."""
    values = np.zeros((100, 100))
    values[50:] = -3.0
    world = Terrain.from_map(values, 0.04, [-2.0, -2.0])
    window = ((-0.2, -0.2), (0.2, 0.2))
    points = places(5, 50, 0.2)
    part = WheelSurface(world, RADIUS, window).height(*points.T)
    np.testing.assert_allclose(part, WheelSurface(world, RADIUS).height(*points.T), atol=1e-12)
    raster = Terrain.from_parts([Step(x=0.0, height=-3.0)]).raster(0.04, *window)
    assert raster.map is not None
    assert np.ptp(raster.map.values) == 3.0


def test_unknown_ground_lifts_no_wheel() -> None:
    values = np.zeros((60, 60))
    values[20:40, 20:40] = np.nan
    surface = WheelSurface(Terrain.from_map(values, 0.02), 0.06)
    np.testing.assert_allclose(surface.height([0.1, 0.3], 0.6), 0.0, atol=1e-12)
    assert np.isnan(surface.height(0.59, 0.59))
