"""A bridge in real time: reports, garbage, and an end that lays the robot down."""

from __future__ import annotations

import gc
import itertools
from collections.abc import Callable
from typing import Final

from rollgait.hardware.bridge import Bridge
from rollgait.hardware.reports import Reports
from rollgait.mpc.loop import no_collections
from rollgait.mpc.prediction import Event

COLLECT_EVERY: Final = 50
"""Periods between two collections of young garbage."""
LYING_WITHIN: Final = 60.0
"""A robot that does not lie by then is left as it stands, s."""

Stop = Callable[[], bool]
Hear = Callable[[Event], None]


def run(bridge: Bridge, reports: Reports, stop: Stop, hear: Hear) -> None:
    """Runs a bridge until it shall stop; then the robot lies down, or stays as it stands if it cannot.

    Args:
        bridge: the bridge.
        reports: what it says of itself.
        stop: whether it shall end.
        hear: what happened, as it happens.
    """
    told: Event | None = None
    ends: float | None = None
    with no_collections():
        for number in itertools.count(1):
            bridge.step()
            reports.after(bridge)
            for event in _since(bridge, told):
                told = event
                hear(event)
            if number % COLLECT_EVERY == 0:
                gc.collect(0)  # what is young is little, and takes a fraction of a millisecond
            if ends is None and stop():
                bridge.end()
                ends = bridge.plant.time + LYING_WITHIN
            if ends is not None and (bridge.phase in ("off", "stopped") or bridge.plant.time > ends):
                break


def _since(bridge: Bridge, told: Event | None) -> list[Event]:
    """What happened after an event, oldest first."""
    found: list[Event] = []
    for event in reversed(bridge.events):
        if event is told:
            break
        found.append(event)
    return found[::-1]
