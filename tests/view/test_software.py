"""Pictures without a graphics card: also of scenes in which nothing is to be seen."""

import numpy as np
import pytest

from rollgait.view.backdrop import BACKGROUND
from rollgait.view.camera import Camera
from rollgait.view.shapes import ball
from rollgait.view.software import SoftwareScene, render


@pytest.mark.parametrize("place", [(-5.0, 0.0, 0.5), (5.0, 0.0, 0.5)], ids=["behind", "ahead"])
def test_what_is_behind_the_camera_is_not_drawn(place: tuple[float, float, float]) -> None:
    scene = SoftwareScene()
    vertices, faces = ball()
    scene.add_mesh_simple("/ball", vertices=vertices, faces=faces, color=(200, 30, 30), position=place)
    points = np.array([[place, (place[0], 0.3, 0.5)]])
    scene.add_line_segments("/line", points=points, colors=np.array([30, 30, 200]), thickness=0.01)
    camera = Camera(np.array([0.0, 0.0, 0.5]), np.array([1.0, 0.0, 0.5]))
    pixels = np.asarray(render(scene, camera, (64, 48)))
    assert (pixels != BACKGROUND).any() == (place[0] > 0.0)
