"""The ground as glTF: the one way in which viser takes a mesh whose triangles have colours of their own."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb

from rollgait.terrain.mesh import GroundMesh
from rollgait.view.layers.layer import linear

PAINT: Final = 0.75
"""Share of the light that the brightest ground sends back: with all of it level ground would be white."""


def ground_glb(mesh: GroundMesh) -> bytes:
    """The file of a mesh; in it each triangle has vertices of its own, in its colour."""
    count = len(mesh.faces)
    colours = np.column_stack([linear(mesh.colours), np.full(count, 255, dtype=np.uint8)])
    triangles = trimesh.Trimesh(
        mesh.corners.reshape(-1, 3),
        np.arange(3 * count).reshape(-1, 3),
        vertex_colors=np.repeat(colours, 3, axis=0),
        process=False,
    )
    export: Any = export_glb  # has no types
    return bytes(export(trimesh.Scene(triangles), tree_postprocessor=_dull))


def _dull(tree: dict[str, Any]) -> None:
    """Takes the gloss from the mesh: what has no material is bare metal in glTF."""
    look = {"metallicFactor": 0.0, "roughnessFactor": 1.0, "baseColorFactor": [PAINT, PAINT, PAINT, 1.0]}
    tree["materials"] = [{"pbrMetallicRoughness": look}]
    for mesh in tree["meshes"]:
        for part in mesh["primitives"]:
            part["material"] = 0
