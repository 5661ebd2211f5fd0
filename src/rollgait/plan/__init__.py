"""The result: a plan, its samples, its certificate."""

from rollgait.plan.plan import Plan, Statistics
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import Trajectory

__all__ = ["Plan", "Samples", "Statistics", "Trajectory"]
