"""What moves: the robot's data, and the library of robots."""

from rollgait.robot.library import find_robot, robot_names
from rollgait.robot.robot import GRAVITY, LEG_NAMES, Inertia, Leg, Legs, Limb, Robot

__all__ = ["GRAVITY", "LEG_NAMES", "Inertia", "Leg", "Legs", "Limb", "Robot", "find_robot", "robot_names"]
