"""The ground of our simulations as MuJoCo's XML, for models of others."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco

from rollgait.simulation.ground_bodies import Array, add_terrain
from rollgait.terrain.terrain import Terrain


def ground_xml(terrain: Terrain, about: Array) -> list[ET.Element]:
    """Its assets and its geoms, as elements `asset` and `worldbody`.

    Args:
        terrain: the ground.
        about: where the robot starts, (2,), m.
    """
    spec = mujoco.MjSpec()
    add_terrain(spec, terrain, about, terrain.friction, visual=False)
    spec.compile()
    return [part for part in ET.fromstring(spec.to_xml()) if part.tag in ("asset", "worldbody")]
