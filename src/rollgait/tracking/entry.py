"""`track`: the door to this package. Refuses what must not be executed before anything heavy is loaded."""

from __future__ import annotations

from pathlib import Path

from rollgait.errors import MissingExtraError, NotCertifiedError, UnknownNameError
from rollgait.plan.plan import Plan
from rollgait.robot.whole_body import EXTRA, WholeBody, equipped, find_whole_body, load_whole_body
from rollgait.tracking.joints import JointTrajectory

WAISTS = ("com", "base")
"""What the third level holds in place."""


def track(
    plan: Plan,
    rate: float = 200.0,
    *,
    force: bool = False,
    waist: str = "com",
    whole_body: WholeBody | str | Path | None = None,
) -> JointTrajectory:
    """Joint angles, velocities and feed-forward torques that execute a plan.

    Strict priorities: contact points / wheel rolling and foot orientation / waist / posture, under the limits
    of joint positions and velocities (hierarchical inverse kinematics of the paper).

    Args:
        plan: the plan. Its certificate must pass.
        rate: steps per second, Hz.
        force: track the plan even if its certificate fails.
        waist: `com` holds the centre of mass at its plan; `base` the base link at a constant offset from it,
            as if the legs had no mass: 20 to 26 mm off in the stepping motions.
        whole_body: the whole body, or the YAML file that describes it; the robot's own if not given.

    Returns:
        The joint trajectory, with a report of how well it follows the plan.

    Raises:
        NotCertifiedError: the certificate fails, and `force` is not set.
        InputError: there is no whole-body model of the robot, it cannot stand as the plan begins, or numbers
            of the plan are none.
        MissingExtraError: the extra `whole-body` is not installed.
    """
    if waist not in WAISTS:
        raise UnknownNameError("waist", waist, WAISTS)
    plan.require_numbers()
    if not force:
        refuse_uncertified(plan)
    if whole_body is None:
        body = find_whole_body(plan.robot)
    else:
        body = whole_body if isinstance(whole_body, WholeBody) else load_whole_body(whole_body)
        body = equipped(body, plan.robot)
    try:
        import daqp  # noqa: F401
        import pinocchio  # noqa: F401
    except ImportError:
        raise MissingExtraError("tracking a plan", EXTRA) from None
    from rollgait.tracking.tracker import follow

    return follow(plan, body, rate, waist)


def refuse_uncertified(plan: Plan) -> None:
    """Raises `NotCertifiedError` unless the solver converged and the certificate passes."""
    failures = plan.certificate().failures
    if plan.solved and not failures:
        return
    rows = ", ".join(row.name for row in failures) or "the solver did not converge"
    raise NotCertifiedError(
        f"the plan is not certified ({rows}); executed, it may fall: --force tracks it anyway"
    )
