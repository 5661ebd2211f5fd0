"""The scenarios of the library by their ground."""

from __future__ import annotations

from rollgait.scenario import find_scenario, scenario_names

FLAT = [name for name in scenario_names() if find_scenario(name).ground.kind == "flat"]
"""The paper's motions."""
TERRAIN = [name for name in scenario_names() if name not in FLAT]
"""Those over ground that is not flat."""
IN_A_FILE = [name for name in TERRAIN if find_scenario(name).ground.map is not None]
"""Those whose ground is a map: what `show` prints of them needs the file beside it."""
