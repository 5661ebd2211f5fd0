"""Single changes of a scenario that may make it solvable, the mildest first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollgait.diagnosis.elastic import Finding, Missed
from rollgait.ocp.goal import GoalPlace, GoalYaw
from rollgait.plan.certificate.tolerances import GOAL_DISTANCE
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.gait import Schedule, SteppingGait
from rollgait.scenario.scenario import Goal, LaterGoal, Scenario
from rollgait.scenario.start import Start

MARGIN = 1.1
"""Part by which a limit is widened beyond what was missed."""
STRONGER = (1.0, 2.0, 4.0)
"""Multiples of what was missed that are tried in turn."""
LONGER = (1.25, 1.5, 2.0)
"""Multiples of the horizon that are tried in turn."""
FRICTIONS = (0.3, 0.5, 0.8)
"""Coefficients of friction that are tried in turn, if higher: wet, usual and good ground."""

Change = dict[str, Any]


@dataclass(frozen=True)
class Candidate:
    """One kind of change: its strengths in turn, the mildest first, and whether it only widens limits."""

    name: str
    variants: tuple[tuple[str, Change], ...]
    is_limit: bool = False


def candidates(scenario: Scenario, finding: Finding) -> Iterator[Candidate]:
    """Changes that bear on what is missed, those most likely to be accepted first."""
    makers: list[Callable[[Scenario, Finding], Iterator[tuple[str, Change]]]] = [
        _one_foot_at_a_time,
        _nearer_goal,
        _wider_limits,
        _longer,
        _fewer_steps,
        _lower_steps,
    ]
    for make in makers:
        variants = tuple(make(scenario, finding))
        if variants:
            yield Candidate(make.__name__.strip("_"), variants, make is _wider_limits)


def next_steps(scenario: Scenario, finding: Finding) -> Iterator[Candidate]:
    """Changes that may help a search that fails although nothing is in its way, or nothing else helps."""
    yield Candidate("finer", tuple(_finer(scenario)))
    yield Candidate("longer", tuple(_longer(scenario, finding))[:2])


# -- the goal ----------------------------------------------------------------------------------------------


def _nearer_goal(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    """The last goal moved towards the one before, by what it was missed by and some more."""
    misses = finding.goal_misses
    if not misses:
        return
    goals: list[Start | Goal | LaterGoal] = [scenario.start, scenario.goal, *scenario.goal.then]
    before, last = goals[-2], goals[-1]
    key = "goal" if len(goals) == 2 else f"goal.then.{len(goals) - 3}"
    place = np.array([last.x - before.x, last.y - before.y])
    turn = last.yaw_deg - before.yaw_deg
    distance = float(np.hypot(*place))
    miss = math.hypot(misses.get((GoalPlace.name, 0), 0.0), misses.get((GoalPlace.name, 1), 0.0))
    miss_yaw = math.degrees(misses.get((GoalYaw.name, 0), 0.0))
    for strength in STRONGER[:2]:
        change: Change = {}
        words = []
        if miss > 0.0 and distance > 0.0:
            part = 1.0 - strength * (MARGIN * miss + GOAL_DISTANCE) / distance
            if part <= 0.0:
                return
            change |= {
                f"{key}.{axis}": round(getattr(before, axis) + part * step, 3)
                for axis, step in zip("xy", place, strict=True)
                if step
            }
            words.append(f"{part * distance:.3g} m instead of {distance:.3g} m away")
        if miss_yaw > 0.0 and turn:
            part = 1.0 - strength * (MARGIN * miss_yaw + 1.0) / abs(turn)
            if part <= 0.0:
                return
            change[f"{key}.yaw_deg"] = round(before.yaw_deg + part * turn, 1)
            words.append(f"turned by {part * abs(turn):.3g} deg instead of {abs(turn):.3g} deg")
        if change:
            yield f"a goal nearer: {', '.join(words)}", change


# -- time and gait -----------------------------------------------------------------------------------------


def _longer(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    for factor in LONGER:
        horizon = _rounded_up(scenario.horizon * factor)
        change: Change = {"horizon": horizon}
        if isinstance(scenario.gait, Schedule):
            stretch = horizon / scenario.horizon
            change |= {
                f"gait.{leg}": [[round(stretch * t, 4) for t in swing] for swing in swings]
                for leg, swings in scenario.gait.swings(horizon).items()
                if swings
            }
        yield f"a longer horizon: {horizon:g} s instead of {scenario.horizon:g} s", change


def _finer(scenario: Scenario) -> Iterator[tuple[str, Change]]:
    half = float(f"{0.5 * scenario.interval:.3g}")
    yield f"a finer mesh: intervals of {half:g} s instead of {scenario.interval:g} s", {"interval": half}


def _fewer_steps(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    gait = scenario.gait
    if isinstance(gait, SteppingGait) and gait.steps > len(gait.groups):
        steps = max(len(gait.groups), gait.steps // 2)
        yield f"a slower gait: {steps} steps instead of {gait.steps}", {"gait.steps": steps}


def _lower_steps(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    clearance = scenario.clearance
    if any(True for _ in scenario.schedule.swings()):
        half = round(0.5 * clearance, 3)
        yield f"lower steps: {half:g} m instead of {clearance:g} m", {"gait.clearance": half}


def _one_foot_at_a_time(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    """Swings of a schedule that overlap, put one after the other in the time that they had together."""
    if not isinstance(scenario.gait, Schedule):
        return
    swings = sorted(
        (begin, end, leg) for leg, own in scenario.gait.swings(scenario.horizon).items() for begin, end in own
    )
    clusters: list[list[tuple[float, float, str]]] = []
    for swing in swings:
        if clusters and swing[0] < max(end for _, end, _ in clusters[-1]):
            clusters[-1].append(swing)
        else:
            clusters.append([swing])
    if all(len(cluster) == 1 for cluster in clusters):
        return
    result: dict[str, list[list[float]]] = {leg: [] for leg in LEG_NAMES}
    for number, cluster in enumerate(clusters):
        begin = cluster[0][0]
        end = clusters[number + 1][0][0] if number + 1 < len(clusters) else scenario.horizon
        shortest = min(b - a for a, b, _ in cluster)
        slot = (end - begin) / len(cluster)
        for place, (_, _, leg) in enumerate(cluster):
            first = begin + place * slot
            result[leg].append([round(first, 4), round(first + min(shortest, 0.8 * slot), 4)])
    change = {f"gait.{leg}": swings for leg, swings in result.items() if swings}
    yield "one foot in the air at a time", change


# -- limits ------------------------------------------------------------------------------------------------


def _wider_limits(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    """The limit of the one term that is missed, wider by what was missed."""
    terms = {item.origin.label.term for item in finding.missed}
    if len(terms) != 1:
        return
    (term,) = terms
    own = next((known for known in finding.problem.constraints if known.name == term), None)
    if (maker := _LIMITS.get(term)) is not None:
        yield from maker(scenario, finding)
    elif own is not None and own.bound is not None:
        yield from _of_bound(*own.bound, own.unit, scenario, finding)
    elif term not in scenario.bounds.without and not (own is not None and own.keeps):
        yield f"without the constraint {term}", {"bounds.without": [*scenario.bounds.without, term]}


def _worst(finding: Finding) -> float:
    return max(item.excess for item in finding.missed)


def _of_bound(
    name: str, words: str, unit: str, scenario: Scenario, finding: Finding
) -> Iterator[tuple[str, Change]]:
    """Makes a bound larger; as far as the robot's own limit, which may be smaller."""
    own = scenario.value_of("bounds", name)
    most = min((getattr(leg, name, np.inf) for leg in scenario.body.leg_list), default=np.inf)
    for strength in STRONGER:
        value = min(most, _rounded_up(own + strength * MARGIN * _worst(finding)))
        if value > own:
            yield f"{words}: {value:g} {unit} instead of {own:g} {unit}", {f"bounds.{name}": value}


