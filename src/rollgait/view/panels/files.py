"""Files that the page opens, saves and exports."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any, Final

import viser

from rollgait.export import FORMATS
from rollgait.view.clip import Clip
from rollgait.view.exports import RECORDINGS
from rollgait.view.meshes import whole_body_of
from rollgait.view.panels.design.fields import by_a_person

COPY: Final = (
    "const t=this.parentNode.querySelector('textarea');t.select();"
    "(navigator.clipboard?navigator.clipboard.writeText(t.value):Promise.reject())"
    ".catch(()=>document.execCommand('copy'));this.textContent='Copied'"
)
"""The clipboard is only for pages of this machine; elsewhere the older way may still work."""
BUTTON: Final = (
    "width:100%;padding:5px;border:0;border-radius:2px;background:#868e96;color:#fff;"
    "font:inherit;cursor:pointer"
)
TEXT: Final = (
    "width:100%;height:11em;margin-top:4px;resize:vertical;white-space:pre;overflow:auto;"
    "font:11px ui-monospace,monospace;color:inherit;background:transparent;border:1px solid #8886"
)


class FilesPanel:
    """Buttons.

    Args:
        gui: of the page.
        opened: takes a file, and whether it is for comparison.
        track: finds the whole body.
        alone: takes the ghost away.
        save_plan, save_scenario: send their file to a browser.
        export: sends the motion in a format to a browser.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        opened: Callable[[Any, bool], None],
        track: Callable[[], None],
        alone: Callable[[], None],
        save_plan: Callable[[viser.ClientHandle], None],
        save_scenario: Callable[[viser.ClientHandle], None],
        export: Callable[[viser.ClientHandle, str], None],
    ) -> None:
        upload = gui.add_upload_button(
            "Open a plan, joints, a log or a scenario",
            icon=viser.Icon.FOLDER_OPEN,
            mime_type=".npz,.yaml,.yml,.zip",
            color="gray",
        )
        compared = gui.add_upload_button(
            "Compare with", icon=viser.Icon.GHOST, mime_type=".npz", color="gray"
        )
        self._no_ghost = gui.add_button("Take the ghost away", icon=viser.Icon.GHOST_OFF, color="gray")
        self.whole_body = gui.add_button(
            "Find the whole body", icon=viser.Icon.ROBOT, color="gray", hint="Joints that follow the plan"
        )
        self._note = gui.add_markdown("")
        scenario = gui.add_button("Save scenario", icon=viser.Icon.DOWNLOAD, color="gray")
        self._plan = gui.add_button("Save plan", icon=viser.Icon.DOWNLOAD, color="gray")
        self.format: Any = gui.add_dropdown("format", (*FORMATS, *RECORDINGS))
        self._export = gui.add_button("Export", icon=viser.Icon.FILE_EXPORT, color="gray")
        self._python = gui.add_html("")
        upload.on_upload(lambda event: opened(event.target.value, False))
        compared.on_upload(lambda event: opened(event.target.value, True))
        self._no_ghost.on_click(lambda _: alone())
        self.whole_body.on_click(lambda _: track())
        self._plan.on_click(by_a_person(save_plan))
        scenario.on_click(by_a_person(save_scenario))
        self._export.on_click(by_a_person(lambda client: export(client, str(self.format.value))))

    def build(self, clip: Clip, ghost: Clip | None) -> None:
        """Shows what can be done with a clip."""
        self.whole_body.visible = (
            clip.plan is not None and clip.joints is None and whole_body_of(clip.robot) is not None
        )
        self._no_ghost.visible = ghost is not None
        self._plan.disabled = clip.plan is None
        self._export.disabled = clip.kind == "scenario"

    def show_python(self, text: str) -> None:
        """The draft as a program, to be copied."""
        self._python.content = (
            f'<div style="margin:0.4em 0.75em;font:12.5px system-ui,sans-serif">'
            f'<button style="{BUTTON}" onclick="{escape(COPY)}">Copy as Python</button>'
            f'<textarea readonly aria-label="Python" style="{TEXT}">{escape(text)}</textarea></div>'
        )

    def note(self, text: str) -> None:
        """Says what came of a file."""
        self._note.content = _plain(text)


def _plain(text: str) -> str:
    """Text as Markdown that means nothing but itself."""
    return "".join(f"\\{letter}" if letter in "\\`*_{}[]<>()#+-.!|&" else letter for letter in text)
