"""A log in MuJoCo's own window, where there is a display."""

from __future__ import annotations

import time as clock
from typing import Final

from rollgait.errors import MISSING, InputError, MissingExtraError
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.log import SimulationLog
from rollgait.simulation.video import VIDEO_EXTRA, has_display, put, world_of

FRAME_PERIOD: Final = 0.02
"""Time between two pictures, s."""


def check_viewer() -> None:
    """Raises if no window can be opened here.

    Raises:
        InputError: there is no display.
        MissingExtraError: MuJoCo's viewer is not installed.
    """
    if not has_display():
        raise InputError("viewer", MISSING, "needs a display, and there is none here; --video writes a film")
    try:
        import glfw  # noqa: F401
    except ImportError:
        raise MissingExtraError("MuJoCo's window", VIDEO_EXTRA) from None


def show(log: SimulationLog, body: WholeBody) -> None:
    """Plays a log in a window, in real time, until the window is closed. Raises as `check_viewer`."""
    check_viewer()
    import mujoco
    import mujoco.viewer

    world = world_of(log, body)
    data = mujoco.MjData(world.model)
    with mujoco.viewer.launch_passive(world.model, data) as window:
        begin = clock.perf_counter()
        while window.is_running():
            now = (clock.perf_counter() - begin) % (float(log.time[-1]) + 1.0)
            put(log, min(int(log.time.searchsorted(now)), len(log.time) - 1), world, data)
            mujoco.mj_forward(world.model, data)
            window.sync()
            clock.sleep(FRAME_PERIOD)
