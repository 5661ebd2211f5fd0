"""Recordings: a clip as one page that opens offline, with its own timeline."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Final

from rollgait.files import replacing
from rollgait.robot.robot import LEG_NAMES
from rollgait.view.camera import aim, camera_of
from rollgait.view.clip import Clip
from rollgait.view.layers.layer import GHOST
from rollgait.view.lights import add_lights
from rollgait.view.scene import Scene
from rollgait.view.server import LOOPBACK, start_server, stop_server
from rollgait.view.style import LEG_COLOURS, MARK_COLOUR

RATE: Final = 25.0
"""Frames per second of a page: fewer look jerky, more make the file large."""


def record_page(clip: Clip, path: str | Path, ghost: Clip | None = None) -> Path:
    """Writes a clip as one HTML file that needs nothing else; returns its path.

    Raises:
        FileError: the path cannot be written to.
    """
    server = start_server(LOOPBACK, 0, clip.name)
    try:
        aim(server, camera_of(clip))
        add_lights(server.scene)
        scenes = [Scene(server.scene, "/motion", clip)]
        if ghost is not None:
            scenes.append(Scene(server.scene, "/ghost", ghost, GHOST))
        frames = round(clip.horizon * RATE)
        for scene in scenes:  # viser keeps the arrays of what is there by reference: all must change at t = 0
            scene.show(clip.horizon)
        serializer = server.get_scene_serializer()
        for frame in range(frames + 1):
            for scene in scenes:
                scene.show(clip.horizon * frame / frames)
            serializer.insert_sleep(clip.horizon / frames)
        page = serializer.as_html()
    finally:
        stop_server(server)
    target = Path(path)
    with replacing(target) as temporary:
        temporary.write_text(_captioned(page, clip, ghost), encoding="utf-8")
    return target


def _captioned(page: str, clip: Clip, ghost: Clip | None) -> str:
    """The page with its title, and a caption that says what is seen."""
    page = page.replace("<title>Viser</title>", f"<title>{escape(clip.name)}</title>", 1)
    end = page.rindex("</body>")
    return page[:end] + _caption(clip, ghost) + page[end:]


def _caption(clip: Clip, ghost: Clip | None) -> str:
    colour = "#2E7D32" if clip.passed else MARK_COLOUR
    legs = " ".join(
        f'<span style="color:{shade}">&#9632; {name}</span>'
        for name, shade in zip(LEG_NAMES, LEG_COLOURS, strict=True)
    )
    behind = f"<br>ghost: {escape(ghost.name)}" if ghost is not None else ""
    text = clip.plan.scenario.description if clip.plan is not None else ""
    described = f"<br>{escape(text)}" if text else ""
    return (
        '<div style="position:fixed;right:16px;top:14px;z-index:5;pointer-events:none;color:#222;'
        "font:14px/1.5 system-ui,sans-serif;background:rgba(255,255,255,0.8);"
        'padding:6px 12px;border-radius:6px">'
        f"<b>{escape(clip.name)}</b> · {escape(clip.robot.name)} · {clip.horizon:.4g} s{described}<br>"
        f'<span style="color:{colour};font-weight:600">{escape(clip.verdict)}</span>{behind}'
        f"<br><b>{legs}</b></div>"
    )
