"""Orders of steps: the base goes forwards through any of them, and strays as little as it can."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from rollgait.discover.crossings import Crossing
from rollgait.footing.footing import Array


def monotone(values: Sequence[float]) -> Array:
    """The rising sequence that is nearest to values (n,), in squares (isotonic regression)."""
    blocks: list[tuple[float, int]] = []
    for value in values:
        blocks.append((float(value), 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, m), (b, n) = blocks[-2:]
            blocks[-2:] = [((m * a + n * b) / (m + n), m + n)]
    return np.repeat([value for value, _ in blocks], [count for _, count in blocks])


def straying(crossings: Sequence[Crossing]) -> float:
    """By how much progress the base must stray from the middles of its steps to go only forwards."""
    middles = np.array([crossing.middle for crossing in crossings])
    return float(np.abs(monotone(list(middles)) - middles).max(initial=0.0))


def unevenness(crossings: Sequence[Crossing]) -> float:
    """By how much front feet get higher or lower than hind feet in the mean during these steps, m."""
    rises = np.array([0.5 * (c.rise if c.leg < 2 else -c.rise) for c in crossings])
    return float(np.abs(np.cumsum(rises)).max(initial=0.0))


def other_orders(crossings: Sequence[Crossing], near: float) -> Iterator[list[Crossing]]:
    """The same steps in other orders.

    Args:
        crossings: in the order of their middles.
        near: crossings whose middles differ by less may change places, in progress.
    """
    groups: list[list[Crossing]] = []
    for crossing in crossings:
        if groups and abs(crossing.middle - groups[-1][0].middle) <= near:
            groups[-1].append(crossing)
        else:
            groups.append([crossing])
    if any(len(group) > 1 for group in groups):
        yield [crossing for group in groups for crossing in reversed(group)]
    # a hind leg right after the other hind leg is the worst: a front leg between them where there is one
    apart = _hind_legs_apart(crossings)
    if apart is not None:
        yield apart


def _hind_legs_apart(crossings: Sequence[Crossing]) -> list[Crossing] | None:
    """Hind legs not one right after the other, as far as neighbours can change places; None if none can."""
    result = list(crossings)
    kinds = [(is_hind, len(list(run))) for is_hind, run in groupby(result, key=lambda c: c.leg >= 2)]
    if all(count < 2 for is_hind, count in kinds if is_hind):
        return None
    for k in range(1, len(result) - 1):
        pair = result[k - 1].leg >= 2 and result[k].leg >= 2
        if pair and result[k + 1].leg < 2:
            result[k], result[k + 1] = result[k + 1], result[k]
    return None if result == list(crossings) else result