def _friction(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    mu = scenario.ground.friction
    values = [value for value in FRICTIONS if value > mu] or [2.0 * mu]
    if finding.motion is not None:
        needed = _needed_friction(finding)
        if mu < needed < values[-1]:
            values = [_rounded_up(MARGIN * needed), *(value for value in values if value > MARGIN * needed)]
    for value in values[:3]:
        yield f"more friction: μ = {value:g} instead of {mu:g}", {"ground.friction": value}


def _needed_friction(finding: Finding) -> float:
    """The largest ratio of tangential to normal force of the elastic motion, where friction is missed."""
    assert finding.motion is not None
    middles = finding.problem.schedule.mesh.middles
    ratio = 0.0
    for item in finding.missed:
        k, leg = item.origin.interval, item.origin.label.leg
        force = finding.motion.sample(middles[k : k + 1], finding.problem.robot).force[0, leg]
        ratio = max(ratio, float(np.hypot(*force[:2])) / max(float(force[2]), 1e-9))
    return ratio


def _force(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    worst = _worst(finding)
    low = scenario.value_of("bounds", "force_min") or 0.0
    most = min(leg.force_max for leg in scenario.body.leg_list)
    high = scenario.value_of("bounds", "force_max")
    if high is not None and high < most:
        for strength in STRONGER:
            value = min(most, _rounded_up(high + strength * MARGIN * worst))
            yield f"larger forces: {value:g} N instead of {high:g} N", {"bounds.force_max": value}
    elif low > 0.0:
        value = max(0.0, math.floor(low - MARGIN * worst))
        yield f"smaller forces: {value:g} N instead of {low:g} N", {"bounds.force_min": value}


def _box(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    box = np.abs(scenario.body.foot_boxes(scenario.bounds.box)).max(axis=(0, 1))
    wider = np.zeros(3)
    for item in finding.missed:
        component = item.origin.label.component
        wider[component] = max(wider[component], item.excess)
    for strength in STRONGER:
        value = [math.ceil(1e3 * b - 1e-6) / 1e3 for b in box + strength * MARGIN * wider]
        text = f"a larger box: {_vector(value)} m instead of {_vector(box)} m"
        yield text, {"bounds.box": value}


def _acceleration(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    """Limits of feet on the ground and of feet that swing or just landed, each by what it was missed by."""
    schedule = finding.problem.schedule
    contact, h = schedule.contact, schedule.mesh.between_middles
    worst: dict[str, float] = {}
    for item in finding.missed:
        leg, k = item.origin.label.leg, item.origin.interval
        stays = leg is not None and contact[leg, k] and (k == 0 or contact[leg, k - 1])
        name = "acceleration_max" if stays else "swing_acceleration_max"
        worst[name] = max(worst.get(name, 0.0), item.excess / float(h[k]))
    for strength in STRONGER:
        change: Change = {}
        words = []
        for name, excess in worst.items():
            own = scenario.value_of("bounds", name)
            value = _rounded_up(own + strength * MARGIN * excess)
            change[f"bounds.{name}"] = value
            words.append(f"{value:g} m/s² instead of {own:g} m/s²")
        yield f"larger accelerations: {', '.join(words)}", change


def _joint_margin(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    margin = scenario.value_of("bounds", "joint_margin_deg") or 0.0
    value = math.floor(10.0 * (margin - MARGIN * math.degrees(_worst(finding)))) / 10.0
    if 0.0 <= value < margin:
        text = f"a smaller margin of the joints: {value:g} deg instead of {margin:g} deg"
        yield text, {"bounds.joint_margin_deg": value}


def _support_margin(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    """A smaller distance from the edges of the support, of CoM or capture point; negative is outside."""
    (name,) = {item.origin.label.term for item in finding.missed}
    own = scenario.value_of("bounds", name)
    what = "CoM" if name == "com_margin" else "capture point"
    for strength in STRONGER:
        value = math.floor(1e3 * (own - strength * MARGIN * _worst(finding))) / 1e3
        text = f"a smaller margin of the {what} in swings: {value:g} m instead of {own:g} m"
        yield text, {f"bounds.{name}": value}


def _body_clearance(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    """A smaller distance of body and legs from the ground, but not in it."""
    own = scenario.value_of("bounds", "body_clearance")
    value = math.floor(1e3 * (own - MARGIN * _worst(finding))) / 1e3
    if 0.0 <= value < own:
        text = f"less room between body and ground: {value:g} m instead of {own:g} m"
        yield text, {"bounds.body_clearance": value}


def _level(scenario: Scenario, finding: Finding) -> Iterator[tuple[str, Change]]:
    yield "an end that need not be level", {"bounds.level_at_end": False}


_LIMITS: Mapping[str, Callable[[Scenario, Finding], Iterator[tuple[str, Change]]]] = {
    "acceleration": _acceleration,
    "body_clearance": _body_clearance,
    "box": _box,
    "capture_margin": _support_margin,
    "com_margin": _support_margin,
    "force_limits": _force,
    "friction": _friction,
    "joint_steering": _joint_margin,
    "level_at_end": _level,
}


def _rounded_up(value: float) -> float:
    """The next larger number of two digits."""
    if value <= 0.0:
        return value
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / step - 1e-9) * step:.6g}")


def _vector(values: Any) -> str:
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"


__all__ = ["Candidate", "Missed", "candidates", "next_steps"]
