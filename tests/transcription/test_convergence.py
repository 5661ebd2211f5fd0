"""Each transcription converges at its order: a tumbling robot under fixed inputs against an integrator."""

from collections.abc import Callable

import numpy as np
import pytest
from benchmarks.convergence import HORIZON, errors_at_the_end

from rollgait.scenario import Mesh


def even(count: int) -> Mesh:
    return Mesh.equal(HORIZON, count)


def uneven(count: int) -> Mesh:
    """Each interval shorter than the one before, the first three times as long as the last."""
    lengths = np.linspace(1.5, 0.5, count)
    return Mesh(HORIZON * lengths / lengths.sum())


def halved(mesh: Mesh) -> Mesh:
    return mesh.refined(np.arange(mesh.intervals))


@pytest.mark.parametrize("mesh", [even, uneven])
@pytest.mark.parametrize(("name", "order"), [("collocation", 6), ("condensed", 2)])
def test_order_of_the_orientation(name: str, order: int, mesh: Callable[[int], Mesh]) -> None:
    coarse, fine = (errors_at_the_end(name, m) for m in (mesh(8), halved(mesh(8))))
    for error in ("orientation, rad", "ω, rad/s"):
        assert np.log2(coarse[error] / fine[error]) == pytest.approx(order, abs=0.3)
    assert fine["CoM, m"] < 1e-12, "a parabola in each interval: exact"


@pytest.mark.parametrize("mesh", [even, uneven])
@pytest.mark.parametrize(("name", "order"), [("collocation", 6), ("condensed", 4)])
def test_order_of_the_contact_points(name: str, order: int, mesh: Callable[[int], Mesh]) -> None:
    """The quadrature of the rolling velocity, by three and by two Gauss points."""
    coarse, fine = (errors_at_the_end(name, m)["feet, m"] for m in (mesh(2), halved(mesh(2))))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.3)
