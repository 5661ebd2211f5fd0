"""The scenarios of the library by their ground."""

from __future__ import annotations

from rollgait.scenario import find_scenario, scenario_names

FLAT = [name for name in scenario_names() if find_scenario(name).ground.kind == "flat"]
"""The paper's motions."""
TERRAIN = [name for name in scenario_names() if name not in FLAT]
"""Those over ground that is not flat."""
