"""States and mirror images for tests of the controller."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from hypothesis import strategies as st

from rollgait.plant.state import RobotState

MIRROR = np.array([1.0, -1.0, 1.0])
"""Left becomes right: the sign of each axis."""
OTHER_SIDE = [1, 0, 3, 2]
"""The leg on the other side: FL, FR, HL, HR → FR, FL, HR, HL."""


def random_state(seed: int, time: float = 0.0, size: float = 0.1) -> RobotState:
    """Any state near a standing robot of about the right size."""
    random = np.random.default_rng(seed)

    def near(*shape: int) -> np.ndarray:
        return size * random.uniform(-1.0, 1.0, shape)

    stance = np.array([[0.35, 0.35, 0.0], [0.35, -0.35, 0.0], [-0.35, 0.35, 0.0], [-0.35, -0.35, 0.0]])
    return RobotState(
        time=time,
        com_position=np.array([0.0, 0.0, 0.7]) + near(3),
        euler=near(3),
        com_velocity=near(3),
        euler_rate=near(3),
        foot_position=stance + near(4, 3) * [1.0, 1.0, 0.0],
        heading=near(4),
        speed=near(4),
    )


states = st.integers(0, 2**32 - 1).map(random_state)


def assert_equal(a: RobotState, b: RobotState, atol: float = 1e-12, but: tuple[str, ...] = ()) -> None:
    """Two states, number by number."""
    for field in fields(RobotState):
        if field.name not in but:
            np.testing.assert_allclose(
                getattr(a, field.name), getattr(b, field.name), atol=atol, err_msg=field.name
            )


def mirrored(state: RobotState) -> RobotState:
    """The same seen in a mirror in the x-z plane."""
    euler = np.array([-1.0, 1.0, -1.0])
    return RobotState(
        time=state.time,
        com_position=MIRROR * state.com_position,
        euler=euler * state.euler,
        com_velocity=MIRROR * state.com_velocity,
        euler_rate=euler * state.euler_rate,
        foot_position=MIRROR * state.foot_position[OTHER_SIDE],
        heading=-state.heading[OTHER_SIDE],
        speed=state.speed[OTHER_SIDE],
    )
