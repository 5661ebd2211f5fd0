"""The result: a plan, its samples, its certificate."""

from rollgait.plan.condensed import CondensedTrajectory
from rollgait.plan.plan import Plan, Statistics
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import CollocationTrajectory, Trajectory

# Importing a class of trajectories is what makes `Plan.load` know its files.
__all__ = ["CollocationTrajectory", "CondensedTrajectory", "Plan", "Samples", "Statistics", "Trajectory"]
