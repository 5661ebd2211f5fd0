"""A log as a film. Needs the extra `video`; only this file renders.

Draws without a window: MUJOCO_GL is set to `egl` where nothing else is said and there is no display.
"""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import FileError, InputError, MissingExtraError, RollgaitError
from rollgait.files import check_writable, replacing
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.log import SimulationLog

if TYPE_CHECKING:
    from rollgait.simulation.world import World

Array = NDArray[np.float64]

VIDEO_EXTRA: Final = "video"
"""The optional extra that brings what renders and encodes."""

FRAME_RATE: Final = 25.0
"""Frames per second."""

WIDTH: Final = 640
HEIGHT: Final = 480

AZIMUTH: Final = 55.0
ELEVATION: Final = -18.0
"""Where the camera looks, degrees: from behind and aside, so that risers ahead are seen."""

FORMATS: Final = (".mp4", ".gif", ".webp")
"""What a film can be written as. GIF and WebP move on a page by themselves; a WebP is smaller."""

PAGE_RATE: Final = 12.5
"""Frames per second of GIF and WebP: every second one of a film's."""

GIF_COLOURS: Final = 96
WEBP_QUALITY: Final = 40
"""Of 100: edges stay sharp, and twenty seconds stay near 1 MB."""

NEAR: Final = 0.05
FAR: Final = 60.0
"""What is drawn begins and ends this far from the camera, m: by the ground's 200 m the robot would be cut."""

DISTANCE: Final = 3.5
"""Of the camera from the robot, as a multiple of the height of its CoM."""

LOWERED: Final = 0.2
"""How far below the base link it looks, likewise: the feet are what the ground is about."""


class RenderingError(RollgaitError):
    """This machine cannot draw without a window."""

    exit_status = 1


def check_video(path: str | Path) -> None:
    """Raises if no film could be made or written at `path`: known before the long work, not after.

    Raises:
        InputError: the suffix is none of `FORMATS`.
        FileError: the place cannot be written to.
        MissingExtraError: the extra `video` is not installed.
        RenderingError: this machine cannot draw without a window.
    """
    target = Path(path)
    if target.suffix.lower() not in FORMATS:
        raise InputError("video", str(target), "must end in a known suffix", FORMATS)
    check_writable(target)
    try:
        import imageio_ffmpeg  # noqa: F401
        import OpenGL  # noqa: F401
        from imageio import v3  # noqa: F401
    except ImportError:
        raise MissingExtraError("a video", VIDEO_EXTRA) from None
    with _drawing():
        _choose_drawing()
        from mujoco.rendering.classic import gl_context

        gl_context.GLContext(WIDTH, HEIGHT).free()


def save_video(log: SimulationLog, path: str | Path, body: WholeBody) -> Path:
    """Writes a log as a film with a camera that follows the robot; returns its path.

    Raises:
        InputError, FileError, MissingExtraError: as `check_video`.
        RenderingError: this machine cannot draw without a window.
    """
    target = Path(path)
    check_video(target)
    frames = _frames(log, body)
    from imageio import v3

    with replacing(target) as temporary:
        try:
            if target.suffix.lower() == ".mp4":
                v3.imwrite(temporary, np.stack(frames), fps=FRAME_RATE, codec="libx264", macro_block_size=16)
            else:
                _write_moving_picture(frames[:: round(FRAME_RATE / PAGE_RATE)], temporary)
        except (RuntimeError, ValueError) as error:
            raise FileError("video", str(target), f"cannot be written: {error}") from None
    return target


def _write_moving_picture(frames: list[NDArray[np.uint8]], path: Path) -> None:
    from PIL import Image

    pictures = [Image.fromarray(frame) for frame in frames]
    how: dict[str, Any] = {"quality": WEBP_QUALITY, "method": 4}
    if path.suffix.lower() == ".gif":
        palette = pictures[len(pictures) // 2].quantize(GIF_COLOURS)  # one for all: what rests costs nothing
        pictures = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
        how = {"optimize": False}
    first, *others = pictures
    first.save(path, save_all=True, append_images=others, duration=round(1e3 / PAGE_RATE), loop=0, **how)


def _choose_drawing() -> None:
    """Draws with EGL where nothing else is said and there is no display, also if MuJoCo is loaded already."""
    if has_display() or "MUJOCO_GL" in os.environ:
        return
    os.environ["MUJOCO_GL"] = "egl"
    loaded = sys.modules.get("mujoco.rendering.classic.gl_context")
    if loaded is not None:
        importlib.reload(loaded)  # it has chosen when it was loaded


@contextmanager
def _drawing() -> Iterator[None]:
    """What OpenGL raises, as our error; what it warns of before is in there."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except Exception as error:  # it raises what it likes
        how = os.environ.get("MUJOCO_GL", "")
        raise RenderingError(
            f"no video: this machine cannot draw without a window (MUJOCO_GL={how}): {error}; "
            "install libegl1 or libosmesa6 and set MUJOCO_GL to egl or osmesa"
        ) from None


def has_display() -> bool:
    """Whether a window can be opened here."""
    return sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _frames(log: SimulationLog, body: WholeBody) -> list[NDArray[np.uint8]]:
    import mujoco

    world = world_of(log, body)
    data = mujoco.MjData(world.model)
    world.model.stat.extent = 1.0  # of which near and far are multiples
    world.model.vis.map.znear, world.model.vis.map.zfar = NEAR, FAR
    world.model.vis.quality.shadowsize = 0
    world.model.vis.quality.offsamples = 1  # multisampling in software costs most of the time
    world.model.vis.headlight.ambient[:] = 0.4
    with _drawing():
        renderer = mujoco.Renderer(world.model, HEIGHT, WIDTH)
    frames = []
    try:
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            renderer.scene.flags[flag] = False
        for k in np.searchsorted(log.time, np.arange(0.0, log.time[-1], 1.0 / FRAME_RATE)):
            put(log, int(k), world, data)
            mujoco.mj_forward(world.model, data)
            renderer.update_scene(data, _camera(log, data.qpos[:3]))
            frames.append(renderer.render())
    finally:
        renderer.close()
    return frames


def world_of(log: SimulationLog, body: WholeBody) -> World:
    """The world of a log, to be looked at."""
    from rollgait.simulation.world import build_world

    return build_world(
        body,
        log.joint_names,
        log.disturbances,
        ground_height=log.ground_height,
        terrain=log.terrain,
        about=log.base_position[0, :2],
        visual=True,
    )


def put(log: SimulationLog, k: int, world: World, data: Any) -> None:
    """Puts the robot where it is in a sample of the log."""
    world.put(data, log.base_position[k], log.base_quaternion[k], log.joint_position[k])


def _camera(log: SimulationLog, p_base: Array) -> Any:
    import mujoco

    camera = mujoco.MjvCamera()
    height = max(log.robot.height, 0.2)
    camera.lookat[:] = p_base - np.array([0.0, 0.0, LOWERED * height])
    camera.distance = DISTANCE * height
    camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
    return camera
