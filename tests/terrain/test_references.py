"""What the ground asks of the base: with all of the slope it would stand parallel to the ground."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from rollgait.dynamics.rotations import R_world_base
from rollgait.terrain.references import TILT_SHARE, base_reference
from tests.expressions import value
from tests.terrain.worlds import rounded

FEET = np.array([[0.4, 0.3], [0.4, -0.3], [-0.4, 0.3], [-0.4, -0.3]])


@given(rounded(-0.5, 0.5), rounded(-3.0, 3.0), rounded(-1.0, 1.0))
def test_the_base_leans_as_the_ground_does(slope: float, yaw: float, height: float) -> None:
    c, s = np.cos(yaw), np.sin(yaw)
    feet = FEET @ np.array([[c, s], [-s, c]])
    forward = np.array([c, s])
    up = base_reference(np.column_stack([feet, height + slope * feet @ forward]), yaw, share=1.0)
    assert up.ground == pytest.approx(height)
    axes = value(R_world_base(np.array([yaw, up.pitch, up.roll])))
    assert axes[2, 0] / np.hypot(*axes[:2, 0]) == pytest.approx(slope)  # x of the base along the slope
    assert up.roll == pytest.approx(0.0, abs=1e-12)
    left = base_reference(np.column_stack([feet, height + slope * feet @ [-s, c]]), yaw, share=1.0)
    axes = value(R_world_base(np.array([yaw, left.pitch, left.roll])))
    assert axes[2, 1] / np.hypot(*axes[:2, 1]) == pytest.approx(slope)
    assert left.pitch == pytest.approx(0.0, abs=1e-12)


def test_the_base_takes_a_part_of_the_slope() -> None:
    feet = np.column_stack([FEET, 0.3 * FEET[:, 0]])
    assert base_reference(feet, 0.0).pitch == pytest.approx(-TILT_SHARE * np.arctan(0.3))


def test_one_foot_on_a_step_leans_the_base_a_little() -> None:
    feet = np.column_stack([FEET, [0.2, 0.0, 0.0, 0.0]])
    reference = base_reference(feet, 0.0)
    assert reference.ground == pytest.approx(0.05)
    assert reference.pitch < 0.0 < reference.roll
