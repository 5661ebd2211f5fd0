"""Plans that are right by construction: motions with a closed form, put on the collocation points.

Nothing here knows the planner or the certificate; each motion says why it obeys the dynamics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from rollgait.plan import Plan, Statistics
from rollgait.plan.trajectory import CollocationTrajectory
from rollgait.robot import Robot
from rollgait.scenario import ContactSchedule, Scenario

Array = NDArray[np.float64]

GRAVITY = 9.81  # m/s²
STATE_SUPPORT = np.concatenate([[0.0], 0.5 * (leggauss(3)[0] + 1.0)])
HEIGHT_SUPPORT = np.concatenate([[0.0], 0.5 * (leggauss(2)[0] + 1.0)])


def robot(foot: str = "steerable", limbs: bool = True) -> Robot:
    """A simple robot whose principal axes are those of the base, so that it can turn without wobbling."""

    def leg(x: float, y: float) -> dict[str, Any]:
        front, left = np.sign(x), np.sign(y)
        limb = {
            "hip": [0.1 * front, 0.15 * left, 0.0],
            "plane_offset": 0.05 * left,
            "direction": int(front),
            "ankle_height": 0.1,
            "extension": [0.3, 0.75],
            "radius_min": 0.1,
            "hip_yaw": [-2.5, 2.5],
            "steering_joint": [-2.5, 2.5],
        }
        return {
            "foot": foot,
            "stance": [x, y, -0.7],
            "wheel_radius": 0.1,
            "force_max": 1500.0,
            "limb": limb if limbs else None,
        }

    legs = {"FL": leg(0.3, 0.35), "FR": leg(0.3, -0.35), "HL": leg(-0.4, 0.35), "HR": leg(-0.4, -0.35)}
    return Robot.model_validate(
        {
            "name": "test",
            "mass": 100.0,
            "inertia": {"xx": 16.0, "yy": 18.0, "zz": 14.0},
            "box": [0.2, 0.18, 0.15],
            "legs": legs,
        }
    )


@dataclass
class Motion:
    """A motion by closed forms; each takes interval k and local times s (n,) and gives (n, …)."""

    com: Callable[[int, Array], Array]
    com_rate: Callable[[int, Array], Array]
    euler: Callable[[int, Array], Array]
    euler_rate: Callable[[int, Array], Array]
    foot_xy: Callable[[int, Array], Array]
    heading: Callable[[int, Array], Array]
    foot_z: Callable[[int, Array], Array]
    force: Array
    motion: Array = field(default_factory=lambda: np.zeros((0, 4, 2)))


def build(scenario: Scenario, motion: Motion, schedule: ContactSchedule | None = None) -> Plan:
    """The plan of this motion: its values at the points of the paper's transcription."""
    schedule = schedule or scenario.schedule
    s, sz = (np.outer(schedule.lengths, support) for support in (STATE_SUPPORT, HEIGHT_SUPPORT))
    count = range(schedule.intervals)
    trajectory = CollocationTrajectory(
        contact=schedule.contact.T,
        lengths=schedule.lengths,
        base=np.array([np.hstack([motion.com(k, s[k]), motion.euler(k, s[k])]) for k in count]),
        base_rate=np.array(
            [np.hstack([motion.com_rate(k, s[k]), motion.euler_rate(k, s[k])]) for k in count]
        ),
        foot_xy=np.array([motion.foot_xy(k, s[k]) for k in count]),
        heading=np.array([motion.heading(k, s[k]) for k in count]),
        foot_z=np.array([motion.foot_z(k, sz[k]) for k in count]),
        force=motion.force,
        motion=motion.motion,
    )
    statistics = Statistics("collocation", "none", True, "by construction", 0, 0.0)
    return Plan(scenario.body, scenario, schedule, trajectory, statistics)


def scenario(body: Robot | None = None, **values: Any) -> Scenario:
    """A scenario in which the test robot goes nowhere in 2 s, if `values` do not say otherwise."""
    data = {"robot": body or robot(), "goal": {"x": 0.0}, "horizon": 2.0, "gait": {"kind": "drive"}}
    return Scenario.from_dict(data | values)


def standing(asked: Scenario, schedule: ContactSchedule | None = None) -> Plan:
    """Nothing moves but feet in swing, which have no mass; the others carry the weight without a torque."""
    body, schedule = asked.body, schedule or asked.schedule
    count, h, nodes = schedule.intervals, schedule.lengths, schedule.node_times
    com = np.array([0.0, 0.0, asked.height])
    stance = body.stance
    force = np.zeros((count, 4, 3))
    for k in range(count):
        down = schedule.contact[:, k]
        force[k, down, 2] = body.static_forces(stance[down])
    headings = asked.start_headings()
    node, middle = np.zeros((2, count + 1, 4))
    for swing in schedule.swings():
        lift_off, touch_down = nodes[[swing.lift_off, swing.touch_down]]
        for k in range(swing.lift_off, swing.touch_down):
            for heights, at in ((node, nodes[k]), (middle, nodes[k] + 0.5 * h[k])):
                phase = (at - lift_off) / (touch_down - lift_off)
                heights[k, swing.leg] = asked.clearance * np.sin(np.pi * phase) ** 2
    return build(
        asked,
        Motion(
            com=lambda k, s: np.tile(com, (s.size, 1)),
            com_rate=lambda k, s: np.zeros((s.size, 3)),
            euler=lambda k, s: np.zeros((s.size, 3)),
            euler_rate=lambda k, s: np.zeros((s.size, 3)),
            foot_xy=lambda k, s: np.tile(stance[:, :2], (s.size, 1, 1)),
            heading=lambda k, s: np.tile(headings, (s.size, 1)),
            foot_z=lambda k, s: _parabola(node[k], middle[k], node[k + 1], s / h[k]),
            force=force,
            motion=np.zeros((count, 4, 2)),
        ),
        schedule,
    )


