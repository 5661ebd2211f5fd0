"""A plan as tables that the controller looks up in every step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.plant.state import RobotState
from rollgait.robot.robot import Robot
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

STEP: Final = 0.005
"""Between rows of the table, s; linear in between: on the sharpest lift of the library 0.05 mm off."""

HOVER: Final = 0.005
"""A foot that is to stand where it lands is over that place while it is so high above it, m: joints give way
by 3 mm, and a foot that meets the ground while it still goes on slips, or is left behind."""
HURRY: Final = 1.25
"""By this factor it goes faster than planned to get there in time, at most: 1.7 makes legs and body swing."""
BRAKING: Final = 0.1
"""In so long it comes to rest there, s: an interval of most plans, by which speeds of theirs change, too."""

_ROUND_OFF: Final = 1e-9


@dataclass(frozen=True, eq=False)
class PlanSwing:
    """A swing of a plan: leg 0 … 3, lift-off and touch-down in s of the plan, where it lands, (3,), m.

    One that has begun before the plan has a lift-off before 0.
    """

    leg: int
    lift_off: float
    touch_down: float
    foothold: Array


@dataclass(frozen=True, eq=False)
class Row:
    """What a plan has at n times: first axis n; world frame, SI units."""

    com_position: Array
    euler: Array
    com_velocity: Array
    euler_rate: Array
    foot_position: Array
    lift_rate: Array
    heading: Array
    speed: Array

    def slowed(self, rate: Array) -> Row:
        """The same at shares of the plan's own speed, (n,)."""
        moving = {name: getattr(self, name) for name in _MOTION}
        return replace(
            self,
            **{name: rate.reshape(-1, *[1] * (part.ndim - 1)) * part for name, part in moving.items()},
        )

    @property
    def pose(self) -> tuple[float, float, float]:
        """x, y (m) and yaw (rad) at the first time."""
        x, y, _ = self.com_position[0].tolist()
        return (x, y, float(self.euler[0, 0]))

    @property
    def twist(self) -> tuple[float, float, float]:
        """Forward and lateral velocity (m/s, base-yaw frame) and yaw rate (rad/s) at the first time."""
        c, s = np.cos(self.euler[0, 0]), np.sin(self.euler[0, 0])
        vx, vy, _ = self.com_velocity[0]
        return (float(c * vx + s * vy), float(c * vy - s * vx), float(self.euler_rate[0, 0]))


_COLUMNS: Final = {
    "com_position": (3,),
    "euler": (3,),
    "com_velocity": (3,),
    "euler_rate": (3,),
    "foot_position": (4, 3),
    "lift_rate": (4,),
    "heading": (4,),
    "speed": (4,),
}
_MOTION: Final = ("com_velocity", "euler_rate", "lift_rate", "speed")


class PlanPath:
    """A plan by its own time s: 0 at its beginning.

    Feet that stand where they land are led ahead of the plan over the ground once they sink, not in height:
    they come down where they land, and pass each place on their way higher up than planned.

    Args:
        plan: the plan.

    Attributes:
        robot: the plan's.
        terrain: its ground; None if that is flat.
        length: T, s.
        locked: whether wheels on the ground stand still.
        swings: in the order of their lift-offs.
    """

    def __init__(self, plan: Plan) -> None:
        self.robot: Robot = plan.robot
        ground = plan.scenario.terrain
        self.terrain: Terrain | None = None if ground.is_flat else ground
        self.length = plan.horizon
        self.locked = plan.scenario.gait.wheels == "locked"
        count = max(2, 1 + round(self.length / STEP))
        self._step = self.length / (count - 1)
        samples = plan.sample(np.linspace(0.0, self.length, count))
        parts = {name: getattr(samples, name) for name in _COLUMNS if name != "lift_rate"}
        parts["lift_rate"] = samples.foot_velocity[..., 2]
        parts["speed"] = _motion(plan.robot, samples)[..., 0]
        borders = plan.schedule.node_times
        middle = plan.sample(0.5 * (borders[1:] + borders[:-1]))
        force, motion = middle.force * middle.contact[..., None], _motion(plan.robot, middle)
        inputs = np.hstack([force.reshape(-1, 12), motion.reshape(-1, 8)])
        done = np.vstack([np.zeros(20), np.cumsum(inputs * np.diff(borders)[:, None], axis=0)])
        self.swings = sorted(_swings(plan), key=lambda swing: swing.lift_off)
        times = np.union1d(samples.time, borders)
        done = np.column_stack([np.interp(times, borders, column) for column in done.T])
        for swing in self.swings:
            if plan.robot.leg_list[swing.leg].foot == "point":
                _lead(plan, swing, parts, times, done)
        self._table = np.hstack([parts[name].reshape(count, -1) for name in _COLUMNS])
        self._borders, self._done = times, done

    def turn(self, angle: float) -> None:
        """Adds whole turns, rad, to yaw and headings: those of a robot go on beyond 2π."""
        place = 0
        for name, shape in _COLUMNS.items():
            size = int(np.prod(shape))
            if name == "euler":
                self._table[:, place] += angle
            elif name == "heading":
                self._table[:, place : place + size] += angle
            place += size

    def at(self, times: Array) -> Row:
        """The plan at times (n,), s; at rest before its beginning and after its end."""
        place = np.clip(times / self._step, 0.0, len(self._table) - 1.0)
        index = np.minimum(place.astype(np.intp), len(self._table) - 2)
        share = (place - index)[:, None]
        rows = self._table[index] + share * (self._table[index + 1] - self._table[index])
        parts, begin = {}, 0
        for name, shape in _COLUMNS.items():
            size = int(np.prod(shape))
            parts[name] = rows[:, begin : begin + size].reshape(-1, *shape)
            begin += size
        rests = (times < 0.0) | (times > self.length)
        for name in _MOTION:
            parts[name] = np.where(rests.reshape(-1, *[1] * (parts[name].ndim - 1)), 0.0, parts[name])
        return Row(**parts)

    def state(self, time: float) -> RobotState:
        """The robot as it is planned at a time, s, said to be that of time 0."""
        row = self.at(np.array([time]))
        return RobotState(
            time=0.0,
            com_position=row.com_position[0],
            euler=row.euler[0],
            com_velocity=row.com_velocity[0],
            euler_rate=row.euler_rate[0],
            foot_position=row.foot_position[0],
            heading=row.heading[0],
            speed=row.speed[0],
        )

    def foot_height(self, leg: int, times: Array) -> tuple[Array, Array]:
        """z of a foot and its rate at times (n,) of a swing, m and m/s."""
        row = self.at(times)
        return row.foot_position[:, leg, 2], row.lift_rate[:, leg]

    def means(self, edges: Array) -> tuple[Array, Array]:
        """Mean forces and motions between times (N + 1,), (N, 4, 3), N, and (N, 4, 2); see `Control`.

        Beyond the ends of the plan the forces are those of standing, and nothing moves.
        """
        known = np.clip(edges, 0.0, self.length)
        k = np.clip(np.searchsorted(self._borders, known, side="right") - 1, 0, len(self._borders) - 2)
        share = (known - self._borders[k]) / (self._borders[k + 1] - self._borders[k])
        total = np.diff(self._done[k] + share[:, None] * (self._done[k + 1] - self._done[k]), axis=0)
        force, length = total[:, :12].reshape(-1, 4, 3), np.diff(edges)
        for end, beyond in ((0.0, np.minimum(edges, 0.0)), (self.length, np.maximum(edges, self.length))):
            standing = np.diff(beyond)
            if standing.max() > _ROUND_OFF:
                force += standing[:, None, None] * self.static_force(end)
        length = np.maximum(length, _ROUND_OFF)[:, None, None]
        return np.asarray(force / length), np.asarray(total[:, 12:].reshape(-1, 4, 2) / length)

    def static_force(self, time: float) -> Array:
        """Forces of a robot that stands on all feet as it is at a time, (4, 3), N."""
        row = self.at(np.array([time]))
        force = np.zeros((4, 3))
        force[:, 2] = self.robot.static_forces(row.foot_position[0] - row.com_position[0])
        return force


