"""rollgait: motion generation for legged robots on wheels.

>>> import rollgait as rg
>>> plan = rg.plan("hybrid-forward")        # doctest: +SKIP
>>> plan.certificate().passed               # doctest: +SKIP
True
"""

from typing import TYPE_CHECKING

from rollgait.lazy import lazy_names

if TYPE_CHECKING:
    from rollgait.dataset.dataset import Dataset
    from rollgait.dataset.running import plan_dataset
    from rollgait.diagnosis.entry import diagnose
    from rollgait.diagnosis.report import Diagnosis, Reason, Suggestion
    from rollgait.errors import InputError, NotSolvedError, RollgaitError
    from rollgait.many import Outcome, plan_many
    from rollgait.mpc.command import PoseCommand, VelocityCommand
    from rollgait.mpc.mpc import Mpc
    from rollgait.mpc.setup import make_loop
    from rollgait.ocp.instant import Foot, Instant
    from rollgait.ocp.term import Constraint, Cost, FootConstraint
    from rollgait.plan.certificate import Certificate
    from rollgait.plan.plan import Plan
    from rollgait.plan.samples import Samples
    from rollgait.planner import Planner, plan
    from rollgait.plant.control import Control
    from rollgait.plant.disturbances import Payload, Push
    from rollgait.plant.moving import MotionState
    from rollgait.plant.state import RobotState
    from rollgait.robot.importing import import_robot
    from rollgait.robot.library import find_robot, robot_names
    from rollgait.robot.loads import Load, Loads, Wrench
    from rollgait.robot.robot import Robot
    from rollgait.scenario.gait import Crawl, Drive, Pace, Schedule, Trot, Walk
    from rollgait.scenario.library import find_scenario, scenario_names
    from rollgait.scenario.scenario import Goal, LaterGoal, Scenario
    from rollgait.scenario.start import Start
    from rollgait.scenario.weights import Bounds, Weights
    from rollgait.searching import search_steps
    from rollgait.simulation import Disturbances, SimulationLog, simulate
    from rollgait.terrain.ground import Ground
    from rollgait.terrain.terrain import Terrain
    from rollgait.timing.worth import timing_gradient
    from rollgait.tracking import JointTrajectory, track
    from rollgait.view.entry import view
    from rollgait.view.record import Recording, record

__version__ = "0.1.0"

__all__ = [
    "Bounds",
    "Certificate",
    "Constraint",
    "Control",
    "Cost",
    "Crawl",
    "Dataset",
    "Diagnosis",
    "Disturbances",
    "Drive",
    "Foot",
    "FootConstraint",
    "Goal",
    "Ground",
    "InputError",
    "Instant",
    "JointTrajectory",
    "LaterGoal",
    "Load",
    "Loads",
    "MotionState",
    "Mpc",
    "NotSolvedError",
    "Outcome",
    "Pace",
    "Payload",
    "Plan",
    "Planner",
    "PoseCommand",
    "Push",
    "Reason",
    "Recording",
    "Robot",
    "RobotState",
    "RollgaitError",
    "Samples",
    "Scenario",
    "Schedule",
    "SimulationLog",
    "Start",
    "Suggestion",
    "Terrain",
    "Trot",
    "VelocityCommand",
    "Walk",
    "Weights",
    "Wrench",
    "diagnose",
    "find_robot",
    "find_scenario",
    "import_robot",
    "make_loop",
    "plan",
    "plan_dataset",
    "plan_many",
    "record",
    "robot_names",
    "scenario_names",
    "search_steps",
    "simulate",
    "timing_gradient",
    "track",
    "view",
]

if not TYPE_CHECKING:  # a type checker would take every misspelt name for one of `Any`
    # each name is loaded when it is first asked for: the same imports as above, as a test holds
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "Bounds": "scenario.weights",
            "Certificate": "plan.certificate",
            "Constraint": "ocp.term",
            "Control": "plant.control",
            "Cost": "ocp.term",
            "Crawl": "scenario.gait",
            "Dataset": "dataset.dataset",
            "Diagnosis": "diagnosis.report",
            "Disturbances": "simulation",
            "Drive": "scenario.gait",
            "Foot": "ocp.instant",
            "FootConstraint": "ocp.term",
            "Goal": "scenario.scenario",
            "Ground": "terrain.ground",
            "InputError": "errors",
            "Instant": "ocp.instant",
            "JointTrajectory": "tracking",
            "LaterGoal": "scenario.scenario",
            "Load": "robot.loads",
            "Loads": "robot.loads",
            "MotionState": "plant.moving",
            "Mpc": "mpc.mpc",
            "NotSolvedError": "errors",
            "Outcome": "many",
            "Pace": "scenario.gait",
            "Payload": "plant.disturbances",
            "Plan": "plan.plan",
            "Planner": "planner",
            "PoseCommand": "mpc.command",
            "Push": "plant.disturbances",
            "Reason": "diagnosis.report",
            "Recording": "view.record",
            "Robot": "robot.robot",
            "RobotState": "plant.state",
            "RollgaitError": "errors",
            "Samples": "plan.samples",
            "Scenario": "scenario.scenario",
            "Schedule": "scenario.gait",
            "SimulationLog": "simulation",
            "Start": "scenario.start",
            "Suggestion": "diagnosis.report",
            "Terrain": "terrain.terrain",
            "Trot": "scenario.gait",
            "VelocityCommand": "mpc.command",
            "Walk": "scenario.gait",
            "Weights": "scenario.weights",
            "Wrench": "robot.loads",
            "diagnose": "diagnosis.entry",
            "find_robot": "robot.library",
            "find_scenario": "scenario.library",
            "import_robot": "robot.importing",
            "make_loop": "mpc.setup",
            "plan": "planner",
            "plan_dataset": "dataset.running",
            "plan_many": "many",
            "record": "view.record",
            "robot_names": "robot.library",
            "scenario_names": "scenario.library",
            "search_steps": "searching",
            "simulate": "simulation",
            "timing_gradient": "timing.worth",
            "track": "tracking",
            "view": "view.entry",
        },
    )
