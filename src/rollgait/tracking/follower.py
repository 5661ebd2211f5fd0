"""The whole body follows a controller: one step of the stack per control, from where it was told to be."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

import daqp  # noqa: F401  (loaded now, not in the first control that meets a bound)
import numpy as np
import piqp  # noqa: F401
from numpy.typing import NDArray

from rollgait.angles import angular_velocity
from rollgait.dynamics.step import rotation
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES
from rollgait.robot.urdf_model import BASE_V, BodyState, load_model
from rollgait.robot.whole_body import WholeBody
from rollgait.tracking import tasks
from rollgait.tracking.kinematics import InverseKinematics, carried

Array = NDArray[np.float64]

ACCELERATION_TIME: Final = 0.05
"""Time over which the joints' acceleration is a mean, s: speeds of wheels jump from control to control."""


@dataclass(frozen=True, eq=False)
class JointTarget:
    """What the joints shall do until the end of a control, in the order of `Follower.joint_names`.

    Attributes:
        position: at its end, (n_j,), rad; wheels count their turns.
        velocity: mean over it, (n_j,), rad/s.
        torque: feed-forward, (n_j,), N m: inverse dynamics less what the contact forces do.
    """

    position: Array
    velocity: Array
    torque: Array


class Follower:
    """Turns controls into joint targets by the hierarchical inverse kinematics of `rollgait.track`.

    It remembers the configuration it commanded last, and nothing of any plan. The base of that configuration
    is free: a controller that moves its world, base and feet together, moves no joint.

    Args:
        body: the whole body.

    Attributes:
        model: the whole body as pinocchio sees it.
        joint_names: of the n_j joints.
        failed: whether the last control could not be followed, and the target before it was held.
        failures: how often that happened since the last `reset`.

    Raises:
        InputError: the whole body names what its URDF does not have.
    """

    def __init__(self, body: WholeBody) -> None:
        self.model = load_model(body)
        self.joint_names = self.model.joint_names
        self.failed = False
        self.failures = 0
        self._kinematics = InverseKinematics(self.model)
        self._state = self.model.state(self.model.posture)
        self._rest()

    def _rest(self) -> None:
        still = np.zeros(len(self.joint_names))
        self._velocities: deque[tuple[float, Array]] = deque([(0.0, still)])
        self._target = JointTarget(self._joints(), still, still)

    def _joints(self) -> Array:
        return np.asarray(self._state.q[BASE_V + 1 :])

    @property
    def state(self) -> BodyState:
        """The whole body as commanded last."""
        return self._state

    def reset(self, state: RobotState) -> None:
        """Stands the whole body at a state, at rest.

        Raises:
            InputError: it cannot stand so.
        """
        self._state = self._kinematics.stand(_target(state, np.zeros(len(LEG_NAMES))))
        self.failed, self.failures = False, 0
        self._rest()

    def follow(self, control: Control) -> JointTarget:
        """The joints for one control; those of the last one, at rest, where that is not possible."""
        found = self._step(control)
        self.failed = found is None
        if found is None:
            self.failures += 1
            self._velocities.append((control.period, np.zeros_like(self._target.velocity)))
            self._target = JointTarget(
                self._target.position, np.zeros_like(self._target.velocity), self._target.torque
            )
            return self._target
        self._state, self._target = found
        return self._target

    def _step(self, control: Control) -> tuple[BodyState, JointTarget] | None:
        """State and target at the end of a control; None if they cannot be found."""
        period, kinematics = control.period, self._kinematics
        if not (period > 0.0 and _is_finite(control)):
            return None
        way = control.motion[:, 0] * period
        if control.way_factor is not None:
            way = way * control.way_factor
        target = _target(control.end, way / kinematics.rolling_radius)
        try:
            moved = kinematics.step(self._state, target, period)
        except np.linalg.LinAlgError:  # a decomposition that does not converge
            return None
        state, velocity = moved.state, moved.step.x[BASE_V:] / period
        if not (moved.is_on_plan and np.isfinite(moved.step.x).all()):
            return None
        torque = self._torque(control, state, velocity)
        if not (np.isfinite(state.q).all() and np.isfinite(torque).all()):
            return None
        return state, JointTarget(np.array(state.q[BASE_V + 1 :]), velocity, torque)

    def _torque(self, control: Control, state: BodyState, velocity: Array) -> Array:
        """Feed-forward torques at the end of a control, (n_j,), N m.

        How the base moves is taken from the control: what the stack moves it by holds shifts of the world.
        Its linear velocity does nothing.
        """
        begin, end, period = control.begin, control.end, control.period
        to_base = state.R_world_base.T
        omega = angular_velocity(end.euler, end.euler_rate)
        omega_before = angular_velocity(begin.euler, begin.euler_rate)
        v, a = np.zeros(self.model.nv), np.zeros(self.model.nv)
        v[3:BASE_V] = to_base @ omega
        v[BASE_V:] = velocity
        a[:3] = to_base @ (end.com_velocity - begin.com_velocity) / period
        a[3:BASE_V] = to_base @ (omega - omega_before) / period
        a[BASE_V:] = self._acceleration(period, velocity)
        need = self.model.inverse_dynamics(state.q, v, a)
        return np.asarray((need - carried(state, control.force, control.contact_offset))[BASE_V:])

    def _acceleration(self, period: float, velocity: Array) -> Array:
        """Mean over the last `ACCELERATION_TIME`, (n_j,), rad/s²."""
        known = self._velocities
        known.append((period, velocity))
        while len(known) > 2 and sum(p for p, _ in known) - known[0][0] - known[1][0] > ACCELERATION_TIME:
            known.popleft()
        duration = sum(p for p, _ in known) - known[0][0]
        return np.asarray((velocity - known[0][1]) / max(duration, ACCELERATION_TIME))


def _target(state: RobotState, roll_step: Array) -> tasks.Target:
    R_world_base: Array = np.array(rotation(np, list(state.euler)))
    return tasks.Target(state.com_position, R_world_base, state.foot_position, state.heading, roll_step)


def _is_finite(control: Control) -> bool:
    return (
        control.begin.is_finite()
        and control.end.is_finite()
        and bool(np.isfinite(control.force).all() and np.isfinite(control.motion).all())
        and all(
            bool(np.isfinite(part).all())
            for part in (control.contact_offset, control.way_factor)
            if part is not None
        )
    )
