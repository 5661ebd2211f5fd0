"""Each transcription converges at its order: a tumbling robot under fixed inputs against an integrator."""

import numpy as np
import pytest
from benchmarks.convergence import errors_at_the_end


@pytest.mark.parametrize(("name", "order"), [("collocation", 6), ("condensed", 2)])
def test_order_of_the_orientation(name: str, order: int) -> None:
    coarse, fine = (errors_at_the_end(name, intervals) for intervals in (8, 16))
    for error in ("orientation, rad", "ω, rad/s"):
        assert np.log2(coarse[error] / fine[error]) == pytest.approx(order, abs=0.3)
    assert fine["CoM, m"] < 1e-12, "a parabola in each interval: exact"


@pytest.mark.parametrize(("name", "order"), [("collocation", 6), ("condensed", 4)])
def test_order_of_the_contact_points(name: str, order: int) -> None:
    """The quadrature of the rolling velocity, by three and by two Gauss points."""
    coarse, fine = (errors_at_the_end(name, intervals)["feet, m"] for intervals in (2, 4))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.3)
