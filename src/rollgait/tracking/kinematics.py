"""Hierarchical inverse kinematics of the whole body: the stack of the paper, one step of it, and standing.

Whoever follows something, a plan or a controller, says where everything shall be at the end of a step, and
keeps the state from which the next one is taken.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.errors import InputError
from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel
from rollgait.tracking import tasks
from rollgait.tracking.stack import Step, solve

Array = NDArray[np.float64]

START_ITERATIONS: Final = 100
"""Steps in which the posture at the start must be found."""

START_TOLERANCE: Final = 1e-8
"""Largest error, m or rad, with which it counts as found."""

START_STEP: Final = 0.2
"""Largest change of a joint in one of these steps, rad: keeps the knees on their side."""

PLANNED_LEVELS: Final = 3
"""Levels that follow what is planned; those below are the posture's."""

Stack = list[list[tasks.Task]]


class Moved(NamedTuple):
    """One step of the whole body.

    Attributes:
        step: what the stack found; its x is the displacement, (nv,), m and rad.
        state: where it leads.
    """

    step: Step
    state: BodyState

    @property
    def is_on_plan(self) -> bool:
        """Whether every level that follows what is planned could be served."""
        return all(level >= PLANNED_LEVELS for level in self.step.failed)


class InverseKinematics:
    """The stack on a whole body. Remembers nothing.

    Args:
        model: the whole body.
        waist: `com` holds the centre of mass at its place, `base` the base link at a constant offset from it.

    Attributes:
        model: the whole body.
        stack: its levels, the most important first.
        rolling_radius: of the wheels, (4,), m; inf where there is none, so that v/R is 0.
    """

    def __init__(self, model: WholeBodyModel, waist: str = "com") -> None:
        self.model = model
        self.stack = build_stack(model, waist)
        self.rolling_radius: Array = np.array(
            [leg.radius if leg.wheel is not None else np.inf for leg in model.legs]
        )

    def step(self, state: BodyState, target: tasks.Target, duration: float) -> Moved:
        """From a state towards a target, within the limits of joint positions and velocities.

        Args:
            state: where the whole body is.
            target: where it shall be.
            duration: of the step, s.

        Raises:
            numpy.linalg.LinAlgError: a decomposition does not converge.
        """
        lower, upper = step_bounds(self.model, state.q, duration)
        step = solve(levels_of(self.stack, state, target), lower, upper)
        return Moved(step, self._moved(state, step.x))

    def stand(self, target: tasks.Target) -> BodyState:
        """The whole body as it stands at a target, found from the model's posture.

        Raises:
            InputError: it cannot stand so: a foot, a heading or the CoM stays away from its place.
        """
        model = self.model
        q = model.posture.copy()
        turn = np.arctan2(target.R_world_base[1, 0], target.R_world_base[0, 0])
        q[3:7] = Rotation.from_euler("z", turn).as_quat()
        q[:3] += target.p_com - model.state(q).p_com
        state = model.state(q)
        for _ in range(START_ITERATIONS):
            levels = levels_of(self.stack, state, target)
            error = max(float(np.max(np.abs(b), initial=0.0)) for _, b in levels[:PLANNED_LEVELS])
            if error < START_TOLERANCE:
                return state
            lower, upper = step_bounds(model, state.q, np.inf)
            step = solve(levels, np.maximum(lower, -START_STEP), np.minimum(upper, START_STEP))
            state = self._moved(state, step.x)
        worst, name = max(
            (float(np.max(np.abs(task.error(state, target)), initial=0.0)), task.name)
            for level in self.stack[:PLANNED_LEVELS]
            for task in level
        )
        raise InputError(
            "plan",
            f"the start of {model.config.name}",
            f"is out of reach of the whole body: {name} stays {worst:.2g} m or rad away",
        )

    def _moved(self, state: BodyState, displacement: Array) -> BodyState:
        return self.model.state(self.model.integrate(state.q, displacement))


def build_stack(model: WholeBodyModel, waist: str = "com") -> Stack:
    """The levels of the paper: feet XYZ / wheel rolling and foot orientation / waist / posture.

    The posture of the legs stands below that of the upper body: else arms would swing to let the legs be near
    theirs.
    """
    if waist == "com":
        place: tasks.Task = tasks.CentreOfMass()
    else:
        state = model.state(model.posture)
        place = tasks.WaistPosition(state.R_world_base.T @ (state.p_base - state.p_com))
    return [
        [tasks.FootPosition()],
        [
            tasks.WheelRolling(model),
            tasks.WheelHeading(model),
            tasks.FootTilt(model),
            tasks.WheelCamber(model),
        ],
        [place, tasks.WaistOrientation()],
        [tasks.Posture(model, model.posture, tasks.upper_body(model))],
        [tasks.Posture(model, model.posture, tasks.leg_joints(model))],
    ]


def levels_of(stack: Stack, state: BodyState, target: tasks.Target) -> list[tuple[Array, Array]]:
    """Jacobian and error of each level, as `stack.solve` takes them."""
    return [
        (
            np.concatenate([task.jacobian(state) for task in level]),
            np.concatenate([task.error(state, target) for task in level]),
        )
        for level in stack
    ]


def step_bounds(model: WholeBodyModel, q: Array, duration: float) -> tuple[Array, Array]:
    """Smallest and largest step within the limits of joint positions and velocities, each of shape (nv,)."""
    upper = np.full(model.nv, np.inf)
    lower = -upper
    angles = q[BASE_V + 1 :]
    reach = model.velocity_max * duration
    lower[BASE_V:] = np.clip(model.position_lower - angles, -reach, reach)
    upper[BASE_V:] = np.clip(model.position_upper - angles, -reach, reach)
    return lower, upper


def carried(state: BodyState, force: Array, contact_offset: Array | None = None) -> Array:
    """What contact forces do in the place of drives: generalised forces, (nv,), N and N m.

    Args:
        state: the whole body.
        force: (4, 3), N.
        contact_offset: from the lowest points of the rims to where the forces act, (4, 3), m; none on level
            ground.
    """
    result = np.einsum("lij,li->j", state.J_contact, force)
    if contact_offset is not None:
        result += np.einsum("lij,li->j", state.J_angular, np.cross(contact_offset, force))
    return np.asarray(result)
