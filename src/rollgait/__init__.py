"""rollgait: motion generation for legged robots on wheels.

>>> import rollgait as rg
>>> plan = rg.plan("hybrid-forward")        # doctest: +SKIP
>>> plan.certificate().passed               # doctest: +SKIP
True
"""

from typing import TYPE_CHECKING

from rollgait.lazy import lazy_names

if TYPE_CHECKING:
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
    from rollgait.planner import Planner, plan
    from rollgait.robot.importing import import_robot
    from rollgait.robot.library import find_robot, robot_names
    from rollgait.robot.robot import Robot
    from rollgait.scenario.library import find_scenario, scenario_names
    from rollgait.scenario.scenario import Scenario
    from rollgait.searching import search_steps
    from rollgait.simulation import Disturbances, SimulationLog, simulate
    from rollgait.terrain.terrain import Terrain
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
    "Planner",
    "PoseCommand",
    "Reason",
    "Robot",
    "RollgaitError",
    "Samples",
    "Scenario",
    "SimulationLog",
    "Suggestion",
    "Terrain",
    "VelocityCommand",
    "diagnose",
    "find_robot",
    "find_scenario",
    "import_robot",
    "make_loop",
    "plan",
    "plan_many",
    "robot_names",
    "scenario_names",
    "search_steps",
    "simulate",
    "track",
]

if not TYPE_CHECKING:  # a type checker would take every misspelt name for one of `Any`
    # each name is loaded when it is first asked for: the same imports as above, as a test holds
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "Constraint": "ocp.term",
            "Cost": "ocp.term",
            "Diagnosis": "diagnosis.report",
            "Disturbances": "simulation",
            "Foot": "ocp.instant",
            "FootConstraint": "ocp.term",
            "InputError": "errors",
            "Instant": "ocp.instant",
            "JointTrajectory": "tracking",
            "Mpc": "mpc.mpc",
            "NotSolvedError": "errors",
            "Outcome": "many",
            "Plan": "plan.plan",
            "Planner": "planner",
            "PoseCommand": "mpc.command",
            "Reason": "diagnosis.report",
            "Robot": "robot.robot",
            "RollgaitError": "errors",
            "Samples": "plan.samples",
            "Scenario": "scenario.scenario",
            "SimulationLog": "simulation",
            "Suggestion": "diagnosis.report",
            "Terrain": "terrain.terrain",
            "VelocityCommand": "mpc.command",
            "diagnose": "diagnosis.entry",
            "find_robot": "robot.library",
            "find_scenario": "scenario.library",
            "import_robot": "robot.importing",
            "make_loop": "mpc.setup",
            "plan": "planner",
            "plan_many": "many",
            "robot_names": "robot.library",
            "scenario_names": "scenario.library",
            "search_steps": "searching",
            "simulate": "simulation",
            "track": "tracking",
        },
    )
