"""Puts the numbers of one step of the controller in their places: nothing is built, only filled in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import POINTS, rotations
from rollgait.dynamics.wrench import wrench_numbers
from rollgait.errors import InputError
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.context import LiveContext
from rollgait.mpc.footwork import Footwork
from rollgait.mpc.ground.level import LevelGround
from rollgait.mpc.reference import Reference
from rollgait.mpc.settings import MpcBounds, MpcSettings, MpcWeights
from rollgait.ocp.live import OPEN, WORKSPACE
from rollgait.ocp.support import CORNERS, corners_of
from rollgait.ocp.term import Cost
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import Robot
from rollgait.scenario.profile import FORCE_OF_WEIGHT, PROFILES
from rollgait.transcription.live import LiveProblem, LiveStage

if TYPE_CHECKING:
    from rollgait.mpc.ground.terrain import AlongHorizon, TerrainGround
    from rollgait.mpc.plans.wanted import Wanted

Array = NDArray[np.float64]

FORCE_ROOM: Final = 0.02
"""Smallest range of a force, in weights of the robot: an interior-point method needs room."""
CENTRING_RATE: Final = 1.0
"""Share of the way per second at which the stance changes with the gait."""
OVER_FEET: Final = 0.5
"""On a slope the CoM is wanted so far of the way from along the axis of the tilted base to upright over the
middle of the feet: upright is what carries best, along the axis where legs reach best."""
POINT_SPEED: Final = 2.0
"""Factor on the bound of a swing's speed for point feet: they stand still while wheels roll on, and go the
way of a whole cycle in one swing."""
POINT_ACCELERATION: Final = 3.0
"""The same for its acceleration."""
LIMITED: Final = ("friction", "force", "first_motion", "second_motion", "acceleration")
"""Rows of an interval whose limits are filled in."""
SMALL_MOMENT: Final = 1e-4
"""m²: lets two feet share the weight that cannot balance it about their line."""
_WEIGHT_ALONE: Final = np.array([[1.0], [0.0], [0.0]])
"""Force and moments to be balanced, in weights of the robot and m."""


def turned_plane(places: Array, yaw: Array) -> Array:
    """Places (m, 2) turned by each of n angles, (n, m, 2)."""
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    x, y = places.T
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


class Filling:
    """Knows where each number of the problem belongs.

    Args:
        problem: whose numbers.
        settings: of the controller.
        context: what terms ask.
        ground: under the feet; a `TerrainGround` for a problem on terrain.
        own: costs of the user's, whose numbers they say themselves, in each step.

    Attributes:
        steers: which feet turn in stance: the others' second motion, a speed to the side, is one of swing.
        rolls: which feet move in stance.
    """

    def __init__(
        self,
        problem: LiveProblem,
        settings: MpcSettings,
        context: LiveContext,
        ground: LevelGround | TerrainGround,
        own: Sequence[Cost] = (),
    ) -> None:
        self._problem, self._settings = problem, settings
        self.context, self._own = context, tuple(own)
        self.count, self.interval = settings.intervals, settings.horizon / settings.intervals
        self.ground = ground
        nlp = problem.nlp
        self._steps = self.interval * np.arange(self.count + 1, dtype=float)
        row_number = nlp.row_numbers(nlp.blocks[0])
        self._row_numbers = {name: row_number[problem.interval.rows(name)] for name in LIMITED}
        self._stages = (problem.interval, problem.end)
        legs = problem.robot.leg_list
        self._force_max = np.array([leg.force_max for leg in legs])
        self.steers: NDArray[np.bool_] = np.array([leg.foot == "steerable" for leg in legs])
        self.rolls: NDArray[np.bool_] = np.array([leg.foot != "point" for leg in legs])
        self.robot = problem.robot
        self.stance: Array = self.robot.stance
        self._centred = 0.0
        self._strides = False
        self._ahead: Array = np.zeros((2, 4, self.count + 1))
        self.set_weights(settings.weights)
        for stage in self._stages:
            stage.numbers("interval")[:] = self.interval
        self.set_bounds(settings.bounds)

    # -- what seldom changes -----------------------------------------------------------------------------

    def set_robot(self, robot: Robot) -> None:
        """Mass, inertia, stance and limbs of a robot with the same feet."""
        self.robot = robot
        self.context.robot = robot
        self._feet = Footwork(robot)
        upper = np.triu_indices(3)
        for stage in self._stages:
            self._all(stage, "inertia", robot.inertia_matrix[upper])
            self._all(stage, "inertia_inverse", np.linalg.inv(robot.inertia_matrix)[upper])
            self._all(stage, "mass", [robot.mass])
            self._all(stage, "weight", [robot.weight])
            self._all(stage, "heading_offset", [leg.heading for leg in robot.leg_list])
            stage.put_terms(WORKSPACE, self.context)
        self._write_stance()

    def set_weights(self, weights: MpcWeights) -> None:
        """Weights of the costs."""
        values = weights.model_dump() | {term.name: weights.workspace for term in WORKSPACE}
        for name, value in values.items():
            for stage in self._stages:
                if stage.has(f"{name}_weight"):
                    stage.numbers(f"{name}_weight")[:] = value
        self._problem.end.numbers("factor")[:] = weights.terminal

    def set_bounds(self, bounds: MpcBounds) -> None:
        """Bounds of inputs and states."""
        legs = self._problem.robot.leg_list
        largest = min(leg.force_max for leg in legs)
        fitting = min(PROFILES["executable"]["bounds"]["force_min"], FORCE_OF_WEIGHT * self.robot.weight)
        force_min = fitting if bounds.force_min is None else bounds.force_min
        fair = self.robot.weight / len(legs)
        if force_min >= min(largest, fair):  # a solver given limits that cross may never return
            what = "force_max" if largest <= fair else "what each foot carries"
            rule = f"must be less than {what}, {min(largest, fair):.4g} N"
            raise InputError("bounds.force_min", force_min, rule)
        self._force_min = force_min
        self.bounds = bounds
        self._speed = np.array([min(bounds.speed_max, leg.speed_max) for leg in legs])
        self._swing_speed = np.where(self.rolls, 1.0, POINT_SPEED) * bounds.swing_speed_max
        self.swing_acceleration: Array = (
            np.where(self.rolls, 1.0, POINT_ACCELERATION) * bounds.swing_acceleration_max
        )
        self.speed_limit: Array = np.maximum(self._speed, self._swing_speed)
        rates = [min(bounds.steering_rate_max, leg.steering_rate_max) for leg in legs]
        second = np.where(self.steers, rates, self._swing_speed)
        self.second_limit: Array = second
        self._put_limits("second_motion", -second[:, None], second[:, None])
        self._problem.interval.numbers("mu")[:] = bounds.friction
        for stage in self._stages:
            stage.numbers("support_margin")[:] = bounds.com_margin

    def _all(self, stage: LiveStage, name: str, values: object) -> None:
        stage.numbers(name)[:] = np.asarray(values, dtype=float)[:, None]

    # -- what changes in every step ----------------------------------------------------------------------

    def put_state(self, first_node: Array) -> None:
        """The state from which the motion starts, as a node vector."""
        self._problem.nlp.fixed_values[: first_node.size] = first_node

    def put_wrenches(self, wrenches: Sequence[Wrench], time: float) -> None:
        """What pulls at the base along the horizon; only for a problem that knows of any."""
        edges: Array = time + self._steps
        numbers = wrench_numbers(wrenches, self.robot.com_offset, edges[:-1], edges[1:])
        self._problem.interval.numbers("wrench")[:] = numbers

    def put_contact(self, clock: GaitClock, time: float) -> None:
        """Which foot stands when, from now on, and how high the others are."""
        h, count = self.interval, self.count
        edges: Array = time + self._steps
        share = clock.stance_share(edges).T
        # what is done now must not count on feet that are still in the air
        share[:, 0] *= clock.contact(time)
        stands = share > 0.0
        locked = edges[:-1] >= clock.locked_from
        stage, bounds = self._problem.interval, self.bounds
        stage.numbers("stands")[:] = stands
        if self._own:
            self.context.contact = stands
        moves = [
            np.where(locked | ~may_in_stance[:, None], 1.0 - share, 1.0)
            for may_in_stance in (self.rolls, self.steers)
        ]
        stage.numbers("moves")[:] = np.stack(moves, axis=1).reshape(-1, count)
        self._put_lift(clock, edges)
        weight = self.robot.weight
        low = np.where(stands, share * self._force_min / weight, -OPEN)
        high = np.where(stands, np.maximum(share * self._force_max[:, None] / weight, FORCE_ROOM), OPEN)
        self._put_limits("force", low, high)
        self.stands = stands
        self.share, self.force_low, self.force_high = share, low, high
        self._put_support(stands)
        self._put_limits("friction", np.repeat(np.where(stands, 0.0, -OPEN), 4, axis=0), np.inf)
        speed = np.where(stands, self._speed[:, None], self._swing_speed[:, None])
        self._put_limits("first_motion", -speed, speed)
        rate_max = np.where(share >= 1.0, bounds.acceleration_max, self.swing_acceleration[:, None]) * h
        self._put_limits("acceleration", -rate_max, rate_max)
        self.usual_force: Array = self._static_forces(share)
        stage.numbers("force_ref")[2::3] = self.usual_force

    def _put_support(self, stands: NDArray[np.bool_]) -> None:
        """Over which three feet the CoM is wanted in each interval, if one of four swings."""
        stage, end = self._stages
        corners, counts = corners_of(stands), stands.sum(axis=0) == CORNERS
        stage.numbers("support_corners")[:] = corners
        stage.numbers("support_counts")[:] = counts
        end.numbers("support_corners")[:] = corners[:, -1:]
        end.numbers("support_counts")[:] = counts[-1]

    def _put_lift(self, clock: GaitClock, edges: Array) -> None:
        """How high feet are above level ground, and how fast they rise."""
        count, stage = self.count, self._problem.interval
        points = (edges[:-1, None] + self.interval * np.array(POINTS)).ravel()
        height, rate = clock.lift(np.concatenate([edges, points]))
        height, rate = height[: count + 1], rate[count + 1 :]
        if isinstance(self.ground, LevelGround):
            for part in self._stages:
                part.numbers("ground")[:] = self.ground.height[:, None]
        stage.numbers("foot_height")[:] = height[:-1].T
        self._problem.end.numbers("foot_height")[:] = height[-1][:, None]
        stage.numbers("lift_rate")[:] = rate.reshape(count, len(POINTS), 4).T.reshape(-1, count)

    def put_ground(
        self, clock: GaitClock, time: float, xy: Array, reference: Reference, keeps_off: bool = True
    ) -> None:
        """What is under the feet along the horizon, and what it asks of the base; nothing where it is level.

        Args:
            clock: which foot is in the air when.
            time: of the first node, s.
            xy: about which places of the feet at the nodes, (N + 1, 4, 2), m.
            reference: where the robot is wanted.
            keeps_off: whether feet are kept off edges; who follows a plan has footholds.
        """
        ground = self.ground
        if isinstance(ground, LevelGround):
            return
        yaw = reference.pose[3]
        wanted = reference.pose[:2].T[:, None] + turned_plane(self.stance[:, :2], yaw)
        along = ground.along(clock, time, self.interval, xy, wanted, self.stands, yaw)
        stage = self._problem.interval
        self._spread("ground_model", along.model.reshape(self.count + 1, -1).T)
        self._spread("contact_slope", along.slope.reshape(self.count + 1, -1).T)
        self._spread("foot_height", along.foot_height.T)
        self._spread("foothold_normal", along.normal.reshape(self.count + 1, -1).T)
        self._spread("foothold_offset", along.offset.T)
        self._spread("foothold_counts", keeps_off * along.counts.T)
        for part in self._stages:
            part.numbers("foot_radius")[:] = ground.radius[:, None]
        stage.numbers("lift_rate")[:] = along.lift_rate
        stage.numbers("mu")[:] = np.minimum(self.bounds.friction, along.friction)
        self._put_base(along, reference)

    def _put_base(self, along: AlongHorizon, reference: Reference) -> None:
        """Height and tilt of the base after the ground, and the stance under a base that is tilted."""
        ground, pitch, roll = along.base
        self._spread("height_z", (reference.pose[2] + ground)[None])
        self._put_tilt(along.base[1:])
        climb = np.gradient(ground, self.interval)
        self._spread("velocity_rate", np.vstack([reference.rate[:2], climb]))
        shift = OVER_FEET * self.robot.height * np.stack([pitch, -roll])
        for axis in range(2):
            nominal = self._ahead[axis] + self.stance[:, axis, None] + shift[axis]
            stage, end = self._stages
            stage.numbers("stance")[axis::3] = nominal[:, :-1]
            end.numbers("stance")[axis::3] = nominal[:, -1:]

    def _put_tilt(self, tilt: Array) -> None:
        """Pitch and roll that are wanted at the nodes, (2, N + 1), rad; on terrain axes of the feet, too."""
        self._spread("tilt_reference", tilt)
        if isinstance(self.ground, LevelGround):
            return
        stage, end = self._stages
        stage.numbers("base_tilt")[:] = np.vstack([tilt[:, :-1], tilt[:, 1:]])
        end.numbers("base_tilt")[:] = np.tile(tilt[:, -1:], (2, 1))

    def _spread(self, name: str, values: Array) -> None:
        """Writes numbers of the nodes, (size, N + 1)."""
        stage, end = self._stages
        stage.numbers(name)[:] = values[:, :-1]
        end.numbers(name)[:] = values[:, -1:]

    def _static_forces(self, share: Array) -> Array:
        """Vertical forces that would carry the robot at its nominal stance, (4, N), in its weights."""
        A = np.ones((3, 4))
        A[1:] = self.stance[:, :2].T
        products = (A[:, None] * A).reshape(9, 4)
        gram = (products @ share).T.reshape(-1, 3, 3) + np.diag([0.0, SMALL_MOMENT, SMALL_MOMENT])
        multipliers = np.linalg.solve(gram, np.broadcast_to(_WEIGHT_ALONE, (share.shape[1], 3, 1)))
        forces: Array = np.maximum(share * (A.T @ multipliers[:, :, 0].T), 0.0)
        return forces

    def put_stance(self, centred: float, elapsed: float) -> None:
        """Leads the nominal stance to where the CoM is that share of the way over the middle of the feet."""
        change = max(-CENTRING_RATE * elapsed, min(CENTRING_RATE * elapsed, centred - self._centred))
        if change == 0.0 and not self._strides:
            return
        self._centred += change
        self._write_stance()

    def take_stance(self, other: Filling) -> None:
        """The nominal stance is as far over the feet as that of another one."""
        self._centred = other._centred
        self._write_stance()

    def restore_stance(self) -> None:
        """The nominal stance again, after that of a plan."""
        self._write_stance()

    def reset_stance(self) -> None:
        """The nominal stance is the robot's own again."""
        self._centred = 0.0
        self._write_stance()

    def _write_stance(self) -> None:
        self._strides = False
        self.stance = self.robot.stance.copy()
        self.stance[:, :2] -= self._centred * self.robot.stance[:, :2].mean(axis=0)
        for stage in self._stages:
            self._all(stage, "stance", self.stance.ravel())

    def put_strides(self, clock: GaitClock, time: float, foot_velocity: Array) -> None:
        """Shifts the nominal stance of feet where they do not roll: ahead where they land, then behind."""
        dragged = self._feet.dragged(foot_velocity, clock.locked(time))
        if not dragged.any() or clock.gait.swing <= 0.0:
            self._ahead = np.zeros((2, 4, self.count + 1))
            return
        ahead = clock.stride(time + self._steps).T * dragged
        self._ahead = ahead
        stage, end = self._stages
        for axis in range(2):
            nominal = self.stance[:, axis, None]
            stage.numbers("stance")[axis::3] = nominal + ahead[axis, :, :-1]
            end.numbers("stance")[axis::3] = nominal + ahead[axis, :, -1:]
        self._strides = True

    def put_reference(self, reference: Reference) -> None:
        """Where the robot is wanted."""
        ground = float(self.ground.height.mean()) if isinstance(self.ground, LevelGround) else 0.0
        stage, end = self._stages
        for name, values in (
            ("goal_pose", reference.pose),
            ("height_z", reference.pose[2:3] + ground),
            ("velocity_rate", reference.rate[:3]),
            ("rotation_yaw_rate", reference.rate[3:]),
            ("heading_sigma", reference.heading),
        ):
            stage.numbers(name)[:] = values[:, :-1]
            end.numbers(name)[:] = values[:, -1:]
        stage.numbers("speed_ref")[:] = reference.speed[:, :-1]
        if self._own:
            self.context.goals[:] = 0.0
            self.context.goals[:4] = reference.pose[:, :-1]
            self.context.goals[2] += ground
            for part in self._stages:
                part.put_terms(self._own, self.context)

    def put_plan(self, wanted: Wanted, nodes: Array, yaw: Array) -> None:
        """What a plan wants, after all that a command and the ground have put.

        Feet that stand are wanted where they are planned from the CoM; those in the air where they are
        planned in the world, whatever the CoM does.

        Args:
            wanted: by the plan.
            nodes: CoM and feet of the last solution at the nodes, (N + 1, 5, 3), m.
            yaw: of it, (N + 1,), rad.
        """
        stage, end = self._stages
        self._spread("height_z", wanted.reference.pose[2:3])
        self._put_tilt(wanted.tilt)
        self._spread("velocity_rate", np.vstack([wanted.reference.rate[:2], wanted.climb]))
        planned = wanted.foot_position - wanted.com_position[:, None]
        if wanted.rests:
            planned = nodes[:, 1:] - wanted.com_position[:, None]
        axes = wanted.tilt if not isinstance(self.ground, LevelGround) else np.zeros_like(wanted.tilt)
        own = _seen(planned, wanted.reference.pose[3], axes)
        free = _seen(wanted.foot_position - nodes[:, :1], yaw, axes)
        place = np.where(wanted.in_air[..., None], free, own)
        for axis in range(2):
            stage.numbers("stance")[axis::3] = place[:-1, :, axis].T
            end.numbers("stance")[axis::3] = place[-1:, :, axis].T
        self._strides = True  # the nominal stance is to be written again
        stage.numbers("force_ref")[:] = wanted.force.reshape(self.count, 12).T / self.robot.weight

    def _put_limits(self, name: str, lower: Array | float, upper: Array | float) -> None:
        number, nlp = self._row_numbers[name], self._problem.nlp
        nlp.g_lower[number] = lower
        nlp.g_upper[number] = upper


def _seen(places: Array, yaw: Array, tilt: Array) -> Array:
    """Vectors (n, 4, 3) in axes of n yaws (n,) and tilts (2, n), in the order pitch, roll."""
    return np.asarray(places @ rotations(np.stack([yaw, tilt[0], tilt[1]], axis=1)))
