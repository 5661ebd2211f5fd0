"""What is left of a plan from some time on: its scenario, and its motion to start a new plan from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.errors import InputError
from rollgait.plan.samples import Samples
from rollgait.plant.moving import MotionState
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.moving import begun_at
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]

LEAST: Final = 0.2
"""s; what is left of a plan for less is not worth another one."""
FIRST_SHARES: Final = (0.2, 0.8)
"""A first interval shorter than the first part of the next is one with it, where no contact changes between;
one shorter than the second shares evenly with it: if much shorter than others, it may keep a solver from
converging, and one of nearly two lengths has too much between its nodes."""
AT_ONCE: Final = 0.02
"""A contact that changes in less has changed, s: intervals are no shorter."""
DELAY_MAX: Final = 5.0
"""s; who waits longer begins anew."""
LANDED_SHARE: Final = 0.6
"""From this share of a swing on, a foot that is measured on the ground has landed."""
SAME: Final = 1e-9
"""s; two times nearer than this are one."""


class Planned(Protocol):
    """A plan, as far as its rest asks."""

    @property
    def scenario(self) -> Scenario:
        """What was asked."""

    @property
    def schedule(self) -> ContactSchedule:
        """Which foot is on the ground when."""

    @property
    def horizon(self) -> float:
        """T, s."""

    def sample(self, time: ArrayLike) -> Samples:
        """The motion at one or more times."""


@dataclass(frozen=True, eq=False)
class Rest:
    """What is left of a plan, as it is to be planned anew.

    Attributes:
        plan: the plan.
        time: from when on, s of the plan.
        delay: by how much later than planned it goes on, s.
        scenario: the rest as a scenario of its own, from t = 0: the plan's contacts, nodes, goals, loads.
        changes: what of the measured state was changed to make it a start.
    """

    plan: Planned
    time: float
    delay: float
    scenario: Scenario
    changes: tuple[str, ...] = ()

    def started(self, state: RobotState) -> Rest:
        """The same from another state. Raises `InputError` if it cannot begin there."""
        return rest_of(self.plan, self.time, state, self.delay)

    @property
    def motion(self) -> Callable[[Array], Samples]:
        """The motion of the plan by the time of the rest."""

        def motion(times: Array) -> Samples:
            known = np.clip(np.maximum(times - self.delay, 0.0) + self.time, 0.0, self.plan.horizon)
            return replace(self.plan.sample(known), time=times)

        return motion


def state_at(plan: Planned, time: float) -> MotionState:
    """The state of a plan at a time; see `Plan.state_at`."""
    at = plan.sample(float(time))
    heading = at.heading
    return MotionState(
        time=float(time),
        com_position=at.com_position,
        euler=at.euler,
        com_velocity=at.com_velocity,
        euler_rate=at.euler_rate,
        foot_position=at.foot_position,
        heading=heading,
        speed=at.speed,
        foot_velocity=at.foot_velocity,
        force=at.force,
        contact=at.contact,
    )


def rest_of(plan: Planned, time: float, state: RobotState | None = None, delay: float = 0.0) -> Rest:
    """What is left of a plan; see `Plan.rest`."""
    if not 0.0 <= time <= plan.horizon - LEAST:
        rule = f"must lie in [0, {plan.horizon - LEAST:.6g}] s, so that something of the plan is left"
        raise InputError("time", time, rule)
    if not 0.0 <= delay <= DELAY_MAX:
        raise InputError("delay", delay, f"must lie in [0, {DELAY_MAX:g}] s")
    given = state_at(plan, time) if state is None else state
    nodes = _nodes(plan, time)
    swings = _swings(plan, time, nodes, given)
    if delay > 0.0:
        in_air = [name for name, own in swings.items() if own and own[0][0] < 0.0]
        if in_air:
            raise InputError("delay", delay, f"must be 0 while a foot is in the air: {in_air[0]}")
        before = np.linspace(0.0, delay, 1 + max(1, round(delay / plan.scenario.interval)))
        nodes = np.concatenate([before, nodes[1:] + delay])
        swings = {name: [[lift + delay, down + delay] for lift, down in own] for name, own in swings.items()}
    standing = _scenario(plan, time - delay, nodes, swings, time)
    scenario, changes = begun_at(standing, given)
    return Rest(plan, time, delay, scenario, changes)


def _nodes(plan: Planned, time: float) -> Array:
    """Nodes of the rest, by its own time, (M + 1,), s: the plan's, but for a first one that is too near."""
    all_nodes, changes = plan.schedule.node_times, np.append(plan.schedule.changes, True)
    later = np.flatnonzero(all_nodes > time + SAME)
    nodes, contacts_change = all_nodes[later] - time, changes[later]
    if len(nodes) > 1:
        one_with_it, shares = np.array(FIRST_SHARES) * (nodes[1] - nodes[0])
        if nodes[0] < (AT_ONCE if contacts_change[0] else max(AT_ONCE, one_with_it)):
            nodes = nodes[1:]
        elif nodes[0] < shares and not contacts_change[0]:
            nodes[0] = 0.5 * nodes[1]
    return np.concatenate([[0.0], nodes])


