"""The result: a plan, its samples, its certificate."""

from typing import TYPE_CHECKING

from rollgait.lazy import lazy_names

if TYPE_CHECKING:
    from rollgait.plan.condensed import CondensedTrajectory
    from rollgait.plan.plan import Plan, Statistics
    from rollgait.plan.samples import Samples
    from rollgait.plan.trajectory import CollocationTrajectory, Trajectory

__all__ = ["CollocationTrajectory", "CondensedTrajectory", "Plan", "Samples", "Statistics", "Trajectory"]

if not TYPE_CHECKING:  # `rollgait` itself imports this package
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "CollocationTrajectory": "trajectory",
            "CondensedTrajectory": "condensed",
            "Plan": "plan",
            "Samples": "samples",
            "Statistics": "plan",
            "Trajectory": "trajectory",
        },
    )
