"""`rg.view`: the viewer from Python, and what a notebook shows of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rollgait.view.recordings import need_view

if TYPE_CHECKING:
    from rollgait.view.viewer import Viewer

__all__ = ["view"]


def view(motion: Any, compare: Any = None, *, host: str = "127.0.0.1", port: int = 0) -> Viewer:
    """Opens the viewer of a motion at `url`, which lives until `close` or the end of the program.

    As the last line of a notebook's cell it is the page itself, with a link to it below, where the notebook
    runs in a browser of this machine; elsewhere the link. It ends with the program: what stays in a notebook
    that is saved is `rg.record`.

    Args:
        motion: a plan, joints, a simulation, a run of the controller, a scenario, or the file of one.
        compare: another one to show as a ghost.
        host: address to listen on.
        port: 0 takes a free one.

    Raises:
        InputError: a file is not what it should be, or the port cannot be had.
        MissingExtraError: the extra `view` is not installed.
    """
    need_view("the viewer")
    from rollgait.view.opening import clip_of
    from rollgait.view.viewer import Viewer

    return Viewer(clip_of(motion), None if compare is None else clip_of(compare), host, port)