def _swings(plan: Plan) -> list[PlanSwing]:
    result, times = [], plan.schedule.node_times
    for swing in plan.schedule.swings():
        begin, end = float(times[swing.lift_off]), float(times[swing.touch_down])
        place = plan.sample(end).foot_position[swing.leg]
        result.append(PlanSwing(swing.leg, begin - swing.begun, end, place))
    return result


def _lead(plan: Plan, swing: PlanSwing, parts: dict[str, Array], times: Array, done: Array) -> None:
    """Leads a foot ahead of the plan over the ground: on level ground all the way, else once it sinks.

    Args:
        plan: the plan.
        swing: of the foot.
        parts: columns of the table, by name, which change.
        times: of the rows of `done`, s.
        done: integrals of forces and motions, (len(times), 20), which change.
    """
    leg, end = swing.leg, swing.touch_down
    grid = np.linspace(0.0, plan.horizon, len(parts["heading"]))
    inside = np.flatnonzero((grid > swing.lift_off) & (grid < end))
    z = parts["foot_position"][inside, leg, 2]
    if end <= 0.0 or inside.size == 0:
        return
    begin = max(swing.lift_off, 0.0)
    if not plan.scenario.terrain.is_flat:
        begin = max(begin, float(grid[inside[len(z) - 1 - int(np.argmax(z[::-1]))]]))
    high = float(grid[inside[z - swing.foothold[2] > HOVER]].max(initial=begin))
    way = end - begin
    soonest = begin + way / HURRY + 0.5 * BRAKING
    if soonest > end:
        return
    arrival = max(high, soonest)
    rate = way / (arrival - begin - 0.5 * BRAKING)

    def ahead(at: Array) -> tuple[Array, Array]:
        """Times of the plan whose places the foot has then, and how fast they pass."""
        left = np.clip(arrival - at, 0.0, BRAKING)
        braked = BRAKING - left
        passed = np.minimum(at, arrival - BRAKING) - begin + braked - 0.5 * braked**2 / BRAKING
        return begin + rate * passed, rate * left / BRAKING

    rows = inside[grid[inside] > begin]
    to, pace = ahead(grid[rows])
    there = plan.sample(to)
    parts["foot_position"][rows, leg, :2] = there.foot_position[:, leg, :2]
    parts["speed"][rows, leg] = pace * _motion(plan.robot, there)[:, leg, 0]
    rows = np.flatnonzero((times > begin) & (times < end))
    to, _ = ahead(times[rows])
    for column in (12 + 2 * leg, 13 + 2 * leg):
        done[rows, column] = np.interp(to, times, done[:, column].copy())


def _motion(robot: Robot, samples: Samples) -> Array:
    """Planar inputs of the feet, (n, 4, 2): (v, σ̇), of fixed wheels along and across, of points x and y."""
    result = np.stack([samples.speed, samples.heading_rate], axis=-1)
    for i, leg in enumerate(robot.leg_list):
        velocity = samples.foot_velocity[:, i, :2]
        if leg.foot == "point":
            result[:, i] = velocity
        elif leg.foot == "fixed":
            c, s = np.cos(samples.heading[:, i]), np.sin(samples.heading[:, i])
            result[:, i, 1] = c * velocity[:, 1] - s * velocity[:, 0]
    return result
