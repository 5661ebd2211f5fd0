"""The ground in MuJoCo: a plane, or what a `Terrain` is made of.

Planar parts become boxes where they are level rectangles, else prisms; both reach down below the lowest of
them, so that risers are walls. A map becomes a field of heights. Of a contact the ground says how it is:
friction goes by part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.facet import Facet
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.polygons import clip
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

CONTACT_TIME: Final = 5e-3
"""Time constant of a contact, s. With MuJoCo's default of 20 ms loaded wheels creep four times as fast."""

DEPTH: Final = 1.0
"""How far bodies of ground reach down below the lowest planar part, m: a foot that strikes hard must not get
through. Where a map does not know the ground, it is a pit so deep."""

REACH: Final = 100.0
"""How far from where the robot starts planar parts go on, m: bodies that are much longer than deep or wide
make collisions inexact."""

UNDERCUT: Final = 1e-3
"""So far a map lies below a part that covers it, at least, m: the part is what is touched."""

RECTANGLE_TOLERANCE: Final = 1e-9
"""By how much corners of a box may miss those of its part, relative to its size."""

GROUND: Final = "ground"

_COLOUR: Final = [0.66, 0.6, 0.5, 1.0]
"""Sand, as in other pictures: what lies on the pale squares of the plane is seen to be something else."""


def add_plane(spec: Any, height: float, friction: float, visual: bool) -> None:
    """A horizontal plane without end.

    Args:
        spec: MuJoCo's editable description.
        height: its z, m.
        friction: μ.
        visual: whether people look at it.
    """
    _add_plane(spec, GROUND, height, _surface(friction), visual)
    if visual:
        _add_light_and_sky(spec)


def add_terrain(spec: Any, terrain: Terrain, about: Array, friction: float, visual: bool) -> None:
    """All bodies of a ground, where it is, within `REACH`.

    Args:
        spec: MuJoCo's editable description.
        terrain: the ground.
        about: where the robot starts, (2,), m.
        friction: true μ where no part says its own; that of a part is larger than it says by the same factor.
        visual: whether people look at it.
    """
    factor = friction / terrain.friction
    if terrain.map is not None:
        lowered = _lowered(terrain)
        _add_map(spec, lowered, terrain.level, _surface(friction) | {"priority": 1})
        # who leaves the map falls as deep as who steps where it knows nothing
        pit = terrain.level + float(lowered.values.min()) - UNDERCUT
        _add_plane(spec, GROUND, pit, _surface(friction) | {"priority": 1}, visual=False)
    else:
        _add_level(spec, terrain, _surface(friction) | {"priority": 1}, visual)
    bodies = [near for facet in _bodies(terrain) if (near := _within_reach(facet, about)) is not None]
    bottom = _lowest(bodies) - DEPTH
    for number, facet in enumerate(bodies):
        surface = _surface(facet.friction * factor) | {"priority": 1}
        _add_piece(spec, f"{GROUND}_{number}", facet, bottom, surface)
    if visual:
        _add_light_and_sky(spec)


def _surface(friction: float) -> dict[str, Any]:
    """What all geoms of ground have in common."""
    return {
        "contype": 0,
        "conaffinity": 1,
        "condim": 3,
        "solref": [CONTACT_TIME, 1.0],
        "friction": [friction, 0.0, 0.0],
        "rgba": _COLOUR,
    }


# -- planar parts --


def _is_bare(terrain: Terrain) -> bool:
    """Whether nothing lies below the plane that all parts lie on: then it may stay whole, under them."""
    raised = [facet for facet in terrain.planes if facet.source >= 0]
    return terrain.map is None and _lowest(raised, terrain.level) >= terrain.level


def _add_level(spec: Any, terrain: Terrain, surface: dict[str, Any], visual: bool) -> None:
    if _is_bare(terrain):
        _add_plane(spec, GROUND, terrain.level, surface, visual)


def _bodies(terrain: Terrain) -> list[Facet]:
    """The planar pieces that get a body of their own."""
    if _is_bare(terrain):
        return [facet for facet in terrain.planes if facet.source >= 0]
    return list(terrain.planes)


def _within_reach(facet: Facet, about: Array) -> Facet | None:
    polygon: Array | None = facet.polygon
    for inwards in (*np.eye(2), *-np.eye(2)):
        if polygon is not None:
            polygon = clip(polygon, about - REACH * inwards, inwards)
    return None if polygon is None else replace(facet, polygon=polygon)


def _lowest(facets: Sequence[Facet], otherwise: float = 0.0) -> float:
    """The lowest z of planar pieces, m."""
    return min((float(facet.z(facet.polygon).min()) for facet in facets), default=otherwise)


