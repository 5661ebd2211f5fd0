"""Pictures of a scene without a browser or a graphics card: triangles, sorted by depth, drawn by Pillow.

`SoftwareScene` offers the layers the few methods of viser's scene that they use and keeps what they draw;
`render` draws it. What lies on the ground comes first, in the order in which it was added; then all else, the
farthest first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from operator import itemgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial.transform import Rotation

from rollgait.plan.samples import Array
from rollgait.view.camera import FIELD_OF_VIEW, Camera

SUPERSAMPLING: Final = 2
"""The picture is drawn this many times larger and then reduced: smooth edges."""
LIGHT: Final = np.array([0.35, -0.5, 0.79])
"""Direction to the light, world."""
AMBIENT: Final = 0.45
"""Brightness of what the light does not reach."""
FLAT: Final = 0.03
"""What reaches no higher than this lies on the ground, m."""
LARGEST: Final = 0.12
"""Edges longer than this are halved, m: the depth of a large triangle says little."""
SHADOW: Final = 46
"""Opacity of a shadow, of 255."""
BACKGROUND: Final = (255, 255, 255)
NEAR: Final = 0.05
"""What is nearer to the camera is left out, m."""


@dataclass(eq=False)
class Node(SimpleNamespace):
    """Something in the scene: viser's properties as plain attributes."""

    def __init__(self, name: str, kind: str, **properties: Any) -> None:
        defaults = {"position": (0.0, 0.0, 0.0), "wxyz": (1.0, 0.0, 0.0, 0.0), "visible": True}
        super().__init__(name=name, kind=kind, **(defaults | properties))


@dataclass
class SoftwareScene:
    """A scene that only remembers. Offers what `rollgait.view.layers` need of viser's."""

    nodes: dict[str, Node] = field(default_factory=dict)

    def add_frame(self, name: str, **properties: Any) -> Node:
        return self._add(name, "frame", properties)

    def add_mesh_simple(self, name: str, vertices: Array, faces: Any, **properties: Any) -> Node:
        return self._add(name, "mesh", properties | {"vertices": vertices, "faces": faces})

    def add_batched_meshes_simple(self, name: str, vertices: Array, faces: Any, **properties: Any) -> Node:
        return self._add(name, "batch", properties | {"vertices": vertices, "faces": faces})

    def add_line_segments(self, name: str, points: Array, colors: Any, **properties: Any) -> Node:
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


@dataclass(frozen=True)
class Piece:
    """Polygons of one kind.

    Attributes:
        corners: (m, k, 3), world, m; k = 2 for lines.
        colours: red, green, blue, alpha, (m, 4).
        flat: whether it lies on the ground.
        width: of lines, m.
        casts: whether it casts a shadow.
        ground: whether it is the ground itself.
    """

    corners: Array
    colours: NDArray[np.uint8]
    flat: bool
    width: float = 0.0
    casts: bool = False
    ground: bool = False


def render(scene: SoftwareScene, camera: Camera, size: tuple[int, int], text: str = "") -> Image.Image:
    """A picture of a scene.

    Args:
        scene: what is to be seen.
        camera: from where.
        size: width and height, pixels.
        text: written into the upper left corner, line by line.
    """
    large = (size[0] * SUPERSAMPLING, size[1] * SUPERSAMPLING)
    picture = Image.new("RGB", large, BACKGROUND)
    draw = ImageDraw.Draw(picture, "RGBA")
    pieces = [piece for node, R, p in scene.visible() for piece in _pieces(node, R, p, camera)]
    for number, piece in enumerate(pieces):
        if piece.flat:
            _draw([piece], camera, large, draw)
        if piece.ground:
            _draw_shadows([p for p in pieces[number:] + pieces[:number] if p.casts], camera, large, picture)
    _draw([piece for piece in pieces if not piece.flat], camera, large, draw)
    result = picture.reduce(SUPERSAMPLING)
    if text:
        _write(result, text)
    return result


def _draw(pieces: list[Piece], camera: Camera, size: tuple[int, int], draw: ImageDraw.ImageDraw) -> None:
    """Draws pieces, the farthest polygons first."""
    polygons: list[tuple[float, list[float], tuple[int, ...], float]] = []
    scale = _focal(size)
    for piece in pieces:
        if not len(piece.corners):
            continue
        pixels, depth = _project(piece.corners, camera, size)
        seen = (depth > NEAR).all(axis=1)
        means = depth[seen].mean(axis=1)
        flat = pixels[seen].reshape(len(means), 2 * piece.corners.shape[1]).tolist()
        colours = map(tuple, piece.colours[seen].tolist())
        widths = (piece.width * scale / means).tolist()
        polygons += zip(means.tolist(), flat, colours, widths, strict=True)
    for _, corners, colour, width in sorted(polygons, key=itemgetter(0), reverse=True):
        if len(corners) == 4:
            draw.line(corners, fill=colour, width=max(1, round(width)))
        else:
            draw.polygon(corners, fill=colour)


