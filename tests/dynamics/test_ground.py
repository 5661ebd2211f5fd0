"""The ground under a foot: a quadratic and what a round foot does on it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.dynamics.ground import FootGround

Array = NDArray[np.float64]

RADIUS = 0.124
places = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)).map(np.array)
slopes = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
curvatures = st.tuples(*[st.floats(-2.0, 2.0)] * 3)
headings = st.floats(-3.0, 3.0)


def ground(slope: tuple[float, float], curvature: tuple[float, ...] = (0.0, 0.0, 0.0)) -> FootGround:
    return FootGround([0.3, -0.2, 0.1, *slope, *curvature], list(slope), RADIUS)


@given(slopes, curvatures, places)
def test_the_slope_is_the_derivative_of_the_height(
    slope: tuple[float, float], curvature: tuple[float, ...], p: Array
) -> None:
    own, h = ground(slope, curvature), 1e-5
    for axis in range(2):
        step = h * np.eye(2)[axis]
        change = (own.height(p + step) - own.height(p - step)) / (2.0 * h)
        assert own.slope(p)[axis] == pytest.approx(change, abs=1e-8)


@given(slopes)
def test_the_contact_is_on_the_wheel_and_its_normal_points_to_the_centre(slope: tuple[float, float]) -> None:
    own = ground(slope)
    to_centre = np.array([0.0, 0.0, RADIUS]) - np.array(own.contact_offset(np))
    np.testing.assert_allclose(to_centre, RADIUS * np.array(own.normal(np)), atol=1e-12)


@given(slopes, headings)
def test_the_rolling_frame_is_a_rotation_along_the_ground(slope: tuple[float, float], heading: float) -> None:
    own = ground(slope)
    frame = np.array(own.rolling_frame(np, heading))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    along = frame[0]
    assert np.arctan2(along[1], along[0]) == pytest.approx(np.arctan2(np.sin(heading), np.cos(heading)))
    assert along[2] == pytest.approx(np.dot(slope, along[:2]), abs=1e-12)
    assert own.way_factor(np, heading) == pytest.approx(1.0 / np.hypot(*along[:2]))


@given(headings)
def test_on_level_ground_nothing_is_beside_the_lowest_point(heading: float) -> None:
    own = ground((0.0, 0.0))
    np.testing.assert_allclose(own.contact_offset(np), 0.0)
    assert own.way_factor(np, heading) == 1.0
