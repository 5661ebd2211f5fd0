"""Clips as moving pictures and as stills, drawn without a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from PIL import Image
from viser import SceneApi

from rollgait.errors import MissingExtraError
from rollgait.files import replacing
from rollgait.view.camera import camera_of
from rollgait.view.clip import Clip
from rollgait.view.layers.layer import GHOST
from rollgait.view.scene import Scene
from rollgait.view.software import SoftwareScene, render

VIDEO_RATE: Final = 25.0
GIF_RATE: Final = 10.0
"""Frames per second; a GIF counts in hundredths of a second, and grows fast."""
VIDEO_SIZE: Final = (1280, 720)
GIF_SIZE: Final = (560, 316)
"""Width and height, pixels."""
GIF_COLOURS: Final = 64


def record_video(clip: Clip, path: str | Path, ghost: Clip | None = None) -> Path:
    """Writes a clip as MP4 (H.264); returns its path.

    Raises:
        MissingExtraError: the extra `video` is not installed.
        FileError: the path cannot be written to.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise MissingExtraError("a recording as mp4", "video") from None
    target = Path(path)
    with replacing(target) as temporary:
        writer: Any = imageio_ffmpeg.write_frames(
            str(temporary), VIDEO_SIZE, fps=VIDEO_RATE, codec="libx264", quality=7, macro_block_size=1
        )
        writer.send(None)
        for picture in pictures(clip, VIDEO_RATE, VIDEO_SIZE, ghost):
            writer.send(np.asarray(picture).tobytes())
        writer.close()
    return target


def record_gif(clip: Clip, path: str | Path, ghost: Clip | None = None) -> Path:
    """Writes a clip as an animated GIF; returns its path. Raises `FileError` if it cannot be written."""
    full = list(pictures(clip, GIF_RATE, GIF_SIZE, ghost))
    palette = full[len(full) // 2].quantize(GIF_COLOURS)  # one for all, so that what rests costs nothing
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in full]
    target = Path(path)
    with replacing(target) as temporary:
        frames[0].save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=frames[1:],
            duration=round(1000.0 / GIF_RATE),
            loop=0,
            optimize=False,
        )
    return target


def still(clip: Clip, time: float, size: tuple[int, int] = VIDEO_SIZE, caption: bool = False) -> Image.Image:
    """A picture of a clip at a time (s)."""
    api = SoftwareScene(clip.terrain)
    Scene(cast(SceneApi, api), "/motion", clip).show(time)
    return render(api, camera_of(clip), size, _caption(clip, time) if caption else "")


def pictures(
    clip: Clip, rate: float, size: tuple[int, int], ghost: Clip | None = None
) -> Iterator[Image.Image]:
    """All pictures of a clip at a rate (Hz)."""
    api = SoftwareScene(clip.terrain)
    scenes = [Scene(cast(SceneApi, api), "/motion", clip)]
    if ghost is not None:
        scenes.append(Scene(cast(SceneApi, api), "/ghost", ghost, GHOST))
    camera, count = camera_of(clip), max(2, round(clip.horizon * rate))
    for time in np.linspace(0.0, clip.horizon, count):
        for scene in scenes:
            scene.show(float(time))
        yield render(api, camera, size, _caption(clip, float(time)))


def _caption(clip: Clip, time: float) -> str:
    mark = "" if clip.passed else f", {clip.verdict}"
    return f"{clip.name}{mark}\n{time:.1f} s"
