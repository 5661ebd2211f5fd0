"""Laws of the ground: planes tile it, a raster of it is the same ground, turning and keeping change none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rollgait as rg
from rollgait.errors import FileError, InputError
from rollgait.terrain import Block, HeightMap, Ramp, Terrain
from rollgait.terrain.facet import FAR
from rollgait.terrain.polygons import area, clip, contains, convex_hull, edges, inward, rectangle, subtract
from rollgait.terrain.regions import regions_of
from tests.terrain.worlds import Array, places, rounded, seeds, turned, worlds

ANGLES = rounded(-np.pi, np.pi)


def rectangles() -> st.SearchStrategy[Array]:
    return st.tuples(
        rounded(-1, 1), rounded(-1, 1), ANGLES, rounded(0.1, 1), rounded(0.1, 1), rounded(0.1, 1)
    ).map(lambda v: rectangle(np.array(v[:2]), *v[2:]))


@given(rectangles(), rectangles(), seeds)
def test_what_is_left_of_a_polygon_and_the_hole_make_it_up(a: Array, b: Array, seed: int) -> None:
    pieces = subtract(a, b)
    points = places(seed, 500, 2.5)
    strictly = [contains(piece, points, slack=-1e-6) for piece in pieces]
    assert np.sum(strictly, axis=0).max(initial=0) <= 1  # no overlap
    left = contains(a, points, slack=-1e-6) & ~contains(b, points)
    inside = np.any([contains(piece, points) for piece in pieces], axis=0) if pieces else np.zeros(500, bool)
    assert inside[left].all()
    assert not inside[contains(b, points, slack=-1e-6)].any()


@given(rectangles(), rectangles())
def test_areas_add_up(a: Array, b: Array) -> None:
    common: Array | None = a
    for point, normal in zip(edges(b)[0], inward(*edges(b)), strict=True):
        common = None if common is None else clip(common, point, normal)
    shared = 0.0 if common is None else area(common)
    assert sum(area(p) for p in subtract(a, b)) == pytest.approx(area(a) - shared, abs=1e-8)


@given(seeds, st.integers(1, 40))
def test_a_hull_holds_its_points(seed: int, count: int) -> None:
    points = places(seed, count).round(1)
    hull = convex_hull(points)
    if len(hull) > 2:
        assert contains(hull, points).all()
        assert area(hull) > 0.0
    assert {tuple(p) for p in hull} <= {tuple(p) for p in points}


@given(worlds, seeds)
@settings(max_examples=50)
def test_planes_tile_the_ground(world: Terrain, seed: int) -> None:
    assert sum(area(plane.polygon) for plane in world.planes) == pytest.approx(4.0 * FAR**2, rel=1e-9)
    points = places(seed)
    covers = np.array([contains(plane.polygon, points, slack=-1e-6) for plane in world.planes])
    assert covers.sum(axis=0).max() <= 1
    for plane, inside in zip(world.planes, covers, strict=True):
        x, y = points[inside].T
        np.testing.assert_allclose(world.height(x, y), plane.z(points[inside]), atol=1e-9)
        np.testing.assert_allclose(world.slope(x, y), np.broadcast_to(plane.slope, (len(x), 2)), atol=1e-12)


@given(worlds, ANGLES, seeds)
@settings(max_examples=30)
def test_turning_a_world_turns_all_of_it(world: Terrain, yaw: float, seed: int) -> None:
    points = places(seed)
    again = world.turned(yaw)
    there = turned(points, yaw)
    off_edges = _far_from_edges(world, points)
    np.testing.assert_allclose(
        again.height(*there.T)[off_edges], world.height(*points.T)[off_edges], atol=1e-9
    )
    np.testing.assert_allclose(
        again.slope(*there.T)[off_edges], turned(world.slope(*points.T), yaw)[off_edges], atol=1e-9
    )


def test_turning_a_map_turns_all_of_it() -> None:
    rng = np.random.default_rng(0)
    world = Terrain.from_map(0.02 * rng.standard_normal((30, 40)), 0.05, [-0.7, -1.0])
    points = rng.uniform(-0.6, 0.6, (100, 2))
    again = world.turned(0.7, about=(0.2, 0.3))
    pivot = np.array([0.2, 0.3])
    there = pivot + turned(points - pivot, 0.7)
    np.testing.assert_allclose(again.height(*there.T), world.height(*points.T), atol=1e-12)
    np.testing.assert_allclose(again.slope(*there.T), turned(world.slope(*points.T), 0.7), atol=1e-9)


@given(worlds, seeds)
@settings(max_examples=30)
def test_a_raster_is_the_ground_that_it_was_made_of(world: Terrain, seed: int) -> None:
    raster = world.raster(0.02, (-1.6, -1.6), (1.6, 1.6))
    points = places(seed)
    away = _far_from_edges(world, points, 0.03)
    np.testing.assert_allclose(raster.height(*points.T)[away], world.height(*points.T)[away], atol=1e-9)
    np.testing.assert_allclose(raster.slope(*points.T)[away], world.slope(*points.T)[away], atol=1e-9)
    nodes = raster.map.nodes()[::7, ::7].reshape(-1, 2) if raster.map is not None else points
    np.testing.assert_allclose(raster.height(*nodes.T), world.height(*nodes.T), atol=1e-12)


def _far_from_edges(world: Terrain, points: Array, distance: float = 1e-6) -> Any:
    """Which points have one plane all around them."""
    result = np.zeros(len(points), dtype=bool)
    for plane in world.planes:
        same = [p.polygon for p in world.planes if p.coplanar(plane) and p.source == plane.source]
        around = [points + distance * np.array([np.cos(a), np.sin(a)]) for a in np.linspace(0, 2 * np.pi, 17)]
        result |= np.all([np.any([contains(s, p) for s in same], axis=0) for p in [points, *around]], axis=0)
    return result


@given(worlds, seeds)
def test_normals_are_upright_units_across_the_slope(world: Terrain, seed: int) -> None:
    points = places(seed)
    n, slope = world.normal(*points.T), world.slope(*points.T)
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1.0)
    assert (n[:, 2] > 0.0).all()
    np.testing.assert_allclose(n[:, :2] + slope * n[:, 2:], 0.0, atol=1e-12)


def test_later_parts_override_earlier_ones() -> None:
    low = Block(x=0.0, length=1.0, width=1.0, height=0.2, friction=0.3)
    hole = Block(x=0.2, length=0.2, width=0.2, height=-0.1)
    world = rg.Terrain.from_parts([low, hole], height=1.0)
    assert world.height(-0.2, 0.0) == 1.2
    assert world.height(0.2, 0.0) == 0.9
    assert Terrain.from_parts([hole, low], height=1.0).height(0.2, 0.0) == 1.2
    np.testing.assert_array_equal(world.friction_at([-0.2, 0.2, 3.0], 0.0), [0.3, 0.5, 0.5])


def test_parts_lie_on_a_map() -> None:
    world = Terrain.from_map(
        np.full((21, 21), 0.1), 0.1, [-1.0, -1.0], parts=[Block(x=0.0, length=0.5, width=0.5, height=0.3)]
    )
    np.testing.assert_allclose(world.height([0.0, 0.5, 2.0], 0.0), [0.3, 0.1, np.nan])
    np.testing.assert_array_equal(world.known([0.0, 0.5, 2.0], 0.0), [True, True, False])
    assert [plane.source for plane in world.planes] == [0]


def test_a_ramp_by_its_rise_is_a_ramp_by_its_slope() -> None:
    rise = Terrain.from_parts([Ramp(x=0.0, length=2.0, rise=2.0 * np.tan(np.radians(15.0)))])
    slope = Terrain.from_parts([Ramp(x=0.0, length=2.0, slope_deg=15.0)])
    x = np.linspace(-1.0, 3.0, 17)
    np.testing.assert_allclose(rise.height(x, 0.0), slope.height(x, 0.0), atol=1e-12)
    assert slope.normal(1.0, 0.0) @ [0.0, 0.0, 1.0] == pytest.approx(np.cos(np.radians(15.0)))


# -- maps --


def test_value_i_j_stands_at_i_along_x_and_j_along_y() -> None:
    values = 0.01 * np.arange(12.0).reshape(3, 4)
    world = Terrain.from_map(values, 0.5, [1.0, 2.0], scale=2.0, offset=1.0)
    for i in range(3):
        for j in range(4):
            assert world.height(1.0 + 0.5 * i, 2.0 + 0.5 * j) == pytest.approx(1.0 + 2.0 * values[i, j])
    assert np.isnan(world.height([0.99, 1.5, 2.01, 1.5], [2.5, 1.99, 2.5, 3.51])).all()


def test_between_its_values_a_map_is_bilinear() -> None:
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    raster = HeightMap(0.1 * x - 0.2 * y + 0.03 * x * y, 1.0)
    points = np.random.default_rng(1).uniform([0, 0], [5, 4], (100, 2))
    a, b = points.T
    np.testing.assert_allclose(raster.height(points), 0.1 * a - 0.2 * b + 0.03 * a * b, atol=1e-12)
    np.testing.assert_allclose(
        raster.slope(points), np.stack([0.1 + 0.03 * b, -0.2 + 0.03 * a], 1), atol=1e-12
    )


def test_unknown_ground_is_unknown_up_to_its_known_neighbours() -> None:
    values = np.zeros((5, 5))
    values[2, 2] = np.nan
    world = Terrain.from_map(values, 0.1)
    assert world.known([0.1, 0.3, 0.2, 0.2], [0.2, 0.2, 0.1, 0.3]).all()
    assert not world.known([0.2, 0.15, 0.25], [0.2, 0.2, 0.25]).any()


@given(seeds)
@settings(max_examples=20)
def test_holes_in_a_plane_are_filled_with_the_plane(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(0.1 * np.arange(20), 0.1 * np.arange(20), indexing="ij")
    plane = rng.uniform(-0.5, 0.5) * x + rng.uniform(-0.5, 0.5) * y
    holes = plane.copy()
    for i, j in rng.integers(2, 17, (5, 2)):
        holes[i, j] = np.nan
    filled = HeightMap(holes, 0.1).with_holes_filled(0.5)
    np.testing.assert_allclose(filled.values, plane, atol=1e-4)


def test_only_small_holes_inside_are_filled() -> None:
    values = np.zeros((30, 30))
    values[5:7, 5:7] = values[12:20, 12:14] = values[0, 25] = np.nan
    filled = HeightMap(values, 0.05).with_holes_filled(0.1).values
    assert not np.isnan(filled[5:7, 5:7]).any()
    assert np.isnan(filled[12:20, 12:14]).all()
    assert np.isnan(filled[0, 25])
    np.testing.assert_array_equal(HeightMap(values, 0.05).with_holes_filled(0.0).values, values)


@given(rounded(-0.3, 0.3), rounded(-0.3, 0.3))
def test_what_a_robot_hides_is_filled_with_the_plane_through_its_feet(gx: float, gy: float) -> None:
    x, y = np.meshgrid(0.05 * np.arange(-40, 41), 0.05 * np.arange(-40, 41), indexing="ij")
    plane = 0.4 + gx * x + gy * y
    hidden = np.where((np.abs(x) < 0.6) & (np.abs(y) < 0.5), np.nan, plane)
    hidden[3, 3] = np.nan
    feet_xy = np.array([[0.4, 0.35], [0.4, -0.35], [-0.4, 0.35], [-0.4, -0.35]])
    feet = np.column_stack([feet_xy, 0.4 + feet_xy @ [gx, gy]])
    filled = Terrain.from_map(hidden, 0.05, [-2.0, -2.0]).filled_under(feet)
    assert filled.map is not None
    known = ~np.isnan(filled.map.values)
    np.testing.assert_allclose(filled.map.values[known], plane[known], atol=1e-9)
    assert not known[3, 3]  # elsewhere unknown stays unknown
    assert filled.known(0.0, 0.0)
    assert filled.known(0.55, 0.0)


# -- kept --


@given(worlds)
def test_saving_and_loading_is_the_identity(world: Terrain) -> None:
    again = Terrain.from_dict(world.to_dict(), world.arrays())
    assert again == world
    assert again.digest == world.digest


def test_a_map_is_kept_with_its_heights(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    values = 0.05 * rng.standard_normal((20, 30))
    values[4, 5] = np.nan
    block = Block(x=0.3, length=0.2, width=0.2, height=0.1, friction=0.9)
    world = Terrain.from_map(values, 0.05, [1.0, -2.0], yaw=0.3, friction=0.7, parts=[block])
    again = Terrain.load(world.save(tmp_path / "ground"))
    assert again == world
    assert again.map is not None
    np.testing.assert_array_equal(again.map.values, values)
    assert again.parts == world.parts
    points = rng.uniform(0.0, 1.0, (50, 2))
    np.testing.assert_array_equal(again.height(*points.T), world.height(*points.T))


def test_the_digest_tells_grounds_apart() -> None:
    values = np.zeros((5, 5))
    grounds = [
        Terrain(),
        Terrain(level=0.1),
        Terrain(friction=0.6),
        Terrain.from_parts([Block(x=0.0, length=1.0, width=1.0, height=0.1)]),
        Terrain.from_parts([Block(x=0.0, length=1.0, width=1.0, height=0.1001)]),
        Terrain.from_map(values, 0.1),
        Terrain.from_map(values, 0.2),
        Terrain.from_map(values + 1e-9, 0.1),
        Terrain.from_map(values, 0.1, [0.0, 0.1]),
    ]
    assert len({ground.digest for ground in grounds}) == len(grounds)
    assert Terrain.from_map(values, 0.1) == Terrain.from_map(-values, 0.1)  # −0 is 0


def test_a_file_that_is_no_ground(tmp_path: Path) -> None:
    (tmp_path / "x.npz").write_bytes(b"nothing")
    with pytest.raises(FileError, match="is not a ground that rollgait saved"):
        Terrain.load(tmp_path / "x.npz")
    path = Terrain.from_map(np.zeros((5, 5)), 0.1).save(tmp_path / "ground")
    data = dict(np.load(path))
    del data["heights"]
    np.savez(path, **data)
    with pytest.raises(FileError, match="is damaged: heights: is missing"):
        Terrain.load(path)


def test_a_ground_cannot_be_changed() -> None:
    values = np.zeros((5, 5))
    world = Terrain.from_map(values, 0.1)
    values[:] = 1.0
    assert world.height(0.2, 0.2) == 0.0
    with pytest.raises(ValueError, match="read-only"):
        world.map.values[0, 0] = 1.0  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"heights": np.zeros(5), "resolution": 0.1}, "grid of at least 2 × 2"),
        ({"heights": "hill", "resolution": 0.1}, "array of numbers"),
        ({"heights": np.full((5, 5), np.nan), "resolution": 0.1}, "know the ground somewhere"),
        ({"heights": np.full((5, 5), np.inf), "resolution": 0.1}, "finite heights"),
        ({"heights": np.zeros((5, 5)), "resolution": 0.0}, "at least 0.001"),
        ({"heights": np.zeros((5, 5)), "resolution": float("nan")}, "at least 0.001"),
        ({"heights": np.zeros((5, 5)), "resolution": 0.1, "origin": [1.0]}, "two finite numbers"),
        ({"heights": 250.0 * np.eye(50), "resolution": 0.02}, "scale must turn them into m"),
        ({"heights": np.zeros((5, 5)), "resolution": 0.1, "friction": 0.0}, "greater than 0"),
    ],
)
def test_arrays_that_are_no_ground(arguments: dict[str, Any], rule: str) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        Terrain.from_map(**arguments)
    assert "\n" not in str(caught.value)
    assert caught.value.field.startswith("ground")


def test_regions_need_a_radius_that_is_one() -> None:
    with pytest.raises(InputError, match=r"radius: -1\.0 must be a finite number of metres"):
        regions_of(Terrain(), -1.0)
