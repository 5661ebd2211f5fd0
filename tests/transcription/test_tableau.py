"""Laws of the Gauss-Legendre schemes, and their order on problems with a known solution."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from rollgait.polynomials import lagrange
from rollgait.transcription.tableau import Tableau, gauss_legendre

Array = NDArray[np.float64]

COUNTS = (1, 2, 3, 4)


@pytest.fixture(params=COUNTS)
def scheme(request: pytest.FixtureRequest) -> Tableau:
    return gauss_legendre(request.param)


def test_points_lie_inside_and_symmetric(scheme: Tableau) -> None:
    assert np.all((scheme.points > 0.0) & (scheme.points < 1.0))
    np.testing.assert_allclose(scheme.points + scheme.points[::-1], 1.0, atol=1e-14)
    np.testing.assert_allclose(scheme.weights, scheme.weights[::-1], atol=1e-12)


def test_quadrature_is_exact_up_to_degree_2n_minus_1_and_no_further(scheme: Tableau) -> None:
    n = scheme.points.size
    errors = [abs(scheme.weights @ scheme.points**d - 1.0 / (d + 1)) for d in range(2 * n + 1)]
    assert max(errors[: 2 * n]) < 1e-12
    assert errors[2 * n] > 1e-8


def test_polynomials_of_degree_n_are_differentiated_and_continued_exactly(scheme: Tableau) -> None:
    n = scheme.points.size
    polynomial = np.random.default_rng(n).normal(size=n + 1)
    values, derived = np.polyval(polynomial, scheme.support), np.polyder(polynomial)
    np.testing.assert_allclose(scheme.slope @ values, np.polyval(derived, scheme.points), atol=1e-10)
    np.testing.assert_allclose(scheme.slope_begin @ values, np.polyval(derived, 0.0), atol=1e-10)
    np.testing.assert_allclose(scheme.slope_end @ values, np.polyval(derived, 1.0), atol=1e-10)
    np.testing.assert_allclose(scheme.end @ values, np.polyval(polynomial, 1.0), atol=1e-10)
    tau = np.linspace(-0.5, 1.5, 7)
    np.testing.assert_allclose(scheme.values_at(tau) @ values, np.polyval(polynomial, tau), atol=1e-9)


def test_lagrange_polynomials_are_1_at_their_own_support(scheme: Tableau) -> None:
    np.testing.assert_allclose(
        lagrange(scheme.support, scheme.support)[0], np.eye(scheme.support.size), atol=1e-12
    )


def integrated(scheme: Tableau, a: Array, x0: Array, steps: int) -> Array:
    """x(1) of ẋ = a x by collocation with `steps` intervals."""
    h, n, size = 1.0 / steps, scheme.points.size, x0.size
    x = x0
    for _ in range(steps):
        system = np.kron(scheme.slope[:, 1:], np.eye(size)) - h * np.kron(np.eye(n), a)
        inner = np.linalg.solve(system, -np.kron(scheme.slope[:, 0], x)).reshape(n, size)
        x = scheme.end[0] * x + scheme.end[1:] @ inner
    return x


def test_growth_ends_at_e() -> None:
    """ẋ = x: a collocation that evaluates the dynamics at the node instead of the point gives 2."""
    x = integrated(gauss_legendre(3), np.eye(1), np.ones(1), 1)
    assert x[0] == pytest.approx(np.e, abs=1e-3)


def test_order_at_the_nodes_is_2n(scheme: Tableau) -> None:
    """Order of ẋ = a x, whose solution turns: x(1) = (cos 3, sin 3)."""
    a, exact = np.array([[0.0, -3.0], [3.0, 0.0]]), np.array([np.cos(3.0), np.sin(3.0)])
    errors = [np.linalg.norm(integrated(scheme, a, np.array([1.0, 0.0]), n) - exact) for n in (4, 8, 16)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders[-1], 2 * scheme.points.size, atol=0.2)


@pytest.mark.parametrize(
    ("field", "message"), [("weights", "integrate polynomials"), ("slope", "slope 0"), ("end", "slope 0")]
)
def test_a_spoilt_scheme_is_refused(field: str, message: str) -> None:
    scheme = gauss_legendre(3)
    with pytest.raises(ValueError, match=message):
        replace(scheme, **{field: getattr(scheme, field) * 1.01 + 0.01})