def _add_piece(spec: Any, name: str, facet: Facet, bottom: float, surface: dict[str, Any]) -> None:
    box = _as_box(facet)
    if box is not None:
        centre, half, yaw = box
        level = float(facet.z(centre))
        spec.worldbody.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[*half, 0.5 * (level - bottom)],
            pos=[*centre, 0.5 * (level + bottom)],
            quat=_turn(yaw),
            **surface,
        )
        return
    centre = facet.polygon.mean(axis=0)  # corners are single numbers: keep them small
    top = np.column_stack([facet.polygon - centre, facet.z(facet.polygon) - bottom])
    foot = top * np.array([1.0, 1.0, 0.0])
    spec.add_mesh(name=name, uservert=np.concatenate([top, foot]).ravel())
    spec.worldbody.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, pos=[*centre, bottom], **surface
    )


def _as_box(facet: Facet) -> tuple[Array, Array, float] | None:
    """Centre (2,), half sides (2,) and yaw of a level rectangle; None if it is none."""
    corners = facet.polygon
    if len(corners) != 4 or facet.slope.any():
        return None
    centre = corners.mean(axis=0)
    along, across = corners[1] - corners[0], corners[2] - corners[1]
    size = float(np.abs(corners - centre).max())
    closes = np.abs(corners[0] + corners[2] - corners[1] - corners[3]).max() <= RECTANGLE_TOLERANCE * size
    if not closes or abs(along @ across) > RECTANGLE_TOLERANCE * size**2:
        return None
    half = 0.5 * np.array([np.linalg.norm(along), np.linalg.norm(across)])
    return centre, half, float(np.arctan2(along[1], along[0]))


# -- a map --


def _lowered(terrain: Terrain) -> HeightMap:
    """The map under the parts that lie on it, and a pit where it does not know the ground."""
    raster = terrain.map
    assert raster is not None
    nodes = raster.nodes()
    points, values = nodes.reshape(-1, 2), raster.values.copy().reshape(-1)
    for facet in terrain.planes:
        covered = facet.contains(points)
        below = facet.z(points[covered]) - terrain.level - UNDERCUT
        values[covered] = np.fmin(values[covered], below)
    values = np.where(np.isnan(values), np.nanmin(values) - DEPTH, values)
    return HeightMap(values.reshape(raster.values.shape), raster.resolution, raster.origin, raster.yaw)


def _add_map(spec: Any, raster: HeightMap, level: float, surface: dict[str, Any]) -> None:
    lowest, highest = float(raster.values.min()), float(raster.values.max())
    centre = raster.to_world(0.5 * raster.size)
    columns, rows = raster.values.shape
    # MuJoCo stretches the values between the lowest and the highest
    spec.add_hfield(
        name=f"{GROUND}_map",
        nrow=rows,
        ncol=columns,
        size=[*(0.5 * raster.size), max(highest - lowest, UNDERCUT), DEPTH],
        userdata=(raster.values.T - lowest).ravel(),
    )
    spec.worldbody.add_geom(
        name=f"{GROUND}_map",
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname=f"{GROUND}_map",
        pos=[*centre, level + lowest],
        quat=_turn(raster.yaw),
        **surface,
    )


# -- to be looked at --


def _add_plane(spec: Any, name: str, height: float, surface: dict[str, Any], visual: bool) -> None:
    look = {}
    if visual:
        spec.add_texture(
            name="squares",
            type=mujoco.mjtTexture.mjTEXTURE_2D,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
            rgb1=[0.85, 0.87, 0.9],
            rgb2=[0.75, 0.78, 0.82],
            width=256,
            height=256,
        )
        textures = [""] * mujoco.mjtTextureRole.mjNTEXROLE
        textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "squares"
        spec.add_material(name="squares", texrepeat=[1.0, 1.0], texuniform=True, textures=textures)
        look = {"material": "squares", "rgba": [1.0, 1.0, 1.0, 1.0]}
    spec.worldbody.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 1.0],
        pos=[0.0, 0.0, height],
        **(surface | look),
    )


def _add_light_and_sky(spec: Any) -> None:
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, dir=[0.3, 0.5, -1.0], castshadow=False
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.96, 0.97, 0.99],
        rgb2=[0.7, 0.79, 0.9],
        width=64,
        height=64,
    )


def _turn(yaw: float) -> list[float]:
    """Quaternion (w, x, y, z) of a turn about z."""
    return [float(np.cos(0.5 * yaw)), 0.0, 0.0, float(np.sin(0.5 * yaw))]
