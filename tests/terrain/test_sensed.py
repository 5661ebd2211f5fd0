"""Maps as sensors give them: noise goes, edges stay, and what can be stood on is found."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.robot.library import find_robot
from rollgait.scenario import Scenario
from rollgait.terrain import Terrain, regions_of
from rollgait.terrain.noise import TILE, WINDOWS, noise_of, without_noise
from tests.terrain.sensed import CELL, HALF, HIDES, SIGMA, STANDS, WORLDS, measured
from tests.terrain.worlds import RADIUS, Array, places, rounded, seeds

slopes = rounded(-0.4, 0.4)
CIRCLE = np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 17)), np.sin(np.linspace(0, 2 * np.pi, 17))])


def plane(gx: float, gy: float, shape: tuple[int, int] = (60, 50)) -> Array:
    i, j = np.indices(shape)
    return np.asarray(CELL * (gx * i + gy * j))


def noisy(seed: int, shape: tuple[int, int] = (60, 50)) -> Array:
    """Noise about a kerb, with unknown nodes."""
    rng = np.random.default_rng(seed)
    z = SIGMA * rng.standard_normal(shape)
    z[shape[0] // 2 :] += 0.1
    z[rng.random(shape) < 0.05] = np.nan
    return z


# -- the filter --


@given(slopes, slopes, seeds)
@settings(max_examples=15)
def test_a_plane_is_known_within_two_millimetres(gx: float, gy: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = plane(gx, gy)
    heights = truth + SIGMA * rng.standard_normal(truth.shape)
    heights[rng.random(truth.shape) < 0.05] = np.nan
    error = without_noise(heights, SIGMA) - truth
    assert np.sqrt(np.nanmean(error**2)) < 2e-3


@given(slopes, slopes, rounded(0.001, 0.05))
@settings(max_examples=15)
def test_what_has_no_noise_is_not_changed(gx: float, gy: float, sigma: float) -> None:
    """Planes, and steps between level grounds that no noise of that size explains."""
    ramp = plane(gx, gy)
    np.testing.assert_allclose(without_noise(ramp, sigma), ramp, atol=1e-12)
    np.testing.assert_array_equal(without_noise(noisy(1), 0.0), noisy(1))


@given(slopes, slopes, seeds)
@settings(max_examples=10)
def test_ground_on_a_slope_is_ground_and_a_slope(gx: float, gy: float, seed: int) -> None:
    z, slope = noisy(seed), plane(gx, gy)
    np.testing.assert_allclose(without_noise(z + slope, SIGMA), without_noise(z, SIGMA) + slope, atol=1e-9)


@given(st.sampled_from(["x", "y", "both", "diagonal"]), rounded(0.1, 5.0), seeds)
@settings(max_examples=10)
def test_it_has_no_direction_and_no_unit(mirror: str, scale: float, seed: int) -> None:
    flips = {"x": lambda a: a[::-1], "y": lambda a: a[:, ::-1], "both": lambda a: a[::-1, ::-1]}
    turn = flips.get(mirror, np.transpose)
    z = noisy(seed)
    after = without_noise(z, SIGMA)
    np.testing.assert_allclose(without_noise(turn(z), SIGMA), turn(after), atol=1e-9)
    np.testing.assert_allclose(without_noise(scale * z, scale * SIGMA), scale * after, atol=1e-9)
    np.testing.assert_array_equal(np.isnan(after), np.isnan(z))


def test_a_large_map_is_its_pieces() -> None:
    z = noisy(3, (TILE + 60, 40))
    whole, begin, reach = without_noise(z, SIGMA), TILE - 50, max(WINDOWS) - 1
    part = without_noise(z[begin:], SIGMA)
    np.testing.assert_allclose(part[reach:], whole[begin + reach :], atol=1e-9)


@given(rounded(-90.0, 90.0), rounded(-0.02, 0.02), st.sampled_from([0.05, 0.08, 0.2]), seeds)
@settings(max_examples=25)
def test_edges_stay_within_a_cell(yaw_deg: float, offset: float, height: float, seed: int) -> None:
    """Farther than a cell from a step, all but one node in a hundred are nearer to their own level."""
    rng = np.random.default_rng(seed)
    i, j = np.indices((60, 60)) - 29.5
    away = CELL * (np.cos(np.radians(yaw_deg)) * i + np.sin(np.radians(yaw_deg)) * j) - offset
    truth = height * (away > 0.0)
    after = without_noise(truth + SIGMA * rng.standard_normal(truth.shape), SIGMA)
    beyond = (np.abs(away) > CELL) & (np.abs(away) < 4.0 * CELL)
    wrong = np.abs(after - truth)[beyond] > 0.5 * height
    assert wrong.mean() < 0.01
    assert np.sqrt(np.mean((after - truth)[np.abs(away) > 2.0 * CELL] ** 2)) < 3e-3


@given(slopes, slopes, rounded(0.0005, 0.05), seeds)
@settings(max_examples=15)
def test_noise_can_be_estimated(gx: float, gy: float, sigma: float, seed: int) -> None:
    z = plane(gx, gy) + sigma / SIGMA * noisy(seed)
    z[30:] += 0.3
    assert noise_of(z) == pytest.approx(sigma, rel=0.15)
    assert noise_of(plane(gx, gy)) < 1e-12


def test_a_map_of_40000_cells_takes_less_than_half_a_second() -> None:
    z = noisy(0, (200, 200))
    begin = time.process_time()
    without_noise(z, SIGMA)
    assert time.process_time() - begin < 0.5 * 4.0  # of CPU time, on a machine that is shared


# -- five worlds --


@pytest.mark.parametrize("name", WORLDS)
@pytest.mark.parametrize("noise", [SIGMA, "auto"])
def test_free_ground_is_found_and_no_edge_becomes_free(name: str, noise: float | str) -> None:
    world = WORLDS[name]
    x, _, heights = measured(world, seed=len(name))
    sensed = Terrain.from_map(heights, CELL, (x[0], x[0]), noise=noise, fill=0.2)  # type: ignore[arg-type]
    sensed = sensed.filled_around(STANDS + HIDES * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]))
    points = places(1, 8000, HALF - 0.2)
    free = regions_of(sensed, RADIUS).free(points)
    truly = regions_of(world, RADIUS).free(points)
    assert (free & truly).sum() > 0.85 * truly.sum()
    standing = points[free]
    ground = world.height(*standing.T)
    for offset in 0.02 * CIRCLE:
        assert (np.abs(world.height(*(standing + offset).T) - ground) < 0.03).all()


def test_without_the_filter_hardly_any_ground_is_free() -> None:
    """Else it would not be needed."""
    x, _, heights = measured(WORLDS["step"], 0)
    raw = Terrain.from_map(heights, CELL, (x[0], x[0]), fill=0.2)
    assert regions_of(raw, RADIUS).free(places(1, 2000, HALF - 0.2)).mean() < 0.2


# -- under the robot --


@given(slopes, slopes, st.sampled_from([0.0, 0.1, -0.5]), rounded(-3.0, 3.0), seeds)
@settings(max_examples=25)
def test_under_the_robot_is_what_most_of_the_ground_around_is(
    gx: float, gy: float, kerb: float, yaw: float, seed: int
) -> None:
    """A kerb or a ditch on one side, a third of a metre away from its feet, tilts nothing."""
    i, j = (np.indices((81, 81)) - 40) * CELL
    truth = 0.3 + gx * i + gy * j
    side = np.cos(yaw) * i + np.sin(yaw) * j
    hidden = np.where((np.abs(i) < 0.55) & (np.abs(j) < 0.45), np.nan, truth + kerb * (side > 0.75))
    feet = np.array([[0.35, 0.3], [0.35, -0.3], [-0.35, 0.3], [-0.35, -0.3]])
    rng = np.random.default_rng(seed)
    world = Terrain.from_map(hidden + 0.003 * rng.standard_normal(truth.shape), CELL, 2 * [-40 * CELL])
    filled = world.filled_around(feet)
    under = places(seed, 50, 0.3)
    np.testing.assert_allclose(filled.height(*under.T), 0.3 + under @ [gx, gy], atol=0.012)
    assert filled.map is not None
    assert world.map is not None
    known = ~np.isnan(world.map.values)
    np.testing.assert_array_equal(filled.map.values[known], world.map.values[known])


def test_beside_the_feet_the_ground_goes_over_into_what_is_known() -> None:
    """Half of a kerb is hidden: no riser stands where what is hidden ends; no rest of it stays unknown."""
    x = np.arange(-25, 26) * CELL
    truth = np.where(x[:, None] > 0.42, 0.1, 0.0) + 0.0 * x
    hidden = (np.abs(x) < 0.5)[:, None] & (np.abs(x) < 0.5)
    hidden[np.abs(x - 0.52) < 0.01, np.abs(x - 0.2) < 0.01] = True  # missed by the sensor right beside
    hidden[np.abs(x - 0.8) < 0.01, np.abs(x - 0.2) < 0.01] = True  # and elsewhere
    feet = np.array([[0.3, 0.3], [0.3, -0.3], [-0.3, 0.3], [-0.3, -0.3]])
    filled = Terrain.from_map(np.where(hidden, np.nan, truth), CELL, (x[0], x[0])).filled_around(feet)
    assert filled.known(0.52, 0.2)
    assert not filled.known(0.8, 0.2)
    under = places(0, 50, 0.3)
    np.testing.assert_allclose(filled.height(*under.T), 0.0, atol=1e-9)
    line = filled.height(np.linspace(0.3, 0.6, 31), 0.0)
    assert (np.diff(line) > -1e-9).all()
    assert np.diff(line).max() < 0.4 * 0.1


def test_nothing_is_concluded_from_nothing() -> None:
    values = np.full((51, 51), np.nan)
    values[0, 0] = 0.0
    world = Terrain.from_map(values, CELL)
    feet = np.array([[1.0, 1.0], [1.3, 1.0], [1.0, 1.3], [1.3, 1.3]])
    assert not world.filled_around(feet).known(1.1, 1.1)
    flat = Terrain()
    assert flat.filled_around(feet) is flat


def test_a_robot_starts_on_the_map_that_it_made(tmp_path: Path) -> None:
    """Its own stance is not seen; the map's keys say the noise; a plan finds the same ground again."""
    robot = find_robot("centauro")
    rng = np.random.default_rng(4)
    x = np.arange(-50, 51) * CELL
    z = 0.2 + SIGMA * rng.standard_normal((101, 101))
    half = np.abs(robot.stance[:, :2]).max(axis=0) + 0.15
    z[(np.abs(x) < half[0])[:, None] & (np.abs(x) < half[1])[None]] = np.nan
    np.save(tmp_path / "seen.npy", z)
    keys = {"file": "seen.npy", "resolution": CELL, "origin": [x[0], x[0]], "noise": SIGMA, "fill": 0.12}
    data = {"robot": "centauro", "goal": {"x": 0.5}, "ground": {"map": keys}}
    scenario = Scenario.from_dict(data, tmp_path)
    np.testing.assert_allclose(scenario.terrain.height(0.0, 0.0), 0.2, atol=3e-3)
    assert scenario.self_contained().terrain == scenario.terrain
    elsewhere = {**data, "start": {"x": 0.9}, "goal": {"x": 0.0}}
    with pytest.raises(InputError, match=r"goal: .* the ground there is not known"):
        Scenario.from_dict(elsewhere, tmp_path)
