"""Bounds that a start in motion does not keep: they begin where the start is and come back.

A measured robot may be a little outside its box. Its first state is what it is, so that a bound on it could
only be a contradiction. What the start is beyond a limit is added to that limit at first, and less and less
of it until `GRACE` is over. A bound on where a foot stands comes back when the foot leaves its place.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Place
from rollgait.transcription.stage import RowLabel, Stage

Array = NDArray[np.float64]

GRACE: Final = 0.5
"""s, in which a robot comes back within its bounds."""
BEYOND_MAX: Final = {"m": 0.05, "rad": 0.1, "m²": 0.06}
"""Farthest beyond a limit that a start may be, by unit (squares of lengths of a leg: 5 cm of 0.6 m); what is
farther contradicts the problem."""
OF_PLACES: Final = frozenset({"foothold"})
"""Bounds of where feet stand, which stay where they are."""
NEVER: Final = frozenset({"ground"})
"""Bounds beyond which no robot is: nothing goes through the ground."""
OF_SUPPORT: Final = frozenset({"com_margin", "capture_margin"})
"""Bounds against the feet that stand: with other feet they are others."""
_ROUND_OFF: Final = 1e-9


def eased(stage: Stage, first_node: Array, problem: Problem) -> Stage:
    """The stage of the intervals with limits that the first node keeps.

    Args:
        stage: its local variables begin with the node.
        first_node: values of the first node, (n,).
        problem: whose start and contacts.
    """
    beyond = _beyond(stage, first_node)
    if not beyond:
        return stage
    lower, upper = stage.lower.copy(), stage.upper.copy()
    times, contact = problem.schedule.node_times, problem.schedule.contact
    same = np.logical_and.accumulate(contact == contact[:, :1], axis=1)
    for row, label in enumerate(stage.labels):
        below, above = beyond.get(_name(label), (0.0, 0.0))
        if below == 0.0 and above == 0.0:
            continue
        at = times[1:] if label.place == Place.INTERVAL_END.name else times[:-1]
        share = np.maximum(0.0, 1.0 - at / GRACE)
        if label.term in OF_PLACES and label.leg is not None:
            stays = same[label.leg].copy()
            if contact[label.leg, 0] and label.place == Place.NODE.name:
                stays[1:] |= same[label.leg, :-1]  # where it lifts off it still is where it stood
            share = stays.astype(float)
        elif label.term in OF_SUPPORT:
            share = np.where(same.all(axis=0), share, 0.0)
        lower[row] -= below * share
        upper[row] += above * share
    return replace(stage, lower=lower, upper=upper)


def _beyond(stage: Stage, first_node: Array) -> dict[tuple[str, int | None, int], tuple[float, float]]:
    """How far the start is below and above the limits of rows that depend on the first node alone."""
    code = stage.code
    size = first_node.size
    y = np.zeros(code.value.size1_in(0))
    y[:size] = first_node
    value = np.asarray(code.value(y, stage.parameters[:, 0])[1]).ravel()
    of_node = np.ones(code.rows, dtype=bool)
    of_node[code.jacobian_rows[code.jacobian_cols >= size]] = False
    result = {}
    for row, label in enumerate(stage.labels):
        low, high = stage.lower[row, 0], stage.upper[row, 0]
        counts = label.place == Place.NODE.name and of_node[row] and stage.holds[row, 0]
        if not counts or low == high or label.term in NEVER:
            continue
        below, above = max(0.0, low - value[row]), max(0.0, value[row] - high)
        if _ROUND_OFF < max(below, above) <= BEYOND_MAX.get(label.unit, 0.0):
            # a hair more, so that rounding contradicts nothing
            result[_name(label)] = (below and below + _ROUND_OFF, above and above + _ROUND_OFF)
    return result


def _name(label: RowLabel) -> tuple[str, int | None, int]:
    return label.term, label.leg, label.component
