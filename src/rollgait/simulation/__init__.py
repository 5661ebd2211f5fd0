"""From joints to physics: the whole body executes a plan in MuJoCo, and a report says how well.

Needs the extra `whole-body`; importing this package does not load it, `simulate` does.
"""

from rollgait.plant.disturbances import Disturbances, Payload, Push
from rollgait.simulation.entry import simulate
from rollgait.simulation.log import SimulationLog
from rollgait.simulation.report import JointUse, SimulationReport

__all__ = [
    "Disturbances",
    "JointUse",
    "Payload",
    "Push",
    "SimulationLog",
    "SimulationReport",
    "simulate",
]
