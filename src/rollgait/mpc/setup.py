"""A closed loop from names: robot, plant, estimator."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import astuple
from typing import TYPE_CHECKING, Final

from rollgait.errors import InputError, MissingExtraError, UnknownNameError
from rollgait.mpc.estimator import Blended, Delayed, Estimator, Noisy, Trust, Truth
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.replay import Replay
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.settings import MpcSettings
from rollgait.plant.disturbances import Disturbances
from rollgait.plant.protocol import Plant
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.library import find_robot
from rollgait.robot.loads import Loads, Wrench
from rollgait.robot.robot import Robot
from rollgait.robot.whole_body import EXTRA, find_whole_body
from rollgait.scenario import Start

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain

DELAY: Final = 2
"""Age of what the estimator `delayed` knows, in periods of the controller."""

_WHOLE_BODY: Final = Trust(place=0.1, posture=0.02, motion=0.05)
TRUST: Final = {"mujoco": _WHOLE_BODY, "hardware": _WHOLE_BODY}
"""Share of a measurement that is believed in each period, by plant; all of it where none stands here.

Joints that give way under load make a whole body differ from the model by a little all the time: who started
anew from each measurement would take the sag for the robot's own motion."""
TRUST_PERIOD: Final = 0.01
"""s, the period that these shares are for."""
LAG: Final = {"mujoco": 0.02, "hardware": 0.04}
"""By how much a plant is behind what it is told, s; not at all where none stands here."""
GATE: Final = {"mujoco": 0.3, "hardware": 0.3}
"""Farthest that a measurement may be from what was expected, m; stiff joints do not give way so far."""

ESTIMATORS: Final[dict[str, Callable[[int], Estimator]]] = {
    "truth": lambda seed: Truth(),
    "noisy": lambda seed: Noisy(seed=seed),
    "delayed": lambda seed: Delayed(DELAY),
}
"""From a seed of random numbers to what is measured, by name."""

PLANTS: Final = ("rigid", "mujoco")


def make_loop(
    robot: Robot | str = "centauro",
    plant: str | Plant = "rigid",
    settings: MpcSettings | None = None,
    *,
    gait: str = "drive",
    estimator: str = "truth",
    disturbances: Disturbances | None = None,
    kernels: bool = True,
    seed: int = 0,
    start: Start | RobotState | None = None,
    terrain: Terrain | None = None,
    loads: Loads | None = None,
) -> ClosedLoop:
    """A controller and what it controls, ready to run.

    >>> from rollgait.mpc.script import RandomScript
    >>> log = make_loop("centauro").run(RandomScript().script())  # doctest: +SKIP

    Args:
        robot: of the library by name, a file, or its data.
        plant: `rigid`, or `mujoco` (needs the extra `whole-body`); or one that exists already.
        settings: of the controller.
        gait: with which it begins.
        estimator: what the controller gets to know of the state: `truth`, `noisy` or `delayed`.
        disturbances: of the plant `mujoco`.
        kernels: compile the stage functions, where there is a compiler.
        seed: of the noise.
        start: place and yaw where a plant that is made here stands, or the state it stands in; the origin if
            not given.
        terrain: the ground, of the plant that is made here and as the controller knows it; level if not
            given.
        loads: what the robot carries and what pulls at it, beside what its data say: the controller knows it,
            and so does a plant that is made here.

    Raises:
        UnknownNameError: no robot, plant, gait or estimator of that name.
        InputError: disturbances of a plant that knows none.
        MissingExtraError: MuJoCo or pinocchio is not installed.
    """
    if estimator not in ESTIMATORS:
        raise UnknownNameError("estimator", estimator, ESTIMATORS)
    find_gait(gait)
    body, loads = find_robot(robot) if isinstance(robot, str) else robot, loads or Loads()
    body = body.with_loads(loads)
    if isinstance(plant, str):
        stands = start if isinstance(start, RobotState) else _standing(body, start or Start(), terrain)
        plant = _plant(plant, body, stands, disturbances, terrain, loads.wrench)
    elif disturbances is not None:
        raise InputError("disturbances", plant.name, "must be given when this plant is made")
    follows = plant.name != Replay.name
    mpc = Mpc(body, settings, gait=gait, kernels=kernels, follows=follows, wrenches=loads.wrench)
    if terrain is not None:
        mpc.set_ground(terrain)
    known = observer(plant.name, mpc.settings.period, ESTIMATORS[estimator](seed), estimator == "delayed")
    return ClosedLoop(mpc, plant, known)


def _standing(body: Robot, place: Start, terrain: Terrain | None) -> RobotState:
    """The robot in its stance at a place. Raises `InputError` if it cannot stand there."""
    if terrain is not None:
        from rollgait.scenario.standing import require_stance  # loads SciPy

        require_stance(terrain, body, (place.x, place.y, place.yaw_deg), "start", with_margin=False)
    return standing_state(body, 0.0, place.x, place.y, math.radians(place.yaw_deg), terrain)


def observer(plant: str, period: float, measurement: Estimator, is_delayed: bool = False) -> Blended:
    """What the controller of a plant believes, from a measurement.

    Args:
        plant: its name.
        period: of the controller, s.
        measurement: the estimator of the measurement.
        is_delayed: whether it is `DELAY` periods old.
    """
    lag = round(LAG.get(plant, 0.0) / period) + (DELAY if is_delayed else 0)
    believed = TRUST.get(plant, Trust())
    shares = (1.0 - (1.0 - share) ** (period / TRUST_PERIOD) for share in astuple(believed))
    return Blended(Trust(*shares), measurement, lag, GATE.get(plant, math.inf))


def _plant(
    name: str,
    robot: Robot,
    start: RobotState,
    disturbances: Disturbances | None,
    terrain: Terrain | None,
    wrenches: Sequence[Wrench],
) -> Plant:
    if name not in PLANTS:
        raise UnknownNameError("plant", name, PLANTS)
    if name == "rigid":
        if disturbances is not None:
            raise InputError("disturbances", "rigid", "is a plant that has none; mujoco has them")
        return RigidPlant(robot, start, terrain=terrain, wrenches=wrenches)
    try:
        import mujoco  # noqa: F401
    except ImportError:
        raise MissingExtraError("the plant 'mujoco'", EXTRA) from None
    body = find_whole_body(robot)
    from rollgait.simulation.plant import MujocoPlant

    return MujocoPlant(body, robot, start, disturbances=disturbances, terrain=terrain, wrenches=wrenches)