def _draw_shadows(pieces: list[Piece], camera: Camera, size: tuple[int, int], picture: Image.Image) -> None:
    """Darkens where the light does not reach the ground (z = 0)."""
    mask = Image.new("L", size, 0)
    draw = ImageDraw.Draw(mask)
    for piece in pieces:
        fallen = piece.corners - LIGHT * (piece.corners[..., 2:] / LIGHT[2])
        pixels, depth = _project(fallen, camera, size)
        for corners in pixels[(depth > NEAR).all(axis=1)]:
            draw.polygon(corners.ravel().tolist(), fill=SHADOW)
    picture.paste(Image.new("RGB", size, (60, 66, 75)), mask=mask)


def _pieces(node: Node, R: Array, p: Array, camera: Camera) -> Iterator[Piece]:
    """What a node looks like, in the world."""
    if node.kind == "mesh":
        vertices = np.asarray(node.vertices, dtype=float) @ R.T + p
        yield _mesh(vertices, node.faces, np.array(node.color), node, camera)
    elif node.kind == "batch":
        colours = _with_gamma(np.broadcast_to(node.batched_colors, (len(node.batched_positions), 3)))
        scales = getattr(node, "batched_scales", None)
        for k, (place, turn) in enumerate(zip(node.batched_positions, node.batched_wxyzs, strict=True)):
            scale = np.ones(3) if scales is None else np.broadcast_to(scales[k], 3)
            local = (np.asarray(node.vertices) * scale) @ _matrix(turn).T + place
            yield _mesh(local @ R.T + p, node.faces, colours[k], node, camera)
    elif node.kind == "lines":
        points = np.asarray(node.points, dtype=float) @ R.T + p
        colours = np.asarray(node.colors)
        shades = colours if colours.ndim == 1 else _with_gamma(colours[:, 0])
        yield Piece(
            points,
            _with_alpha(np.broadcast_to(shades, (len(points), 3)), None),
            _is_flat(points),
            node.thickness,
        )
    elif node.kind == "grid":
        yield from _grid(node)


def _mesh(vertices: Array, faces: Any, colour: Array, node: Node, camera: Camera) -> Piece:
    corners = vertices[np.asarray(faces, dtype=int)]
    flat = _is_flat(corners)
    if not flat:
        corners = _halved(corners)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    corners, normal = corners[area > 1e-12], normal[area > 1e-12]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    away = ((corners.mean(axis=1) - camera.position) * normal).sum(axis=1) > 0.0
    if getattr(node, "side", "front") == "double":
        normal[away] *= -1.0
    else:
        corners, normal = corners[~away], normal[~away]
    facing = normal @ LIGHT
    light = np.ones(len(corners)) if flat else AMBIENT + (1.0 - AMBIENT) * np.clip(facing, 0.0, 1.0)
    shades = np.clip(light[:, None] * (colour + 18.0), 0.0, 255.0)
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
        yield Piece(np.array(lines), shades, True, width, ground=spacing == node.section_size)


def _halved(corners: Array) -> Array:
    """The same surface with smaller triangles where they are large."""
    for _ in range(4):
        size = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
        large = size > LARGEST
        if not large.any() or len(corners) > 100_000:
            break
        a, b, c = np.moveaxis(corners[large], 1, 0)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        corners = np.concatenate([corners[~large], *parts])
    return corners


def _project(points: Array, camera: Camera, size: tuple[int, int]) -> tuple[Array, Array]:
    """Pixels (…, 2) and depths (…) of points (…, 3)."""
    ahead = camera.look_at - camera.position
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    way = points - camera.position
    depth = way @ ahead
    across = np.stack([way @ right, -(way @ np.cross(right, ahead))], axis=-1)
    safe = np.maximum(depth, NEAR)[..., None]
    return _focal(size) * across / safe + 0.5 * np.array(size), depth


def _focal(size: tuple[int, int]) -> float:
    return float(0.5 * size[1] / np.tan(0.5 * FIELD_OF_VIEW))


def _is_flat(points: Array) -> bool:
    return bool(len(points) and np.abs(points[..., 2]).max() < FLAT)


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