def _parabola(begin: Array, middle: Array, end: Array, tau: Array) -> Array:
    bulge = 4.0 * middle - 2.0 * (begin + end)
    t = tau[:, None]
    return np.asarray(begin * (1.0 - t) + end * t + bulge * t * (1.0 - t))


def there_and_back(half: int) -> Array:
    """Factors of an acceleration: `half` intervals of 1, as many of −1, one of 0."""
    return np.concatenate([np.ones(half), -np.ones(half), [0.0]])


def driving(body: Robot | None = None, acceleration: float = 0.5, **values: Any) -> Plan:
    """Straight ahead: constant acceleration, constant deceleration as long, and one interval of rest.

    A wheel's speed is constant in an interval, so the CoM swings by ξ = a s (h − s) / 2 about the middle of
    the feet. When the forces balance the mean of that, the pitch torque is m g (ξ − mean ξ): pitch and its
    rate are zero at every node, and between them follow by two integrations.
    """
    body = body or robot()
    half, h = 10, 0.1
    distance = acceleration * (half * h) ** 2
    asked = scenario(body, goal={"x": distance}, horizon=(2 * half + 1) * h, interval=h, **values)
    count = asked.schedule.intervals
    a = acceleration * there_and_back(half)
    speed = np.concatenate([[0.0], np.cumsum(a * h)])
    place = np.concatenate([[0.0], np.cumsum(speed[:-1] * h + 0.5 * a * h**2)])
    rolling = speed[:-1] + 0.5 * a * h
    mass, stance = body.mass, body.stance
    weight = mass * GRAVITY
    force = np.zeros((count, 4, 3))
    for k in range(count):
        # the feet are ahead of the CoM by ξ, in the mean a h² / 12; fx pushes below the CoM
        balance = np.vstack([np.ones(4), stance[:, 0] + a[k] * h**2 / 12.0, stance[:, 1]])
        wanted = np.array([weight, -asked.height * mass * a[k], 0.0])
        force[k, :, 2] = np.linalg.lstsq(balance, wanted, rcond=None)[0]
        force[k, :, 0] = mass * a[k] / 4.0

    def pitch(k: int, s: Array) -> tuple[Array, Array]:
        # τ_y = −Σ (p_x − r_x) f_z + …: the mean vanishes by the choice of the forces
        scale = -weight * a[k] / body.inertia.yy
        rate = scale * (h * s**2 / 4.0 - s**3 / 6.0 - h**2 * s / 12.0)
        angle = scale * (h * s**3 / 12.0 - s**4 / 24.0 - h**2 * s**2 / 24.0)
        return angle, rate

    zeros = np.zeros_like
    return build(
        asked,
        Motion(
            com=lambda k, s: np.column_stack(
                [place[k] + speed[k] * s + 0.5 * a[k] * s**2, zeros(s), zeros(s) + asked.height]
            ),
            com_rate=lambda k, s: np.column_stack([speed[k] + a[k] * s, zeros(s), zeros(s)]),
            euler=lambda k, s: np.column_stack([zeros(s), pitch(k, s)[0], zeros(s)]),
            euler_rate=lambda k, s: np.column_stack([zeros(s), pitch(k, s)[1], zeros(s)]),
            foot_xy=lambda k, s: (
                stance[None, :, :2] + np.column_stack([place[k] + rolling[k] * s, zeros(s)])[:, None, :]
            ),
            heading=lambda k, s: np.zeros((s.size, 4)),
            foot_z=lambda k, s: np.zeros((s.size, 4)),
            force=force,
            motion=np.stack([np.tile(rolling[:, None], (1, 4)), np.zeros((count, 4))], axis=-1),
        ),
    )


