"""Where one looks from: so that the whole way of a clip is in sight."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from rollgait.plan.samples import Array
from rollgait.terrain.polygons import plane_of
from rollgait.view.clip import Clip

if TYPE_CHECKING:  # figures are drawn without it
    import viser

FIELD_OF_VIEW: Final = np.radians(40.0)
"""Vertical angle of the picture, rad."""
FROM: Final = np.array([0.35, -0.8, 0.48])
"""Direction from what is looked at to the camera: from the right, a little ahead and above."""

WAY: Final = 0.9
"""How far off one looks from, in lengths of the way."""
WAY_TO_GOAL: Final = 1.3
"""The same where the way ends with the outline of a goal."""

RISING: Final = 0.03
"""Slope of the ground along x from which on one looks from behind."""


WIDE: Final = 0.95
"""Width of a picture over its height; in a narrower one the way is seen from farther off."""
PHONE: Final = 0.75
"""Where the picture is narrower than this, the controls lie over its lower half."""

SETTLED: Final = 1.0
"""After so long a page has said how wide it is, s."""


@dataclass(frozen=True)
class Camera:
    """Places of the camera and of what it looks at, world, (3,), m."""

    position: Array
    look_at: Array

    @cached_property
    def axes(self) -> Array:
        """Right, down and ahead of the picture, in the world, the rows of (3, 3)."""
        ahead = self.look_at - self.position
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(ahead, right), ahead])


def camera_of(clip: Clip) -> Camera:
    """The camera for a clip."""
    place = clip.samples.com_position
    if clip.kind == "scenario":  # nothing is planned yet: the way is from the start to the goals
        place = np.concatenate([place, [goal.pose[:3] for goal in clip.goals]])
    low, high = place.min(axis=0), place.max(axis=0)
    middle = 0.5 * (low + high)
    feet = clip.samples.foot_position[..., 2][clip.samples.contact]
    ground = 0.5 * (feet.min() + feet.max()) if feet.size else middle[2] - clip.robot.height
    middle[2] = ground + 0.35 * clip.robot.height
    way = WAY_TO_GOAL if clip.kind == "scenario" else WAY
    direction = FROM * [-1.0, 1.0, 1.0] if _rises(clip) else FROM
    size = clip.robot.height / 0.75 * 2.4 + way * float(np.linalg.norm(high - low))
    return Camera(middle + size * direction, middle)


def _rises(clip: Clip) -> bool:
    """Whether the ground rises along x: from ahead one would not see the risers."""
    feet = clip.samples.foot_position[clip.samples.contact]
    return bool(len(feet) and plane_of(feet)[2][0] > RISING)


def aim(server: viser.ViserServer, camera: Camera) -> None:
    """Sets the camera with which a browser begins."""
    begin = server.initial_camera
    begin.look_at, begin.position, begin.up = camera.look_at, camera.position, (0.0, 0.0, 1.0)
    begin.fov = float(FIELD_OF_VIEW)


def fit(server: viser.ViserServer, camera: Callable[[], Camera]) -> None:
    """Moves the camera of each browser that comes with a narrow picture: all is in sight there, too."""

    def come(client: viser.ClientHandle) -> None:  # in a thread of its own
        time.sleep(SETTLED)
        still_there = client.client_id in server.get_clients()
        if still_there and client.camera.aspect < WIDE:
            place(client, camera())

    server.on_client_connect(come)


def look_at(client: viser.ClientHandle, clip: Clip) -> None:
    """Moves the camera of a browser so that all of the way of a clip is in sight."""
    place(client, camera_of(clip))


def place(client: viser.ClientHandle, camera: Camera) -> None:
    """Moves the camera of a browser: farther off in a narrow picture, above the controls on a phone."""
    aspect = client.camera.aspect
    far = (camera.position - camera.look_at) * max(1.0, WIDE / aspect)
    down = 0.5 * np.tan(0.5 * FIELD_OF_VIEW) * np.linalg.norm(far) if aspect < PHONE else 0.0
    target = camera.look_at - [0.0, 0.0, down]
    with client.atomic(), contextlib.suppress(ValueError):  # a page may say that it looks nowhere
        client.camera.position = target + far
        client.camera.look_at = target
