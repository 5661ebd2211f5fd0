"""Headings for wheels whose paths are given: forwards or backwards, whichever takes less steering."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HALF_TURNS = np.pi * np.array([-1.0, 0.0, 1.0])
"""rad, between the headings with which a wheel can follow the same path."""
BEYOND = 0.1
"""s after which an excess over the steering range is as bad as steering by the same angle."""


def headings_along(
    along: Array, moving: NDArray[np.bool_], start: Array, limits: Array, step: float, reverse: bool = False
) -> Array:
    """Headings σ − θz over time, (n, legs), within their range.

    Args:
        along: directions of the paths relative to the base, rad, (n, legs).
        moving: where they mean anything.
        start: headings at the start, rad, (legs,).
        limits: lower and upper ends of the ranges, rad, (2, legs).
        step: time between the points, s.
        reverse: begin with the heading that is farther from the start.
    """
    folded = _held(np.mod(along + 0.5 * np.pi, np.pi) - 0.5 * np.pi, moving, start)
    choices = folded[:, None] + HALF_TURNS[:, None]
    excess = np.maximum(limits[0] - choices, 0.0) + np.maximum(choices - limits[1], 0.0)
    beyond = np.where(moving[:, None], excess**2, 0.0) * step / BEYOND
    first = (np.abs(choices[0] - start) - (np.pi if reverse else 0.0)) ** 2
    return np.clip(_least_steering(choices, beyond, first), *limits)


def rate_limited(path: Array, start: Array, most: float) -> Array:
    """A path (n, legs) followed from `start` with at most `most` from point to point."""
    result = np.empty_like(path)
    angle = start.copy()
    for k, wanted in enumerate(path):
        angle = angle + np.clip(wanted - angle, -most, most)
        result[k] = angle
    return result


def _held(values: Array, valid: NDArray[np.bool_], start: Array) -> Array:
    """Values with the last valid one, at first the start, where they are not valid."""
    number = np.where(valid, np.arange(1, len(values) + 1)[:, None], 0)
    last = np.maximum.accumulate(number, axis=0)
    return np.asarray(np.take_along_axis(np.vstack([start, values]), last, axis=0))


def _least_steering(choices: Array, cost: Array, first: Array) -> Array:
    """The choices (n, 3, legs) with the least sum of costs and squared changes, by dynamic programming."""
    total = first + cost[0]
    steering = (choices[1:, None] - choices[:-1, :, None]) ** 2
    came_from = np.empty(choices.shape, dtype=np.intp)
    for k, change in enumerate(steering, start=1):
        sums = total[:, None] + change
        came_from[k] = sums.argmin(axis=0)
        total = sums.min(axis=0) + cost[k]
    legs = np.arange(choices.shape[2])
    best = total.argmin(axis=0)
    result = np.empty((len(choices), legs.size))
    for k in range(len(choices) - 1, -1, -1):
        result[k] = choices[k, best, legs]
        best = came_from[k, best, legs] if k else best
    return result
