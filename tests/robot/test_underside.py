"""What of a robot must not touch the ground: spheres about legs, and what the library says of its robots."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.robot.library import find_robot
from rollgait.robot.urdf_model import load_model
from rollgait.robot.urdf_stance import nominal_stance
from rollgait.robot.urdf_underside import PIECES, WITH_BASE, _spheres, find_underside
from rollgait.robot.whole_body import library_whole_body

ROUND = 1e-3
"""m; the library's data are written to 1 mm."""


@pytest.mark.parametrize("name", ["centauro", "rover", "strider"])
def test_the_library_says_what_import_finds(name: str) -> None:
    model = load_model(library_whole_body(name))
    found, own = find_underside(model, nominal_stance(model)), find_robot(name).underside
    assert len(found.belly) == len(own.belly)
    assert [sphere.leg for sphere in found.limbs] == [sphere.leg for sphere in own.limbs]
    for here, there in zip(found.limbs, own.limbs, strict=True):
        assert np.allclose(here.centre, there.centre, atol=2.0 * ROUND)
        assert here.radius == pytest.approx(there.radius, abs=2.0 * ROUND)
        assert here.with_base == pytest.approx(there.with_base, abs=0.02)
        assert here.with_base >= WITH_BASE


@settings(max_examples=20)
@given(length=st.floats(0.3, 1.0), radius=st.floats(0.02, 0.1), seed=st.integers(0, 1000))
def test_spheres_about_a_rod_have_its_radius_and_stand_along_it(
    length: float, radius: float, seed: int
) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    t, a = np.meshgrid(np.linspace(-0.5, 0.5, 31) * length, angle)
    rod = np.column_stack([t.ravel(), radius * np.cos(a).ravel(), radius * np.sin(a).ravel()])
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    shift = rng.uniform(-1.0, 1.0, 3)
    spheres = _spheres(rod @ Q.T + shift)
    assert 1 <= len(spheres) <= PIECES
    for centre, size in spheres:
        assert size == pytest.approx(radius, rel=1e-6)
        own = (centre - shift) @ Q
        assert np.allclose(own[1:], 0.0, atol=1e-9)
        assert abs(own[0]) < 0.5 * length
