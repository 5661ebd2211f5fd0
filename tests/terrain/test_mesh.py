"""The mesh of a ground is the ground: its heights, its walls, its holes; and it turns with the world."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.terrain import Terrain
from rollgait.terrain.mesh import mesh_of
from tests.terrain.surface import away_from_edges, seen_from_above
from tests.terrain.worlds import parts, places, rounded, seeds, turned, worlds

LOW, HIGH = (-1.5, -1.5), (1.5, 1.5)
few = settings(max_examples=40, deadline=None)


@few
@given(worlds, seeds)
def test_planes_have_their_heights(terrain: Terrain, seed: int) -> None:
    points = away_from_edges(terrain, places(seed))
    np.testing.assert_allclose(
        seen_from_above(mesh_of(terrain, LOW, HIGH).corners, points), terrain.height(*points.T), atol=1e-6
    )


@few
@given(worlds, seeds, rounded(-3.0, 3.0))
def test_a_turned_world_turns_the_mesh(terrain: Terrain, seed: int, yaw: float) -> None:
    points = away_from_edges(terrain, places(seed, 100, 1.0))
    low, high = (-2.0, -2.0), (2.0, 2.0)
    there = seen_from_above(mesh_of(terrain.turned(yaw), low, high).corners, turned(points, yaw))
    np.testing.assert_allclose(there, seen_from_above(mesh_of(terrain, low, high).corners, points), atol=1e-6)


@few
@given(worlds, seeds, rounded(-0.2, 0.2), rounded(-0.2, 0.2))
def test_no_look_from_the_side_goes_through(terrain: Terrain, seed: int, x: float, y: float) -> None:
    points = places(seed, 100, 0.9)
    assert not np.isnan(seen_from_above(mesh_of(terrain, LOW, HIGH).corners, points, (x, y))).any()


@few
@given(seeds, rounded(-3.0, 3.0), st.lists(parts, max_size=2))
def test_maps_have_their_heights_at_nodes_and_holes_stay_open(
    seed: int, yaw: float, on_it: list[dict[str, object]]
) -> None:
    rng = np.random.default_rng(seed)
    heights = rng.normal(0.0, 0.03, (20, 24))
    heights[rng.random(heights.shape) < 0.05] = np.nan
    terrain = Terrain.from_map(heights, 0.1, (-0.5, -0.9), yaw=yaw, parts=on_it)
    assert terrain.map is not None
    nodes = terrain.map.nodes().reshape(-1, 2)
    inner = (np.abs(terrain.map.to_local(nodes) / 0.1 - [9.5, 11.5]) < [9.0, 11.0]).all(axis=1)
    nodes = away_from_edges(terrain, nodes[inner])
    centres = nodes + turned(np.array([[0.05, 0.05]]), yaw)
    mesh = mesh_of(terrain, (-9.0, -9.0), (9.0, 9.0))
    open_ = ~terrain.known(*centres.T)
    assert np.isnan(seen_from_above(mesh.corners, centres[open_])).all()
    known = [terrain.known(*(nodes + d).T) for d in turned(0.01 * np.array([[1, 1], [-1, -1], [1, -1]]), yaw)]
    at = nodes[np.all(known, axis=0)]
    np.testing.assert_allclose(seen_from_above(mesh.corners, at), terrain.height(*at.T), atol=1e-6)


def test_a_large_map_has_few_triangles() -> None:
    x = np.linspace(0.0, 6.0, 601)
    terrain = Terrain.from_map(0.1 * np.sin(x)[:, None] * np.ones((1, 401)), 0.01)
    mesh = mesh_of(terrain, (0.0, 0.0), (6.0, 4.0), cells=2000)
    assert 1000 < len(mesh.faces) <= 4400
    points = places(0, 100, 1.0) + np.array([3.0, 2.0])
    np.testing.assert_allclose(seen_from_above(mesh.corners, points), terrain.height(*points.T), atol=2e-3)


def test_colours_tell_heights_apart() -> None:
    stairs = Terrain.from_parts([{"kind": "stairs", "x": 0.0, "steps": 3, "rise": 0.1, "tread": 0.3}])
    mesh = mesh_of(stairs, LOW, HIGH)
    normal = np.cross(*(mesh.corners[:, k] - mesh.corners[:, 0] for k in (1, 2)))
    tops = normal[:, 2] > 1e-9
    of_height = {
        float(z): {
            tuple(c) for c in mesh.colours[tops & (np.abs(mesh.corners[..., 2].max(axis=1) - z) < 1e-6)]
        }
        for z in (0.0, 0.1, 0.2, 0.3)
    }
    assert all(len(colours) == 1 for colours in of_height.values())
    assert len(set.union(*of_height.values())) == 4
