"""What is asked: scenarios, gaits, ground, weights and bounds."""

from rollgait.scenario.gait import Crawl, Discover, Drive, Pace, Schedule, Trot, Walk
from rollgait.scenario.library import find_scenario, scenario_names
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.scenario import Goal, LaterGoal, Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.scenario.start import Start
from rollgait.scenario.weights import Bounds, Weights

__all__ = [
    "Bounds",
    "ContactSchedule",
    "Crawl",
    "Discover",
    "Drive",
    "Goal",
    "LaterGoal",
    "Mesh",
    "Pace",
    "Scenario",
    "Schedule",
    "Start",
    "Trot",
    "Walk",
    "Weights",
    "find_scenario",
    "scenario_names",
]
