"""The library's motions over ground that is not flat: solved, certified, at the goal, at rest."""

from __future__ import annotations

import numpy as np
import pytest

import rollgait as rg
from tests.library import TERRAIN

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", TERRAIN)
def test_motion(name: str) -> None:
    plan = rg.plan(name)
    certificate = plan.certificate()
    assert certificate.passed, "\n".join(map(str, certificate.failures))
    end, goals = plan.sample(plan.horizon), plan.scenario.goal
    goal = goals.then[-1] if goals.then else goals
    assert np.hypot(*(end.com_position[:2] - [goal.x, goal.y])) <= 0.01
    np.testing.assert_allclose(end.com_velocity, 0.0, atol=1e-4)
    np.testing.assert_allclose(end.speed, 0.0, atol=1e-4)


def test_only_the_condensed_transcription_knows_ground_that_is_not_flat() -> None:
    with pytest.raises(
        rg.InputError, match=r"^transcription: .* flat ground only; on other ground: condensed"
    ):
        rg.plan("kerb", transcription="collocation")
