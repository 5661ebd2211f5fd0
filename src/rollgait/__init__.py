"""rollgait: motion generation for legged robots on wheels."""

from rollgait.plan.plan import Plan
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario

__version__ = "0.1.0"
