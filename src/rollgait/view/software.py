"""Pictures of a scene without a browser or a graphics card: triangles, sorted by depth, drawn by Pillow.

`SoftwareScene` offers the layers the few methods of viser's scene that they use and keeps what they draw;
`render` draws it. The ground comes first, then what lies on it, in the order in which it was added, then all
else, the farthest first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial.transform import Rotation

from rollgait.plan.samples import Array
from rollgait.terrain import Terrain
from rollgait.terrain.mesh import GroundMesh
from rollgait.terrain.relief import LIGHT
from rollgait.view.backdrop import Backdrop, backdrop_of, draw_shadows
from rollgait.view.camera import Camera
from rollgait.view.on_ground import heights
from rollgait.view.painter import Piece, cut_short, draw_pieces, halved

SUPERSAMPLING: Final = 2
"""The picture is drawn this many times larger and then reduced: smooth edges."""
AMBIENT: Final = 0.45
"""Brightness of what the light does not reach."""
FLAT: Final = 0.03
"""What reaches no higher than this lies on the ground, m."""
GROUND: Final = "/ground/"
"""In the names of the triangles and lines of the ground."""
GROUND_LARGEST: Final = 0.1
"""Sides of the ground's triangles, m: whoever stands behind them is hidden."""


@dataclass(eq=False)
class Node(SimpleNamespace):
    """Something in the scene: viser's properties as plain attributes."""

    def __init__(self, name: str, kind: str, **properties: Any) -> None:
        defaults = {"position": (0.0, 0.0, 0.0), "wxyz": (1.0, 0.0, 0.0, 0.0), "visible": True}
        super().__init__(name=name, kind=kind, **(defaults | properties))


@dataclass
class SoftwareScene:
    """A scene that only remembers. Offers what `rollgait.view.layers` need of viser's.

    Attributes:
        terrain: the ground on which shadows fall and other things lie.
        nodes: by their names.
    """

    terrain: Terrain = field(default_factory=Terrain)
    nodes: dict[str, Node] = field(default_factory=dict)
    _backdrops: dict[Any, Backdrop] = field(default_factory=dict)

    def add_frame(self, name: str, **properties: Any) -> Node:
        return self._add(name, "frame", properties)

    def add_mesh_simple(self, name: str, vertices: Array, faces: Any, **properties: Any) -> Node:
        return self._add(name, "mesh", properties | {"vertices": vertices, "faces": faces})

    def add_ground_mesh(self, name: str, mesh: GroundMesh) -> Node:
        """The ground, as it is: for a browser it is a glTF."""
        return self._add(
            name, "mesh", {"vertices": mesh.vertices, "faces": mesh.faces, "color": mesh.colours}
        )

    def add_batched_meshes_simple(self, name: str, vertices: Array, faces: Any, **properties: Any) -> Node:
        return self._add(name, "batch", properties | {"vertices": vertices, "faces": faces})

    def add_line_segments(self, name: str, points: Any, colors: Any, **properties: Any) -> Node:
        return self._add(name, "lines", properties | {"points": points, "colors": colors})

    def add_grid(self, name: str, **properties: Any) -> Node:
        return self._add(name, "grid", properties)

    def _add(self, name: str, kind: str, properties: dict[str, Any]) -> Node:
        node = self.nodes[name] = Node(name, kind, **properties)
        return node

    def visible(self) -> Iterator[tuple[Node, Array, Array]]:
        """All nodes that are to be seen, with their poses in the world."""
        for node in self.nodes.values():
            R, p, shown = np.eye(3), np.zeros(3), True
            parts = node.name.strip("/").split("/")
            for depth in range(1, len(parts) + 1):
                above = self.nodes.get("/" + "/".join(parts[:depth]))
                if above is None:
                    continue
                shown = shown and above.visible
                p = p + R @ np.asarray(above.position, dtype=float)
                R = R @ _matrix(above.wxyz)
            if shown:
                yield node, R, p