def _swings(plan: Planned, time: float, nodes: Array, state: RobotState) -> dict[str, list[list[float]]]:
    """Swings of the rest by leg: (lift-off, touch-down), s; a lift-off before 0 has been."""
    result: dict[str, list[list[float]]] = {name: [] for name in LEG_NAMES}
    times = plan.schedule.node_times
    touches = state.contact if isinstance(state, MotionState) else np.ones(len(LEG_NAMES), dtype=bool)
    for swing in plan.schedule.swings():
        lift_off = float(times[swing.lift_off]) - time - swing.begun
        touch_down = float(times[swing.touch_down]) - time
        if touch_down < nodes[1] - SAME:
            continue  # it is over, or as good as that
        if abs(lift_off) < SAME:
            lift_off = 0.0
        passed = -lift_off / (touch_down - lift_off)
        if passed > LANDED_SHARE and touches[swing.leg]:
            continue
        if 0.0 < lift_off < nodes[1] - SAME:
            lift_off = 0.0
        result[LEG_NAMES[swing.leg]].append([lift_off, touch_down])
    return result


def _scenario(
    plan: Planned, origin: float, nodes: Array, swings: dict[str, list[list[float]]], time: float
) -> Scenario:
    """The plan's scenario by a time of its own, with its contacts and nodes spelled out.

    Args:
        plan: the plan.
        origin: what is 0 in the rest, s of the plan; before `time` where the rest is put off.
        nodes, swings: by the time of the rest.
        time: of the plan where the rest begins, s; it stands there until it is told its start.
    """
    old = plan.scenario
    horizon = float(nodes[-1])
    data: dict[str, Any] = old.to_dict()
    gait = {name: data["gait"][name] for name in ("wheels", "clearance", "clearance_over")}
    data["gait"] = {"kind": "schedule", **gait, **swings, "nodes": nodes.tolist()}
    data["horizon"] = horizon
    goals = [{"at": 0.0, **{key: data["goal"][key] for key in ("x", "y", "yaw_deg")}}, *data["goal"]["then"]]
    now = max(k for k, goal in enumerate(goals) if k == 0 or goal["at"] <= origin + SAME)
    first = {key: value for key, value in goals[now].items() if key != "at"}
    then = [{**goal, "at": goal["at"] - origin} for goal in goals[now + 1 :] if goal["at"] - origin < horizon]
    data["goal"] = {**first, "then": then}
    data["loads"]["wrench"] = [
        {
            **wrench.model_dump(mode="json"),
            "start": max(0.0, wrench.start - origin),
            "end": None if wrench.end is None else wrench.end - origin,
        }
        for wrench in old.wrenches
        if wrench.end is None or wrench.end > origin + SAME
    ]
    # the place is checked with the state: until then it stands where the plan does
    data["start"] = {"motion": _as_motion(plan, time)}
    data["description"] = f"the rest of a plan, from {time:g} s on"
    scenario = Scenario.model_validate(data)
    return scenario.model_copy(update={"ground": old.ground})


def _as_motion(plan: Planned, time: float) -> dict[str, Any]:
    at = plan.sample(time)
    return {
        "com_position": at.com_position.tolist(),
        "euler": at.euler.tolist(),
        "foot_position": at.foot_position.tolist(),
        "heading": at.heading.tolist(),
    }
