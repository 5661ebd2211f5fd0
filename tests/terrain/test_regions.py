"""Regions keep away from edges, boxes are convex and hold their path, local models take one side."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.robot.library import find_robot
from rollgait.terrain import Block, Ramp, Step, Terrain, regions_of, require_standing
from rollgait.terrain.convex_region import EVERY, Obstacles, grow
from rollgait.terrain.local_model import SIGMA, LocalModel, fit, pattern
from rollgait.terrain.local_models import models_along
from rollgait.terrain.polygons import convex_hull, distance_to_hull, rectangle
from rollgait.terrain.regions import FRICTION_SHARE, MARGIN, PlanarRegions, RasterRegions, Regions, arcs
from tests.terrain.worlds import RADIUS, Array, places, rounded, seeds, turned, worlds

HALF = 1.2
KERB = Terrain.from_parts([Step(x=0.0, height=0.1)])
RING = np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 25)), np.sin(np.linspace(0, 2 * np.pi, 25))])


def keeps_off_edges(world: Terrain, regions: Regions, points: Array, slack: float = 0.0) -> None:
    """Around each contact, within the margin, the ground goes on as the plane that the wheel stands on."""
    touch = regions.surface.touch(points)
    for distance in (0.5 * regions.margin, 0.99 * regions.margin - slack):
        for offset in distance * RING:
            ground = world.height(*(touch.contact[:, :2] + offset).T)
            slope = -touch.normal[:, :2] / touch.normal[:, 2:]
            step = np.abs(ground - touch.contact[:, 2] - slope @ offset)
            steepest = FRICTION_SHARE * world.friction  # over a crease it may bend, but not jump
            assert (step <= 2.0 * steepest * distance + 1.1e-3).all()


@given(worlds, seeds)
@settings(max_examples=40)
def test_free_ground_keeps_away_from_edges(world: Terrain, seed: int) -> None:
    regions = regions_of(world, RADIUS)
    points = places(seed, 100)
    free = points[regions.free(points)]
    if len(free):
        keeps_off_edges(world, regions, free)
        touch = regions.surface.touch(free)
        assert touch.face.mean() > 0.5  # else on a crease, never on the edge of a step
        slope = np.linalg.norm(touch.normal[:, :2], axis=1) / touch.normal[:, 2]
        assert (slope <= FRICTION_SHARE * world.friction + 1e-9).all()
    assert regions.rollable(free).all()


@given(worlds, seeds)
@settings(max_examples=40)
def test_a_box_holds_its_path_and_no_edge(world: Terrain, seed: int) -> None:
    regions = regions_of(world, RADIUS)
    rng = np.random.default_rng(seed)
    for start in places(seed, 6):
        path = start + np.cumsum(rng.uniform(-0.05, 0.1, (4, 2)), axis=0)
        box = regions.box(path, heading=rng.uniform(-3, 3))
        if box is None:
            continue
        assert box.contains(path).all()
        assert len(box.b) <= 8
        np.testing.assert_allclose(np.linalg.norm(box.A, axis=1), 1.0)
        inside = places(seed + 1, 80, 1.0) + path.mean(axis=0)
        inside = inside[box.contains(inside)]
        labels = regions.label(np.vstack([path[:1], inside]))
        assert (labels == labels[0]).all()
        keeps_off_edges(world, regions, inside)


@given(worlds, rounded(-np.pi, np.pi), seeds)
@settings(max_examples=25)
def test_turning_a_world_turns_its_regions(world: Terrain, yaw: float, seed: int) -> None:
    points = places(seed, 60)
    here, there = regions_of(world, RADIUS), regions_of(world.turned(yaw), RADIUS)
    away = _not_at_a_limit(here, points)
    np.testing.assert_array_equal(here.free(points)[away], there.free(turned(points, yaw))[away])
    for point in points[away][:5]:
        path = point + np.array([[0.0, 0.0], [0.04, 0.02]])
        a = here.box(path, 0.2)
        b = there.box(turned(path, yaw), 0.2 + yaw)
        assert (a is None) == (b is None)
        if a is not None and b is not None and len(a.b) == len(b.b):
            probe = places(seed, 200, 1.0) + point
            np.testing.assert_allclose(a.margin(probe), b.margin(turned(probe, yaw)), atol=1e-5)


def _not_at_a_limit(regions: Regions, points: Array) -> Array:
    """Points whose freedom a rounding does not decide."""
    around = [regions.free(points + 1e-6 * offset) for offset in RING[::3]]
    return np.all(around, axis=0) | ~np.any(around, axis=0)


@pytest.mark.parametrize("height", [0.02, 0.1, 0.3])
def test_before_a_kerb_the_wheel_keeps_the_riser_and_above_it_the_margin(height: float) -> None:
    regions = regions_of(Terrain.from_parts([Step(x=0.0, height=height)]), RADIUS)
    touching = np.sqrt(2 * RADIUS * height - height**2) if height < RADIUS else RADIUS
    for place, free in [
        (-touching - MARGIN - 1e-4, True),
        (-touching - MARGIN + 1e-4, False),
        (MARGIN - 1e-4, False),
        (MARGIN + 1e-4, True),
    ]:
        assert regions.free(np.array([[place, 0.3]]))[0] == free
    below, above = regions.label(np.array([[-1.0, 0.0], [1.0, 0.0]]))
    assert below != above


def test_a_ramp_joins_what_it_connects_and_a_steep_one_does_not() -> None:
    for slope_deg, joined in [(15.0, True), (22.0, True), (24.0, False)]:  # atan(0.85 · 0.5) = 23.0°
        rise = float(np.tan(np.radians(slope_deg)))
        world = Terrain.from_parts([Ramp(x=0.0, length=1.0, slope_deg=slope_deg), Step(x=1.0, height=rise)])
        x = np.linspace(-0.5, 1.5, 41)
        labels = regions_of(world, RADIUS).label(np.column_stack([x, np.zeros(41)]))
        assert bool((labels == labels[0]).all()) == joined
        assert labels[0] >= 0
        assert labels[-1] >= 0
        assert (labels[20] >= 0) == joined


def test_a_narrow_ramp_is_as_wide_as_it_is_less_the_margin() -> None:
    world = Terrain.from_parts([Ramp(x=0.0, length=3.0, width=0.4, slope_deg=10.0)])
    regions = regions_of(world, RADIUS)
    assert regions.free(np.array([[1.5, 0.2 - MARGIN - 1e-3]]))[0]
    assert not regions.free(np.array([[1.5, 0.2 - MARGIN + 1e-3]]))[0]
    assert not regions.free(np.array([[1.5, 0.2 + RADIUS]]))[0]  # beside it the wheel would touch its side


def test_around_a_pothole_only_the_margin_is_kept() -> None:
    """Its walls keep wheels on its floor away, not those beside its corners."""
    hole = Terrain.from_parts([Block(x=0.0, length=0.6, width=0.8, height=-0.2)])
    regions = regions_of(hole, RADIUS)
    points = places(1, 2000, 0.7)
    rim = distance_to_hull(rectangle(np.array([-0.3, 0.0]), 0.0, 0.6, 0.4, 0.4), points)
    free, plane = regions.free(points), rim > 0.0
    np.testing.assert_array_equal(free[plane], rim[plane] >= MARGIN)
    floor = np.abs(points) <= np.array([0.3, 0.4]) - RADIUS - MARGIN
    np.testing.assert_array_equal(free[~plane], floor.all(axis=1)[~plane])


def test_a_gap_without_end_divides_the_ground() -> None:
    for yaw_deg in (0.0, 30.0, 45.0, 150.0):
        gap = Terrain.from_parts([{"kind": "gap", "x": 0.3, "y": -0.2, "yaw_deg": yaw_deg, "length": 0.3}])
        along = np.array([np.cos(np.radians(yaw_deg)), np.sin(np.radians(yaw_deg))])
        sides = np.array([0.3, -0.2]) + np.outer([-1.0, 1.0], along)
        before, behind = regions_of(gap, RADIUS).label(sides)
        assert 0 <= before != behind >= 0


@given(seeds)
@settings(max_examples=8)
def test_regions_of_a_raster_are_those_of_its_parts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = Terrain.from_parts(
        [
            Step(x=0.6, height=rng.uniform(0.05, 0.2), yaw_deg=rng.uniform(-30, 30)),
            Block(x=-0.4, y=0.3, yaw_deg=rng.uniform(0, 90), length=0.5, width=0.3, height=0.15),
        ]
    )
    exact = regions_of(world, RADIUS)
    rough = regions_of(world.raster(0.01, (-1.5, -1.5), (1.5, 1.5)), RADIUS)
    assert isinstance(exact, PlanarRegions)
    assert isinstance(rough, RasterRegions)
    points = places(seed, 2000, HALF)
    wrong = points[exact.free(points) != rough.free(points)]
    assert len(wrong) < 0.05 * len(points)
    for point in wrong:  # and those lie at the rim, within two cells and a half
        around = exact.free(point + 0.025 * RING)
        assert not around.all() if exact.free(point[None])[0] else around.any()
    keeps_off_edges(world, rough, points[rough.free(points)], slack=0.015)


@given(rounded(0.02, 0.3), rounded(0.0, 1.0), st.sampled_from([1.0, -1.0]), rounded(-0.3, 0.3))
@settings(max_examples=15)
def test_beside_a_straight_edge_a_box_of_a_raster_is_that_of_its_parts(
    height: float, share: float, up: float, y: float
) -> None:
    """Wherever the edge lies between the nodes: half a cell beside, as straight, and no cut slants."""
    cell = 0.01
    world = Terrain.from_parts([Step(x=0.0, height=up * height)])
    corner = np.array([-1.3 - share * cell, -1.2])
    exact, rough = regions_of(world, RADIUS), regions_of(world.raster(cell, corner, -corner), RADIUS)
    for x in (-0.3, 0.3):
        boxes = [regions.box(np.array([[x, y], [x + 0.02, y]]), reach=0.5) for regions in (exact, rough)]
        assert boxes[0] is not None
        assert boxes[1] is not None
        sides = [box.vertices[:, 0] for box in boxes]
        np.testing.assert_allclose(
            [sides[1].min(), sides[1].max()], [sides[0].min(), sides[0].max()], atol=2 * cell
        )
        np.testing.assert_allclose(np.ptp(boxes[1].vertices[:, 1]), np.ptp(boxes[0].vertices[:, 1]))
        for regions in (exact, rough):
            assert regions.free(boxes[1].vertices.mean(axis=0)[None]).all()


@given(worlds, seeds)
@settings(max_examples=15)
def test_a_foothold_of_a_foot_that_does_not_roll_lies_in_one_plane(world: Terrain, seed: int) -> None:
    regions = regions_of(world, 0.0, rolls=False)
    points = places(seed, 60)
    for point in points[regions.free(points)][:8]:
        box = regions.box(point[None], reach=0.4)
        assert box is not None
        inside = point + places(seed + 1, 60, 0.4)
        inside = inside[box.contains(inside)]
        slope = world.slope(*point)
        plane = world.height(*point) + (inside - point) @ slope
        np.testing.assert_allclose(world.height(*inside.T), plane, atol=1e-6)


def test_a_kink_divides_only_what_does_not_roll() -> None:
    ramp = Terrain.from_parts([Ramp(x=0.0, length=2.0, slope_deg=15.0)])
    sides = np.array([[-0.01, 0.2], [0.01, 0.2]])
    before, behind = regions_of(ramp, 0.02, rolls=False).label(sides)
    assert 0 <= before != behind >= 0
    rolling = regions_of(ramp, 0.02).label(sides)
    assert rolling[0] == rolling[1] >= 0


def test_unknown_ground_belongs_to_no_region() -> None:
    values = np.zeros((101, 101))
    values[40:60, 40:60] = np.nan
    regions = regions_of(Terrain.from_map(values, 0.02, [-1.0, -1.0]), RADIUS)
    x = np.array([-0.5, -0.27, -0.24, 0.0, 0.5, 0.98])
    labels = regions.label(np.column_stack([x, np.zeros(6)]))
    np.testing.assert_array_equal(labels >= 0, [True, True, False, False, True, False])
    assert not regions.free(np.array([[np.nan, 0.0], [5.0, 0.0]])).any()


def test_regions_of_a_path_are_one_or_one_each() -> None:
    regions = regions_of(Terrain.from_parts([Block(x=0.0, length=0.2, width=0.2, height=0.1)]), RADIUS)
    straight = np.array([[-1.0, 0.5], [0.0, 0.5], [1.0, 0.5]])
    boxes = regions.boxes(straight, np.zeros(2))
    assert boxes[0] is boxes[1] is not None
    bent = np.array([[-0.6, 0.0], [-0.4, 0.4], [0.0, 0.5], [0.4, 0.4], [0.6, 0.0]])
    assert regions.box(bent) is None  # its hull goes over the block
    boxes = regions.boxes(bent, np.zeros(4))
    assert None not in boxes
    for k, box in enumerate(boxes):
        assert box is not None
        assert box.contains(bent[k : k + 2]).all()
    over = regions.boxes(np.array([[-0.6, 0.0], [-0.3, 0.0], [0.0, 0.0], [0.6, 0.0]]), np.zeros(3))
    assert [box is None for box in over] == [False, True, True]


def test_a_box_in_a_narrow_place_gives_way_with_its_window() -> None:
    """More obstacles than there are cuts: all are left out all the same."""
    angles = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    ring = 0.3 * np.column_stack([np.cos(angles), np.sin(angles)])
    posts = Obstacles(ring, ring, np.zeros_like(ring), np.full(12, 0.05), np.full(12, EVERY))
    box = grow(posts, np.array([[-0.02, 0.0], [0.02, 0.0]]))
    assert box is not None
    assert len(box.b) <= 8
    assert (box.margin(ring) <= -0.05 + 1e-9).all()


def test_a_box_can_be_padded_to_a_fixed_number_of_rows() -> None:
    box = regions_of(KERB, RADIUS).box(np.array([[-0.5, 0.0], [-0.4, 0.0]]))
    assert box is not None
    A, b = box.padded(12)
    assert A.shape == (12, 2)
    points = places(0)
    np.testing.assert_array_equal((points @ A.T <= b).all(axis=1), box.margin(points) >= 0.0)
    hull = convex_hull(box.vertices)
    np.testing.assert_array_equal(distance_to_hull(hull, points) == 0.0, box.contains(points))


def test_arcs_are_runs_in_a_region() -> None:
    assert arcs([0, 0, -1, 1, 1, -1, -1, 1]) == [(0, 0, 1), (1, 3, 4), (1, 7, 7)]
    assert arcs([2, 3]) == [(2, 0, 0), (3, 1, 1)]
    assert arcs([-1]) == []


# -- local models --


@given(rounded(-0.4, 0.4), rounded(-0.4, 0.4), rounded(-1, 1), seeds)
def test_a_plane_is_fitted_exactly(gx: float, gy: float, height: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    ref = rng.uniform(-1, 1, 2)
    points = ref + pattern(0.3)[rng.permutation(113)[: rng.integers(10, 113)]]
    model = fit(ref, points, height + points @ [gx, gy])
    probe = places(seed, 20)
    np.testing.assert_allclose(model.z(probe), height + probe @ [gx, gy], atol=1e-6)
    np.testing.assert_allclose(model.slope, [gx, gy], atol=1e-9)
    assert not model.curved


def test_a_quadratic_is_fitted_exactly() -> None:
    rng = np.random.default_rng(5)
    ref, g = np.array([0.3, -0.2]), np.array([0.1, -0.3])
    H = np.array([[1.0, 0.4], [0.4, -2.0]])
    truth = LocalModel(ref, 0.5, g, H)
    points = ref + pattern()
    model = fit(ref, points, truth.z(points))
    np.testing.assert_allclose(model.numbers(), truth.numbers(), atol=1e-9)
    probe = rng.uniform(-1, 1, (20, 2))
    step = 1e-6
    for axis in np.eye(2):
        numeric = (truth.z(probe + step * axis) - truth.z(probe - step * axis)) / (2 * step)
        np.testing.assert_allclose(truth.slope_at(probe) @ axis, numeric, atol=1e-8)
    n = truth.normal(probe)
    np.testing.assert_allclose(n[:, :2] / n[:, 2:], -truth.slope_at(probe))


def test_few_samples_give_the_flattest_model() -> None:
    ref = np.zeros(2)
    one = fit(ref, np.array([[0.01, 0.0]]), np.array([5.0]))
    assert one.height == pytest.approx(5.0)
    np.testing.assert_allclose(one.slope, 0.0, atol=1e-12)
    two = fit(ref, np.array([[-0.01, 0.0], [0.01, 0.0]]), np.array([5.0, 5.002]))
    np.testing.assert_allclose(two.slope, [0.1, 0.0], atol=1e-9)


@given(worlds, seeds, rounded(-3.0, 3.0))
@settings(max_examples=30)
def test_a_local_model_is_the_surface_where_the_ground_is_planar(
    world: Terrain, seed: int, heading: float
) -> None:
    regions = regions_of(world, RADIUS)
    points = places(seed, 100)
    points = points[regions.free(points)][:10]
    for point in points:
        model = regions.local_model(point, heading)
        around = point + 1.5 * SIGMA * RING
        touch = regions.surface.touch(around[regions.rollable(around)])
        planes = [world.planes[number] for number in np.unique(touch.plane)]
        if touch.face.all() and all(p.coplanar(planes[0]) for p in planes) and not model.curved:
            near = around[regions.rollable(around)]
            np.testing.assert_allclose(model.z(near), touch.height, atol=1e-7)
        assert abs(model.height - regions.surface.height(*point)) < 5e-3


@pytest.mark.parametrize("raster", [False, True], ids=["parts", "raster"])
def test_a_local_model_never_mixes_two_sides(raster: bool) -> None:
    """As near to the edge as a foot may come, the model is the plane that the foot stands on."""
    world = KERB.raster(0.01, (-1.0, -1.0), (1.0, 1.0)) if raster else KERB
    regions = regions_of(world, RADIUS)
    touching = np.sqrt(2 * RADIUS * 0.1 - 0.1**2)
    for x, height in [(-touching - MARGIN - 0.012, 0.0), (MARGIN + 0.012, 0.1)]:
        place = np.array([x, 0.1])
        assert regions.free(place[None])[0]
        model = regions.local_model(place)
        assert model.height == pytest.approx(height, abs=1e-6)
        np.testing.assert_allclose(model.slope, 0.0, atol=1e-5)
        assert not model.curved or raster


def test_a_smooth_raster_is_followed() -> None:
    """Bumps of 3 cm over half a metre: the model is the surface within half a millimetre over a σ."""
    x, y = np.meshgrid(0.01 * np.arange(201), 0.01 * np.arange(101), indexing="ij")
    world = Terrain.from_map(0.015 * np.sin(2 * np.pi * x / 0.5) * np.cos(2 * np.pi * y / 0.7), 0.01)
    regions = regions_of(world, RADIUS)
    for place in np.array([1.0, 0.5]) + places(6, 20, 0.3):
        assert regions.free(place[None])[0]
        near = place + SIGMA * RING
        error = regions.local_model(place).z(near) - regions.surface.height(*near.T)
        assert np.abs(error).max() < 5e-4


@pytest.mark.parametrize(("slope_deg", "beside"), [(10, 7e-4), (15, 1e-3), (20, 1.2e-3)])
@pytest.mark.parametrize("end", ["foot", "top"])
def test_a_kink_is_rounded_by_little(slope_deg: int, beside: float, end: str) -> None:
    """All about both ends of a ramp: at the place itself, and as far as a wheel rolls in an interval."""
    rise = float(2.0 * np.tan(np.radians(slope_deg)))
    foot = Terrain.from_parts([Ramp(x=0.0, length=2.0, slope_deg=slope_deg)])
    top = Terrain.from_parts([Ramp(x=-2.0, length=2.0, rise=rise), Step(x=0.0, height=rise)])
    regions = regions_of(foot if end == "foot" else top, RADIUS)
    refs = np.column_stack([np.linspace(-0.1, 0.1, 41), np.full(41, 0.013)])
    for model in models_along(regions, refs, refs, np.linspace(-1.0, 1.0, 41)):
        line = model.ref + np.linspace(-0.02, 0.02, 9)[:, None] * [1.0, 0.0]
        error = np.abs(model.z(line) - regions.surface.height(*line.T))
        assert error[4] < 1e-6  # it meets the surface there
        assert error.max() < beside


@pytest.mark.parametrize("slope_deg", [10, 20])
def test_a_way_that_ends_at_a_kink_has_its_plane(slope_deg: int) -> None:
    """Exactly, on both sides. Yet it counts as curved: another way may lead across."""
    slope = float(np.tan(np.radians(slope_deg)))
    regions = regions_of(Terrain.from_parts([Ramp(x=0.0, length=2.0, slope_deg=slope_deg)]), RADIUS)
    kink = -RADIUS * (np.sqrt(1.0 + slope**2) - 1.0) / slope  # where the wheel touches both planes
    begin, at, end = ([kink + by, 0.0] for by in (-0.01, 0.0, 0.07))
    before, after = models_along(regions, np.array([begin, at]), np.array([at, end]), np.zeros(2))
    np.testing.assert_allclose(before.slope, 0.0, atol=1e-12)
    np.testing.assert_allclose(after.slope, [slope, 0.0], atol=1e-12)
    assert before.height == pytest.approx(0.0, abs=1e-12)
    assert not before.curvature.any()
    assert not after.curvature.any()
    assert before.curved


@given(worlds, seeds)
@settings(max_examples=15)
def test_many_local_models_are_those_of_each(world: Terrain, seed: int) -> None:
    regions = regions_of(world, RADIUS)
    points = places(seed, 60)
    refs = points[regions.free(points)][:12]
    headings = np.linspace(-2.0, 2.0, len(refs))
    ends = refs + 0.05 * np.column_stack([np.cos(headings), np.sin(headings)])
    for k, model in enumerate(models_along(regions, refs, ends, headings)):
        (alone,) = models_along(regions, refs[k, None], ends[k, None], headings[k, None])
        np.testing.assert_allclose(model.numbers(), alone.numbers(), atol=1e-9)


@given(worlds, seeds)
@settings(max_examples=8)
def test_what_is_free_on_a_map_has_a_convex_region_on_it(world: Terrain, seed: int) -> None:
    """A point is not the middle of its cell; and no region goes on beyond the border of the map."""
    regions = regions_of(world.raster(0.02, (-1.0, -1.0), (1.0, 1.0)), RADIUS)
    points = places(seed, 200, 0.99)
    for point in points[regions.free(points)][:40]:
        box = regions.box(point[None])
        assert box is not None
        assert np.abs(box.vertices).max() <= 1.0


# -- standing --


def test_a_robot_stands_where_all_its_feet_can() -> None:
    robot = find_robot("centauro")
    regions = [regions_of(KERB, leg.wheel_radius or 0.0) for leg in robot.leg_list]
    feet = robot.stance[:, :2]
    require_standing(regions, feet - [1.0, 0.0], "start")
    with pytest.raises(InputError, match=r"must not be where FL stands: .* riser") as caught:
        require_standing(regions, feet - [feet[0, 0] + 0.05, 0.0], "start")
    assert caught.value.field == "start"
    with pytest.raises(InputError, match=r"where FL stands: it must be at least 0\.03 m away from edges"):
        require_standing(regions, feet - [feet[0, 0] - 0.02, 0.0], "goal")


def test_a_robot_does_not_stand_off_the_map_or_on_unknown_ground() -> None:
    robot = find_robot("centauro")
    values = np.zeros((101, 101))
    values[60:70, 60:90] = np.nan
    world = Terrain.from_map(values, 0.02, [-1.0, -1.0])
    regions = [regions_of(world, RADIUS)] * 4
    feet = robot.stance[:, :2]
    with pytest.raises(InputError, match="FL stands: the ground there is not known"):
        require_standing(regions, feet, "start")
    with pytest.raises(InputError, match="FL stands: that is off the map"):
        require_standing(regions, feet - [-1.0, 0.0], "goal.then.0")