def turning(torque: float = 4.0, **values: Any) -> Plan:
    """On the spot about the vertical axis: a torque, its opposite as long, and one interval of rest.

    The wheels run on circles about the CoM with f ⟂ p − r as it is in mid-interval. As Σ fz p̄ = 0, horizontal
    forces c fz ẑ × p̄ add up to nothing, and have the torque C cos(turn from the middle).
    """
    body = robot()
    half, h = 10, 0.1
    stance = body.stance
    normal = body.static_forces()
    radius = np.hypot(stance[:, 0], stance[:, 1])
    angle = np.arctan2(stance[:, 1], stance[:, 0])
    gain = torque / float(normal @ radius**2)
    sign = there_and_back(half)
    count = sign.size
    yaw, yaw_rate, feet_rate = np.zeros(count + 1), np.zeros(count + 1), np.zeros(count)

    def turn(k: int, s: Array) -> tuple[Array, Array]:
        """ψ and ψ̇ from ψ̈ = A cos(w (s − h/2)), w the rate of the feet."""
        A, w = sign[k] * torque / body.inertia.zz, feet_rate[k]
        if A == 0.0:
            return yaw[k] + yaw_rate[k] * s, yaw_rate[k] + 0.0 * s
        rate = yaw_rate[k] + A / w * (np.sin(w * (s - h / 2)) + np.sin(w * h / 2))
        bend = (np.cos(w * h / 2) - np.cos(w * (s - h / 2))) / w + np.sin(w * h / 2) * s
        return yaw[k] + yaw_rate[k] * s + A / w * bend, rate

    for k in range(count):
        feet_rate[k] = yaw_rate[k] + 0.5 * sign[k] * torque / body.inertia.zz * h
        for _ in range(20):  # the feet turn as far as the base in each interval
            feet_rate[k] = (turn(k, np.array([h]))[0][0] - yaw[k]) / h
        (yaw[k + 1],), (yaw_rate[k + 1],) = turn(k, np.array([h]))
    # wheels stand along the circle, within ±90° of the base; those on the left roll backwards
    tangent = angle + np.pi / 2.0
    heading = np.where(np.cos(tangent) < 0.0, tangent - np.pi, tangent)
    heading -= 2.0 * np.pi * np.round(heading / (2.0 * np.pi))
    forward = np.where(np.cos(tangent) < 0.0, -1.0, 1.0)
    names = ("FL", "FR", "HL", "HR")
    asked = scenario(
        body,
        goal={"x": 0.0, "yaw_deg": float(np.degrees(yaw[-1]))},
        start={"heading_deg": dict(zip(names, np.degrees(heading).tolist(), strict=True))},
        horizon=count * h,
        interval=h,
        **values,
    )
    middle = angle + yaw[:-1, None] + 0.5 * h * feet_rate[:, None]
    push = (sign[:, None] * gain) * normal * radius
    force = np.stack([-push * np.sin(middle), push * np.cos(middle), np.tile(normal, (count, 1))], axis=-1)
    speed = feet_rate[:, None] * radius * forward

    def foot_angle(k: int, s: Array) -> Array:
        return np.asarray(yaw[k] + feet_rate[k] * s[:, None] + angle)

    zeros = np.zeros_like
    return build(
        asked,
        Motion(
            com=lambda k, s: np.column_stack([zeros(s), zeros(s), zeros(s) + asked.height]),
            com_rate=lambda k, s: np.zeros((s.size, 3)),
            euler=lambda k, s: np.column_stack([turn(k, s)[0], zeros(s), zeros(s)]),
            euler_rate=lambda k, s: np.column_stack([turn(k, s)[1], zeros(s), zeros(s)]),
            foot_xy=lambda k, s: np.stack(
                [radius * np.cos(foot_angle(k, s)), radius * np.sin(foot_angle(k, s))], axis=-1
            ),
            heading=lambda k, s: yaw[k] + feet_rate[k] * s[:, None] + heading,
            foot_z=lambda k, s: np.zeros((s.size, 4)),
            force=force,
            motion=np.stack([speed, np.tile(feet_rate[:, None], (1, 4))], axis=-1),
        ),
    )


STEPPING = {
    "horizon": 4.0,
    "gait": {"kind": "schedule", "HL": [[0.5, 1.5]], "HR": [[2.0, 3.0]]},
}
"""A gait in which the hind feet step in turn: without one of them the CoM still lies inside the support."""


def stepping(body: Robot | None = None, **values: Any) -> Plan:
    """Steps with the hind feet on the spot."""
    return standing(scenario(body or robot(), **(STEPPING | values)))


def stepping_on_an_unequal_mesh(body: Robot | None = None) -> Plan:
    """The same on intervals of which some are cut in two or three, in stance and in swing."""
    asked = scenario(body or robot(), **STEPPING)
    return standing(asked, asked.schedule.refined([0, 7, 8, 22, 39], [2, 2, 3, 2, 2]))


def changed(plan: Plan, **arrays: Array) -> Plan:
    """The plan with arrays of its trajectory replaced."""
    return replace(plan, trajectory=replace(plan.trajectory, **arrays))


def spoilt(plan: Plan, name: str, place: Any, by: Any) -> Plan:
    """The plan with a number of its trajectory (or all of a slice) changed by `by`."""
    values = np.array(getattr(plan.trajectory, name))
    values[place] += by
    return changed(plan, **{name: values})


def asked(plan: Plan, **values: Any) -> Plan:
    """The plan, unchanged, judged by a scenario with other values (dotted keys with __ for the dot)."""
    dotted = {key.replace("__", "."): value for key, value in values.items()}
    return replace(plan, scenario=plan.scenario.with_values(dotted))
