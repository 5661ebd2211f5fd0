"""Paths as pictures need them: with as few segments as will do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.samples import Array

TOLERANCE = 0.003
"""How far a drawn path may be from the true one, m: half of its thickness, and a tenth of the segments."""


def segments_of(line: Array) -> NDArray[np.intp]:
    """Frames at the ends of as few segments as follow a line (n, 3) within the tolerance, (m, 2)."""
    kept, open_spans = [0, len(line) - 1], [(0, len(line) - 1)]
    while open_spans:  # Ramer, Douglas and Peucker: split where the line is farthest from its chord
        a, b = open_spans.pop()
        if b - a < 2:
            continue
        chord, way = line[b] - line[a], line[a + 1 : b] - line[a]
        share = np.clip(way @ chord / max(float(chord @ chord), 1e-12), 0.0, 1.0)
        distance = np.linalg.norm(way - share[:, None] * chord, axis=1)
        if distance.max() > TOLERANCE:
            middle = a + 1 + int(distance.argmax())
            kept.append(middle)
            open_spans += [(a, middle), (middle, b)]
    frames = np.array(sorted(kept))
    moved = np.linalg.norm(np.diff(line[frames], axis=0), axis=1) > 0.0  # a foot that stands draws nothing
    ends: NDArray[np.intp] = np.column_stack([frames[:-1], frames[1:]])[moved]
    return ends
