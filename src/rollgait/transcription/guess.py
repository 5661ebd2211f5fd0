"""The kinematic initial guess: a motion that does what is asked but for the physics.

The base follows minimum-jerk paths from goal to goal, the feet keep their nominal places below it
(stepping where they cannot roll), wheels point along their feet's paths, forwards or backwards and
no faster than they can steer, and the forces are those of standing on the feet that are down.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.foot import planar_inputs
from rollgait.footing.pace import driving_time
from rollgait.footing.skidding import skid_route
from rollgait.footing.stepping import stepping_route
from rollgait.ocp.lift import minimum_jerk
from rollgait.ocp.problem import Problem
from rollgait.plan.samples import Samples, level_contact
from rollgait.robot.robot import GRAVITY, Robot
from rollgait.transcription.headings import headings_along, rate_limited
from rollgait.transcription.sliding import sliding_forces

Array = NDArray[np.float64]
MotionGuess = Callable[[Array], Samples]
"""A motion as a function of time: (n,) in s to samples."""

STILL = 1e-3
"""m/s below which a foot's velocity says nothing about its heading."""
GRID = 4
"""Points per interval in the mean, of the even grid on which headings are found."""


def kinematic_guess(problem: Problem, reverse: bool = False, detour: Array | None = None) -> MotionGuess:
    """The guess as a function of time.

    Args:
        problem: what is asked.
        reverse: whether the wheels begin backwards where they would forwards, as far as they can be steered.
        detour: how far the base strays in (x, y, yaw) half-way, m and rad; not at all if not given.
    """
    return _Guess(problem, reverse, np.zeros(3) if detour is None else detour)