def render(scene: SoftwareScene, camera: Camera, size: tuple[int, int], text: str = "") -> Image.Image:
    """A picture of a scene.

    Args:
        scene: what is to be seen.
        camera: from where.
        size: width and height, pixels.
        text: written into the upper left corner, line by line.
    """
    large = (size[0] * SUPERSAMPLING, size[1] * SUPERSAMPLING)
    backdrop = _backdrop(scene, camera, large)
    picture = backdrop.picture.copy()
    draw = ImageDraw.Draw(picture, "RGBA")
    pieces = [
        piece
        for node, R, p in scene.visible()
        if not _is_ground(node)
        for piece in _pieces(node, R, p, camera, scene.terrain)
    ]
    draw_shadows([piece for piece in pieces if piece.casts], scene.terrain, camera, backdrop, picture)
    for piece in pieces:
        if piece.flat:
            draw_pieces([piece], camera, large, draw, backdrop.is_seen)
    draw_pieces([piece for piece in pieces if not piece.flat], camera, large, draw, backdrop.is_seen)
    result = picture.reduce(SUPERSAMPLING)
    if text:
        _write(result, text)
    return result


def _backdrop(scene: SoftwareScene, camera: Camera, size: tuple[int, int]) -> Backdrop:
    """The ground, drawn again only if something about it has changed."""
    nodes = [(node, R, p) for node, R, p in scene.visible() if _is_ground(node)]
    poses = tuple((node.name, R.tobytes(), p.tobytes()) for node, R, p in nodes)
    key = (poses, camera.position.tobytes(), camera.look_at.tobytes(), size)
    if key not in scene._backdrops:
        scene._backdrops.clear()
        pieces = [piece for node, R, p in nodes for piece in _ground_pieces(node, R, p, camera)]
        scene._backdrops[key] = backdrop_of(pieces, camera, size)
    return scene._backdrops[key]


def _is_ground(node: Node) -> bool:
    return node.kind == "grid" or (GROUND in node.name and node.kind != "frame")


def _ground_pieces(node: Node, R: Array, p: Array, camera: Camera) -> Iterator[Piece]:
    """What a node of the ground looks like, in the world: its colours are those of its light already."""
    if node.kind == "grid":
        yield from _grid(node)
    elif node.kind == "lines":
        lines = _lines(node, R, p, True)
        parts, number = cut_short(lines.corners, GROUND_LARGEST)
        yield replace(lines, corners=parts, colours=lines.colours[number])
    else:
        corners = (np.asarray(node.vertices, dtype=float) @ R.T + p)[np.asarray(node.faces, dtype=int)]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing = ((camera.position - corners[:, 0]) * normal).sum(axis=1) > 0.0
        parts, number = halved(corners[facing], GROUND_LARGEST, 10)
        yield Piece(parts, _with_alpha(node.color[facing][number], None), False)


def _pieces(node: Node, R: Array, p: Array, camera: Camera, terrain: Terrain) -> Iterator[Piece]:
    """What a node looks like, in the world."""
    if node.kind == "mesh":
        vertices = np.asarray(node.vertices, dtype=float) @ R.T + p
        corners = vertices[np.asarray(node.faces, dtype=int)]
        colours = np.broadcast_to(np.array(node.color, dtype=float), (len(corners), 3))
        yield _mesh(corners, colours, _is_flat(corners, terrain), node, camera)
    elif node.kind == "batch":
        yield from _batch(node, R, p, camera, terrain)
    elif node.kind == "lines":
        yield _lines(node, R, p, _is_flat(np.asarray(node.points, dtype=float) @ R.T + p, terrain))


def _lines(node: Node, R: Array, p: Array, flat: bool) -> Piece:
    points = np.asarray(node.points, dtype=float) @ R.T + p
    colours = np.asarray(node.colors)
    shades = colours if colours.ndim == 1 else _with_gamma(colours[:, 0])
    every = _with_alpha(np.broadcast_to(shades, (len(points), 3)), None)
    return Piece(points, every, flat, node.thickness)


