"""rollgait: motion generation for legged robots on wheels.

>>> import rollgait as rg
>>> plan = rg.plan("hybrid-forward")        # doctest: +SKIP
>>> plan.certificate().passed               # doctest: +SKIP
True
"""

from rollgait.diagnosis.entry import diagnose
from rollgait.diagnosis.report import Diagnosis, Reason, Suggestion
from rollgait.errors import InputError, NotSolvedError, RollgaitError
from rollgait.many import Outcome, plan_many
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.setup import make_loop
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import Constraint, Cost, FootConstraint
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.planner import plan
from rollgait.robot.library import find_robot, robot_names
from rollgait.robot.robot import Robot
from rollgait.scenario.library import find_scenario, scenario_names
from rollgait.scenario.scenario import Scenario
from rollgait.simulation import Disturbances, SimulationLog, simulate
from rollgait.tracking import JointTrajectory, track

__version__ = "0.1.0"

__all__ = [
    "Constraint",
    "Cost",
    "Diagnosis",
    "Disturbances",
    "Foot",
    "FootConstraint",
    "InputError",
    "Instant",
    "JointTrajectory",
    "Mpc",
    "NotSolvedError",
    "Outcome",
    "Plan",
    "PoseCommand",
    "Reason",
    "Robot",
    "RollgaitError",
    "Samples",
    "Scenario",
    "SimulationLog",
    "Suggestion",
    "VelocityCommand",
    "diagnose",
    "find_robot",
    "find_scenario",
    "make_loop",
    "plan",
    "plan_many",
    "robot_names",
    "scenario_names",
    "simulate",
    "track",
]