@dataclass
class _Guess:
    problem: Problem
    reverse: bool
    detour: Array

    def __post_init__(self) -> None:
        schedule = self.problem.schedule
        self.grid = np.linspace(0.0, schedule.horizon, GRID * schedule.intervals + 1)
        route, poses = None, None
        if self.problem.skids:
            poses = skid_route(self.problem.scenario, self.grid)
        elif (route := self._route()) is not None:
            poses = _interpolate(self.grid, *route[:2])
        self.by_route = poses is not None
        if poses is None:
            self.base, self.base_rate = self._base_path(self.grid)
        else:
            self.base = self._base_along(self.grid, poses)
            self.base_rate = np.gradient(self.base, self.grid, axis=0)
            self.base_rate[[0, -1]] = 0.0  # it begins and ends at rest
        if route is None:
            self.foot = np.stack([self._nominal(leg, self.base) for leg in range(4)], axis=1)
        else:
            self.foot = _interpolate(self.grid, route[0], route[2])
        self.foot_rate = np.gradient(self.foot, self.grid, axis=0)
        self.heading = self._heading_paths()
        self.heading_rate = np.gradient(self.heading, self.grid, axis=0)

    def _route(self) -> tuple[Array, Array, Array] | None:
        """Times, poses of the base (n, 3), places of the feet (n, 4, 2) where they do not just follow."""
        problem, terrain = self.problem, self.problem.terrain
        if terrain is not None:
            return terrain.route.times, terrain.route.base, terrain.route.feet
        kinds = [leg.foot for leg in problem.robot.leg_list]
        swings = np.asarray(~problem.schedule.contact.all(axis=1))
        if not any(kind == "point" or (kind == "fixed" and swings[leg]) for leg, kind in enumerate(kinds)):
            return None
        return problem.schedule.node_times, *stepping_route(problem.scenario, problem.schedule)

    # -- base --------------------------------------------------------------------------------------------

    def _base_path(self, times: Array) -> tuple[Array, Array]:
        """(r, θ) and its rate at times, each (n, 6): minimum jerk to each goal in its span of time."""
        scenario = self.problem.scenario
        switches = [later.at for later in scenario.goal.then if 0.0 < later.at < scenario.horizon]
        ends = [*switches, self.problem.schedule.horizon]
        poses = [self.problem.start.base, *scenario.goal_at(np.array([0.0, *switches]))]
        pose, rate = np.tile(poses[0], (times.size, 1)), np.zeros((times.size, 6))
        begin = 0.0
        for k, end in enumerate(ends):
            change = poses[k + 1] - poses[k]
            duration = driving_time(scenario, change[[0, 1, 3]], end - begin)
            # the cost looks ahead: half-way when the goal switches
            first = 0.0 if k == 0 else begin - 0.5 * duration
            value, slope = minimum_jerk((times - max(first, 0.0)) / duration)
            pose += value[:, None] * change
            rate += slope[:, None] * change / duration
            begin = end
        phase = np.pi * times / ends[-1]
        aside = [0, 1, 3]
        pose[:, aside] += np.sin(phase)[:, None] ** 2 * self.detour
        rate[:, aside] += (np.sin(2.0 * phase) * np.pi / ends[-1])[:, None] * self.detour
        return pose, rate

    def _base_along(self, times: Array, pose: Array) -> Array:
        """(r, θ) at times, (n, 6), of poses x, y, yaw: as high and tilted as the ground asks for."""
        nodes = self.problem.schedule.node_times
        ground, pitch, roll = (np.interp(times, nodes, column) for column in self.problem.footing.base.T)
        x, y, yaw = pose.T
        z = ground + self.problem.robot.height
        phase = np.sin(np.pi * times / nodes[-1]) ** 2
        aside = self.detour[:, None] * phase
        return np.stack([x + aside[0], y + aside[1], z, yaw + aside[2], pitch, roll], axis=-1)

    def _nominal(self, leg: int, pose: Array) -> Array:
        """Nominal contact point below base poses (n, 6), in the plane: (n, 2)."""
        p = self.problem.robot.stance[leg]
        c, s = np.cos(pose[:, 3]), np.sin(pose[:, 3])
        return np.asarray(pose[:, :2] + np.stack([c * p[0] - s * p[1], s * p[0] + c * p[1]], axis=-1))

    # -- feet --------------------------------------------------------------------------------------------

    def _heading_paths(self) -> Array:
        """σ on the grid, (n, 4): along the feet's paths, in their range, no faster than they can steer."""
        problem, yaw = self.problem, self.base[:, 3]
        legs = problem.robot.leg_list
        result = np.zeros((yaw.size, 4))
        fixed = [i for i, leg in enumerate(legs) if leg.foot == "fixed"]
        result[:, fixed] = yaw[:, None] + [legs[i].heading for i in fixed]
        steered = [i for i, leg in enumerate(legs) if leg.foot == "steerable"]
        if not steered:
            return result
        vx, vy = np.moveaxis(self.foot_rate[:, steered], 2, 0)
        moving = np.hypot(vx, vy) > STILL
        start = problem.start.heading[steered] - problem.start.base[3]
        limits = np.array([problem.scenario.steering_range(i) for i in steered]).T
        step = self.grid[1] - self.grid[0]
        along = np.arctan2(vy, vx) - yaw[:, None]
        wanted = headings_along(along, moving, start, limits, step, self.reverse)
        most = problem.scenario.value_of("bounds", "steering_rate_max") * step
        result[:, steered] = yaw[:, None] + rate_limited(wanted, start, most)
        return result

    # -- samples -----------------------------------------------------------------------------------------

    def __call__(self, times: Array) -> Samples:
        problem = self.problem
        if not self.by_route:
            base, base_rate = self._base_path(times)
        else:
            base, base_rate = _cubics(times, self.grid, self.base, self.base_rate)
        xy, xy_rate = (
            _interpolate(times, self.grid, self.foot),
            _interpolate(times, self.grid, self.foot_rate),
        )
        heading = _interpolate(times, self.grid, self.heading)
        interval = problem.schedule.mesh.interval_at(times)
        height, height_rate = self._heights(times, interval, xy, xy_rate)
        contact = problem.schedule.contact[:, interval].T
        along = xy_rate[:, :, 0] * np.cos(heading) + xy_rate[:, :, 1] * np.sin(heading)
        rolls = np.array([leg.foot != "point" for leg in problem.robot.leg_list])
        steers = np.array([leg.foot == "steerable" for leg in problem.robot.leg_list])
        speed = np.where(rolls, along, 0.0)
        foot = np.concatenate([xy, height[..., None]], axis=-1)
        feet = xy
        if problem.skids:  # forces along the ground tilt a body unless the normal ones are nearer to them
            acceleration = _interpolate(times, self.grid, np.gradient(self.base_rate, self.grid, axis=0))
            feet = xy + (problem.robot.height / GRAVITY) * acceleration[:, None, :2]
        force = self._static_forces(base, feet, contact)
        if problem.skids:
            lever = xy - base[:, None, :2]
            force += sliding_forces(problem, interval, force[..., 2], lever, heading, xy_rate, acceleration)
        return Samples(
            time=times,
            com_position=base[:, :3],
            euler=base[:, 3:],
            com_velocity=base_rate[:, :3],
            euler_rate=base_rate[:, 3:],
            foot_position=foot,
            foot_velocity=np.concatenate([xy_rate, height_rate[..., None]], axis=-1),
            heading=heading,
            heading_rate=np.where(steers, _interpolate(times, self.grid, self.heading_rate), 0.0),
            speed=speed,
            force=force,
            contact=contact,
            **level_contact(foot),
        )

    def _heights(
        self, times: Array, interval: NDArray[np.intp], xy: Array, rate: Array
    ) -> tuple[Array, Array]:
        """Heights of the feet in the world and their rates, each (n, 4)."""
        problem, footing = self.problem, self.problem.footing
        lifts, lift_rates = problem.lift_at(times)
        z = footing.height(interval, xy) + lifts
        z_rate = footing.climb(interval, xy, rate) + lift_rates
        nodes = problem.schedule.node_times
        for swing in footing.swings:
            if not swing.over:
                continue
            begin, end = nodes[[swing.lift_off, swing.touch_down]]
            inside = (times > begin) & (times < end)
            middle = 0.5 * (begin + end)
            below = np.where(times[inside] < middle, swing.before, swing.after)
            z[inside, swing.leg] = below + lifts[inside, swing.leg]
            z_rate[inside, swing.leg] = lift_rates[inside, swing.leg]
        return z, z_rate

    def _static_forces(self, base: Array, xy: Array, contact: NDArray[np.bool_]) -> Array:
        """Forces of standing still on the feet that are down, (n, 4, 3), none pulling."""
        robot = self.problem.robot
        force = np.zeros((len(base), 4, 3))
        patterns, which = np.unique(contact, axis=0, return_inverse=True)
        for number, down in enumerate(patterns):
            here = np.flatnonzero(which.ravel() == number)
            relative = xy[np.ix_(here, np.flatnonzero(down))] - base[here, None, :2]
            normal = np.maximum(robot.static_forces(relative), 0.02 * robot.weight)
            shares = normal / normal.sum(axis=1, keepdims=True)
            force[here[:, None], np.flatnonzero(down), 2] = shares * robot.weight
        return force


