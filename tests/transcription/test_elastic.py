"""The elastic program: its derivatives, and that its slacks are what is missed."""

from __future__ import annotations

import numpy as np
import pytest

from rollgait.transcription import transcribe
from rollgait.transcription.elastic import START, ElasticNlp
from rollgait.transcription.nlp import BoundOrigin, RowOrigin
from tests.transcription.problems import about_the_guess, small_problem

STEP = 1e-5


def usual_miss(origin: RowOrigin) -> float | None:
    return None if origin.label.term == "dynamics" else 0.1


@pytest.fixture(scope="module")
def elastic() -> tuple[ElasticNlp, np.ndarray]:
    transcribed = transcribe("condensed", small_problem("steerable"))
    program = ElasticNlp(transcribed.nlp, usual_miss, cost_factor=0.5)
    return program, about_the_guess(transcribed, seed=0)


def test_derivatives_against_finite_differences(elastic: tuple[ElasticNlp, np.ndarray]) -> None:
    program, w = elastic
    x, p = program.start(w), program.parameters
    generator = np.random.default_rng(1)
    d, lam = generator.normal(size=x.size), generator.normal(size=program.rows)
    f = program.functions

    def gradient(at: np.ndarray) -> np.ndarray:
        return np.asarray(f["nlp_grad"](at, p, 1.0, lam)[2]).ravel()

    ahead, behind = x + STEP * d, x - STEP * d
    for name, slope in (("nlp_f", "nlp_grad_f"), ("nlp_g", "nlp_jac_g")):
        exact = np.asarray(f[slope](x, p)[1])
        exact = exact.ravel() @ d if name == "nlp_f" else exact @ d
        difference = np.asarray(f[name](ahead, p) - f[name](behind, p)).ravel() / (2 * STEP)
        np.testing.assert_allclose(exact, difference, rtol=1e-5, atol=1e-5 * np.abs(exact).max())
    upper = np.asarray(f["nlp_hess_l"](x, p, 1.0, lam))
    exact = (upper + np.triu(upper, 1).T) @ d
    difference = (gradient(ahead) - gradient(behind)) / (2 * STEP)
    np.testing.assert_allclose(exact, difference, atol=1e-5 * np.abs(exact).max())


def test_slacks_at_the_start_cover_what_is_missed(elastic: tuple[ElasticNlp, np.ndarray]) -> None:
    program, w = elastic
    x = program.start(w)
    g = np.asarray(program.functions["nlp_g"](x, program.parameters)).ravel()
    hard = [row for row, origin in enumerate(program.nlp.origins) if usual_miss(origin) is None]
    excess = program.violations(g, x)
    excess[hard] = 0.0
    assert excess.max() < 1e-9
    assert program.split(x)[1].min() >= START


def test_every_bound_knows_its_constraint() -> None:
    nlp = transcribe("condensed", small_problem("steerable")).nlp
    for bounds, origins in zip((nlp.lower, nlp.upper), nlp.bound_origins, strict=True):
        known = np.array([origin is not None for origin in origins])
        np.testing.assert_array_equal(np.isfinite(bounds), known)
    lower, upper = nlp.bound_origins
    both = [(a, b) for a, b in zip(lower, upper, strict=True) if a is not None and b is not None]
    assert all(isinstance(a, BoundOrigin) and a.slope > 0.0 for a, _ in both)
    speeds = [k for k, o in enumerate(upper) if o is not None and o.label.term == "stance_speed"]
    assert speeds
    np.testing.assert_allclose(nlp.upper[speeds] * [upper[k].slope for k in speeds], 1.0)
