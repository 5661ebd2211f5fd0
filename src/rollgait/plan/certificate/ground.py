"""Do wheels stand on the ground, neither in it nor over it, and away from edges? Ground that is not flat."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.contacts import ahead
from rollgait.plan.certificate.physics import Array
from rollgait.plan.certificate.rows import Row, measured
from rollgait.plan.certificate.wheels import edge_distance, rim_clearance

LOOKED_AT: Final = (0, 3, 5, 6, 8, 11)
"""Samples of an interval at which rims are looked at: 3 cm apart at 1 m/s in 0.1 s."""
ENDS: Final = (0, -1)
"""Those at which footholds are: an edge is straight for longer than a wheel rolls in an interval."""


def check_ground(case: Case) -> Iterator[Row]:
    """Depth and gap of wheels, footholds against edges, and what the plan says of its contacts."""
    terrain, contacts, motion = case.terrain, case.contacts, case.motion
    if terrain is None or contacts is None:
        return
    on_ground = case.has("stance_height")
    clearance = _rims(case)
    time = motion.time[:, LOOKED_AT]
    misplaced = tol.KINK * contacts.bend
    gap = np.where(np.isnan(contacts.gap), np.inf, contacts.gap)
    yield from measured(
        "stance_depth",
        "depth of the rims of standing wheels in the ground, more than from a misplaced kink",
        "m",
        np.maximum(-clearance - misplaced[:, LOOKED_AT], 0.0),
        tol.HEIGHT,
        time,
        where=motion.in_stance,
        promised=on_ground,
    )
    yield from measured(
        "stance_gap",
        "distance of standing wheels from the ground, more than from a misplaced kink",
        "m",
        np.maximum(gap - misplaced, 0.0),
        tol.HEIGHT,
        motion.time,
        where=motion.in_stance,
        promised=on_ground,
    )
    yield from measured(
        "swing_ground",
        "depth of the rims of wheels in swing in the ground",
        "m",
        np.maximum(-clearance, 0.0),
        tol.SWING_DEPTH,
        time,
        where=~motion.in_stance,
        promised=case.has("ground"),
    )
    yield from measured(
        "contact_place",
        "contacts that the plan states, from where the ground is touched",
        "m",
        contacts.stated_apart,
        tol.CONTACT,
        motion.time,
    )
    distance, known = _footholds(case)
    distance = case.eased_places(distance, tol.EDGE, tol.BEYOND)
    nodes = motion.time[:, ENDS]
    yield from measured(
        "edge_distance",
        "distance of standing feet from edges (as far as it is looked for)",
        "m",
        distance,
        tol.EDGE,
        nodes,
        where=motion.in_stance,
        at_least=True,
        promised=case.has("foothold"),
    )
    yield from measured(
        "unknown_ground",
        "feet that stand where nobody knows the ground (1: there are some)",
        "",
        (~known).astype(float),
        0.0,
        nodes,
        where=motion.in_stance,
        promised=case.has("foothold"),
    )


def _rims(case: Case) -> Array:
    """Clearance of the rims at the samples that are looked at, (N, k, 4), m."""
    assert case.terrain is not None
    at = case.motion.at
    lowest = at.foot_position[:, LOOKED_AT]
    heading = np.broadcast_to(at.heading[:, LOOKED_AT], lowest.shape[:-1])
    radius = np.broadcast_to(case.radius, lowest.shape[:-1])
    found = rim_clearance(case.terrain, lowest.reshape(-1, 3), heading.ravel(), radius.ravel())
    return found.reshape(lowest.shape[:-1])


def _footholds(case: Case) -> tuple[Array, NDArray[np.bool_]]:
    """Distance of standing feet from edges, m, and whether the ground is known there, (N, 2, 4)."""
    assert case.terrain is not None
    assert case.contacts is not None
    motion = case.motion
    lowest = motion.at.foot_position[:, ENDS]
    shape = lowest.shape[:-1]
    stands = np.broadcast_to(motion.in_stance, shape)
    radius = np.broadcast_to(case.radius, shape)
    direction = ahead(case.robot, motion)[:, ENDS]
    parts = (lowest, case.contacts.position[:, ENDS], direction[..., None], radius[..., None])
    asked = np.concatenate([part[stands] for part in parts], axis=-1)
    places, which = np.unique(np.round(asked, 9), axis=0, return_inverse=True)  # many feet stand still
    found, seen = edge_distance(case.terrain, places[:, :3], places[:, 3:6], places[:, 6], places[:, 7])
    distance, known = np.full(shape, np.inf), np.ones(shape, dtype=bool)
    distance[stands], known[stands] = found[which.ravel()], seen[which.ravel()]
    return distance, known
