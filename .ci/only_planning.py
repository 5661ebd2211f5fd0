"""Fails if this environment holds what only the extras need: planning alone must stay small."""

import sys
from importlib.metadata import distributions

BEYOND_PLANNING = {"pin", "pinocchio", "libpinocchio", "mujoco", "mujoco-core", "viser"}

installed = {(d.metadata["Name"] or "").lower() for d in distributions()}
surplus = sorted(installed & BEYOND_PLANNING)
if surplus:
    sys.exit(f"error: the wheel alone installs {', '.join(surplus)}")
