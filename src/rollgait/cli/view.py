"""`rollgait view`: a page with a motion."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.errors import InputError
from rollgait.view.recordings import need_view

if TYPE_CHECKING:
    from rollgait.view.clip import Clip

MotionFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="A plan, a joint trajectory or a log (.npz).")
]
Port = Annotated[str, typer.Option(metavar="PORT", help="Port of the page; 0 takes a free one.")]
DEFAULT_PORT = "8080"
FIRST = "hybrid-forward"
"""Scenario that the page begins with if no file is given."""
LOOPBACK = "127.0.0.1"


def view(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]",
            help="A plan, a joint trajectory or a log (.npz), or a scenario (.yaml) to be planned. "
            f"Default: the scenario {FIRST}.",
        ),
    ] = None,
    compare: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Another one, to be shown as a ghost.")
    ] = None,
    port: Port = DEFAULT_PORT,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Address to listen on; by default this machine only.")
    ] = LOOPBACK,
) -> None:
    """Show a motion in the browser; plan the next one.

    Scrub through it, see its certificate, compare it. Runs until Ctrl-C.
    """
    number = port_from(port)
    need_view("the viewer")
    from rollgait.view.entry import view as open_view
    from rollgait.view.gate.access import is_loopback

    viewer = open_view(_first() if file is None else file, compare, host=host, port=number)
    print(f"{viewer.clip.name}: {viewer.clip.verdict}")
    print(f"open {viewer.url} in a browser; Ctrl-C ends")
    if not is_loopback(host):
        print("note: whoever knows this address sees this motion and can plan with this machine")
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        print()
    finally:
        viewer.close()


def _first() -> Clip:
    from rollgait.scenario import find_scenario
    from rollgait.view.standing_clip import clip_of_scenario

    return clip_of_scenario(find_scenario(FIRST), FIRST)


def port_from(text: str) -> int:
    """A port. Raises `InputError`."""
    if not text.isascii() or not text.isdigit():
        raise InputError("port", text, "must be a whole number within [0, 65535]; 0 takes a free one")
    return int(text)
