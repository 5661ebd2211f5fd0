"""The scenarios of the library by their ground and their robot."""

from __future__ import annotations

from rollgait.scenario import find_scenario, scenario_names

TERRAIN = [name for name in scenario_names() if find_scenario(name).ground.kind != "flat"]
"""Those over ground that is not flat."""
OTHER_ROBOTS = [name for name in scenario_names() if find_scenario(name).robot != "centauro"]
"""Those of the other robots, on flat ground."""
FLAT = [name for name in scenario_names() if name not in TERRAIN + OTHER_ROBOTS]
"""The paper's motions."""
