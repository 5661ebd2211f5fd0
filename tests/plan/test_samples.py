"""What samples say of wheels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tests.plan.builders as b
from rollgait.plan.samples import way_factor, wheel_angle
from tests.plan.slopes import SLOPE, standing_on_slope

RADIUS = 0.1


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.0])
def test_wheels_turn_by_the_way_along_the_ground(heading: float) -> None:
    """R γ is the length of the way of a wheel that rolls over a plane, up, down or across it."""
    at = standing_on_slope().sample(np.linspace(0.0, 0.4, 9))  # all feet stand
    e, speed = np.array([np.cos(heading), np.sin(heading)]), np.linspace(0.0, 0.8, 9)
    way = 0.8 / 0.4 * at.time**2 / 2.0
    place = at.foot_position + (way[:, None] * np.append(e, SLOPE @ e))[:, None]
    rolled = replace(
        at,
        foot_position=place,
        heading=np.full((9, 4), heading),
        speed=np.tile(speed[:, None], (1, 4)),
    )
    angle = wheel_angle(rolled, [RADIUS] * 4)
    np.testing.assert_allclose(RADIUS * angle, np.linalg.norm(place - place[0], axis=-1), atol=1e-12)


def test_feet_without_wheels_do_not_turn_and_flat_ground_is_not_longer() -> None:
    at = b.driving().sample(np.linspace(0.0, 1.0, 11))
    assert (wheel_angle(at, [None, 0.1, None, 0.2])[:, [0, 2]] == 0.0).all()
    np.testing.assert_array_equal(way_factor(at), 1.0)