def motion_inputs(robot: Robot, s: Samples) -> Array:
    """The planar inputs (n, 4, 2) of sampled feet: the inverse of `feet_in_world`."""
    result = np.empty((len(s.time), 4, 2))
    for i, leg in enumerate(robot.leg_list):
        velocity = s.foot_velocity[:, i, :2].T
        inputs = planar_inputs(np, leg.foot, velocity, s.heading[:, i], s.heading_rate[:, i], s.speed[:, i])
        result[:, i] = np.stack(inputs, axis=-1)
    return result


def _cubics(times: Array, grid: Array, values: Array, rates: Array) -> tuple[Array, Array]:
    """Cubic polynomials between values (n, k) with these rates: values and rates at times, (m, k)."""
    k = np.clip(np.searchsorted(grid, times, side="right") - 1, 0, grid.size - 2)
    h = (grid[k + 1] - grid[k])[:, None]
    s = (times - grid[k])[:, None] / h
    chord, begin, end = (values[k + 1] - values[k]) / h, rates[k], rates[k + 1]
    bend, twist = 3.0 * chord - 2.0 * begin - end, begin + end - 2.0 * chord
    value = values[k] + h * s * (begin + s * (bend + s * twist))
    return value, begin + s * (2.0 * bend + 3.0 * s * twist)


def _interpolate(times: Array, grid: Array, values: Array) -> Array:
    """Linear interpolation along the first axis."""
    flat = values.reshape(grid.size, -1)
    result = np.stack([np.interp(times, grid, column) for column in flat.T], axis=-1)
    return result.reshape(times.size, *values.shape[1:])
