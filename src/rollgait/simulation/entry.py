"""`simulate`: the door to this package. Refuses what is wrong before anything heavy is loaded."""

from __future__ import annotations

from pathlib import Path

from rollgait.errors import MissingExtraError, UnknownNameError
from rollgait.plan.plan import Plan
from rollgait.plant.disturbances import Disturbances
from rollgait.robot.whole_body import EXTRA, WholeBody, equipped, find_whole_body, load_whole_body
from rollgait.simulation.controller import WHEEL_MODES
from rollgait.simulation.log import SimulationLog
from rollgait.terrain.terrain import Terrain
from rollgait.tracking import JointTrajectory, track


def simulate(
    motion: Plan | JointTrajectory,
    disturbances: Disturbances | None = None,
    *,
    feedback: bool = False,
    wheels: str = "angle",
    force: bool = False,
    whole_body: WholeBody | str | Path | None = None,
    terrain: Terrain | None = None,
) -> SimulationLog:
    """Lets the whole body execute a motion in MuJoCo, which shares nothing with the planner.

    Joint PD and feed-forward torques, clipped at the effort limits; 1 ms steps, elliptic friction cones.
    Joints are rigid. Only the feet collide with a plane; with a terrain the base and the legs do as well, and
    the log says so. The robot begins at rest where the plan begins, and stands for half a second after the
    motion.

    Args:
        motion: a joint trajectory, or a plan, which is tracked first.
        disturbances: what is not as planned; nothing if not given.
        feedback: correct the true base pose by the wheels' speeds and headings.
        wheels: `angle` follows the integrated planned angle of the wheels, `velocity` only their speed.
        force: execute the plan even if its certificate fails.
        whole_body: the whole body, or the YAML file that describes it; the robot's own if not given.
        terrain: the ground, in place of the plan's own; where that is flat or not known, a plane under the
            planned feet.

    Returns:
        The log, which judges itself: `log.report()`.

    Raises:
        NotCertifiedError: the plan's certificate fails, and `force` is not set.
        InputError: there is no whole-body model of the robot, an argument breaks a rule, or a push begins
            after the end.
        MissingExtraError: the extra `whole-body` is not installed.
    """
    if wheels not in WHEEL_MODES:
        raise UnknownNameError("wheels", wheels, WHEEL_MODES)
    try:
        import mujoco  # noqa: F401
    except ImportError:
        raise MissingExtraError("simulating a plan", EXTRA) from None
    from rollgait.simulation.run import STANDING, run

    disturbances = disturbances or Disturbances()
    length = motion.horizon if isinstance(motion, Plan) else float(motion.time[-1])
    disturbances.check_begins(length + STANDING)
    joints = track(motion, force=force, whole_body=whole_body) if isinstance(motion, Plan) else motion
    if whole_body is None:
        body = find_whole_body(joints.robot)
    else:
        body = whole_body if isinstance(whole_body, WholeBody) else load_whole_body(whole_body)
        body = equipped(body, joints.robot)
    if terrain is None and joints.terrain is not None and not joints.terrain.is_flat:
        terrain = joints.terrain
    return run(joints, body, disturbances, feedback=feedback, wheels=wheels, terrain=terrain)