def _batch(node: Node, R: Array, p: Array, camera: Camera, terrain: Terrain) -> Iterator[Piece]:
    """The same thing at many places: those that lie on the ground, and all others."""
    count = len(node.batched_positions)
    if not count:
        return
    scales = getattr(node, "batched_scales", None)
    scale = np.ones((count, 3)) if scales is None else np.asarray(scales, dtype=float).reshape(count, -1)
    turns = Rotation.from_quat(np.asarray(node.batched_wxyzs, dtype=float), scalar_first=True).as_matrix()
    local = np.asarray(node.vertices, dtype=float) * scale[:, None]
    local = local @ turns.swapaxes(1, 2) + np.asarray(node.batched_positions, dtype=float)[:, None]
    vertices = local @ R.T + p  # (n, v, 3)
    colours = _with_gamma(np.broadcast_to(node.batched_colors, (count, 3)))
    faces = np.asarray(node.faces, dtype=int)
    flat = np.abs(vertices[..., 2] - heights(terrain, vertices)).max(axis=1) < FLAT
    for which, lies in ((flat, True), (~flat, False)):
        if which.any():
            corners = vertices[which][:, faces].reshape(-1, 3, 3)
            yield _mesh(corners, np.repeat(colours[which], len(faces), axis=0), lies, node, camera)


def _mesh(corners: Array, colours: Array, flat: bool, node: Node, camera: Camera) -> Piece:
    """Triangles (n, 3, 3) of these colours (n, 3) that face the camera, in their light."""
    if not flat:
        corners, number = halved(corners)
        colours = colours[number]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    corners, colours, normal = (values[area > 1e-12] for values in (corners, colours, normal))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    away = ((corners.mean(axis=1) - camera.position) * normal).sum(axis=1) > 0.0
    if getattr(node, "side", "front") == "double":
        normal[away] *= -1.0
    else:
        corners, colours, normal = (values[~away] for values in (corners, colours, normal))
    facing = normal @ LIGHT
    light = np.ones(len(corners)) if flat else AMBIENT + (1.0 - AMBIENT) * np.clip(facing, 0.0, 1.0)
    shades = np.clip(light[:, None] * (colours + 18.0), 0.0, 255.0)
    casts = not flat and getattr(node, "cast_shadow", True) and getattr(node, "opacity", None) is None
    return Piece(corners, _with_alpha(shades, getattr(node, "opacity", None)), flat, casts=casts)


def _grid(node: Node) -> Iterator[Piece]:
    """The plane and its lines."""
    w, h = 0.5 * node.width, 0.5 * node.height
    at = np.asarray(node.position, dtype=float)
    plane = np.array([[[-w, -h, 0.0], [w, -h, 0.0], [w, h, 0.0], [-w, h, 0.0]]]) + at
    yield Piece(plane, _with_alpha(np.array([node.plane_color]), None), True)
    for spacing, colour, width in (
        (node.cell_size, node.cell_color, 0.003),
        (node.section_size, node.section_color, 0.005),
    ):
        lines = []
        for a, b, axis in ((w, h, 0), (h, w, 1)):
            for place in np.arange(-a, a + 1e-9, spacing):
                line = np.array([[place, -b, 0.0], [place, b, 0.0]])
                lines.append((line if axis == 0 else line[:, [1, 0, 2]]) + at)
        light = 0.5 * (np.array(colour) + 255)
        shades = _with_alpha(np.tile(light, (len(lines), 1)), None)
        yield Piece(np.array(lines), shades, True, width)


def _is_flat(points: Array, terrain: Terrain) -> bool:
    """Whether it lies on the ground."""
    return bool(len(points) and np.abs(points[..., 2] - heights(terrain, points)).max() < FLAT)


def _matrix(wxyz: Any) -> Array:
    return np.asarray(Rotation.from_quat(np.asarray(wxyz, dtype=float), scalar_first=True).as_matrix())


def _with_alpha(colours: Any, opacity: float | None) -> NDArray[np.uint8]:
    alpha = np.full((len(colours), 1), 255.0 if opacity is None else 255.0 * opacity)
    return np.concatenate([np.asarray(colours, dtype=float), alpha], axis=1).astype(np.uint8)


def _with_gamma(colours: Any) -> Array:
    """The inverse of `layer.linear`."""
    part = np.asarray(colours, dtype=float) / 255.0
    return np.asarray(
        255.0 * np.where(part > 0.0031308, 1.055 * np.maximum(part, 1e-9) ** (1 / 2.4) - 0.055, 12.92 * part)
    )


def _write(picture: Image.Image, text: str) -> None:
    size = max(12, picture.height // 36)
    ImageDraw.Draw(picture).multiline_text((size, size), text, fill=(40, 40, 40), font=_font(size))


@lru_cache(maxsize=4)
def _font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", size)
