"""Lights: one from above, one from below, and the sky.

The sky is a light of two colours and not a picture of a hall, viser's default: every pixel looks that picture
up, which takes a third of the time of drawing where there is no graphics card.
"""

from __future__ import annotations

from typing import Final

from viser import SceneApi

SKY: Final = (255, 255, 255)
EARTH: Final = (222, 224, 228)
BRIGHTNESS: Final = 3.0
"""Of the sky, in the unit of three.js: dark bodies keep their edges, and light ones do not burn out."""


def add_lights(scene: SceneApi) -> None:
    """Lights a scene, once."""
    scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/sky", sky_color=SKY, ground_color=EARTH, intensity=BRIGHTNESS, position=(0.0, 0.0, 1.0)
    )


def cast_shadows(scene: SceneApi, shown: bool) -> None:
    """Switches shadows on or off."""
    scene.configure_default_lights(cast_shadow=shown)
