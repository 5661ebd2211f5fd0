"""`--bridge`: a run shown live on the topics of ROS 2, and to Foxglove."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Final

import typer

if TYPE_CHECKING:
    from rollgait.hardware.transports.elsewhere import Line, TransportProcess
    from rollgait.hardware.transports.reach import Reach
    from rollgait.hardware.window import Showing
    from rollgait.mpc.loop import ClosedLoop

FOXGLOVE_PORT: Final = 8765
"""That Foxglove looks at first."""

Bridged = Annotated[
    bool,
    typer.Option("--bridge", help="Show the run live on the topics of ROS 2, no faster than real time."),
]
Domain = Annotated[
    int | None, typer.Option(metavar="N", help="Domain of ROS 2. Default: ROS_DOMAIN_ID, or 0.")
]
WithFoxglove = Annotated[
    bool, typer.Option("--foxglove", help="Say everything to Foxglove as well, on a WebSocket.")
]
FoxglovePort = Annotated[
    int | None,
    typer.Option(
        metavar="PORT", min=0, max=65535, help=f"Its port; 0 takes a free one. Default: {FOXGLOVE_PORT}."
    ),
]
FoxgloveCommands = Annotated[
    bool,
    typer.Option("--foxglove-commands", help="Take commands from Foxglove: from any page on this machine."),
]


def reach_from(domain: int | None, foxglove: bool, port: int | None, commands: bool = False) -> Reach:
    """Which transports the options ask for. Raises what is wrong, and which extra is missing."""
    from rollgait.errors import InputError
    from rollgait.hardware.topics import types

    types()
    from rollgait.hardware.transports.reach import reach_of

    if port is not None and not (foxglove or commands):
        raise InputError("foxglove-port", port, "goes with --foxglove")
    return reach_of(domain, foxglove, FOXGLOVE_PORT if port is None else port, commands)


def reach_if(
    bridge: bool, domain: int | None, foxglove: bool, port: int | None, commands: bool = False
) -> Reach | None:
    """The same where `--bridge` was given; None where it was not, and nothing that goes with it."""
    from rollgait.errors import InputError

    if bridge:
        return reach_from(domain, foxglove, port, commands)
    options = {"domain": domain, "foxglove": foxglove, "foxglove-port": port, "foxglove-commands": commands}
    for name, value in options.items():
        if value is not None and value is not False:
            raise InputError(name, value, "goes with --bridge")
    return None


@contextmanager
def opened(reach: Reach | None, quiet: bool = False) -> Iterator[Line | None]:
    """The transports in a process of their own, while this lasts; None if there shall be none.

    Args:
        reach: which.
        quiet: whether a person is not told where they are.
    """
    if reach is None:
        yield None
        return
    from rollgait.hardware.transports.elsewhere import TransportProcess

    process: TransportProcess = TransportProcess(reach)
    try:
        if not quiet:
            print("\n".join(process.said), flush=True)
        yield process.line
    finally:
        process.close()


@contextmanager
def shown(loop: ClosedLoop, others: Line | None, name: str, heard: bool = False) -> Iterator[Showing | None]:
    """Shows a run while this lasts, period by period; None where nobody looks.

    Args:
        loop: that is run.
        others: the way to those who look.
        name: of the command.
        heard: whether they are asked what the robot shall do.
    """
    if others is None:
        yield None
        return
    from rollgait.hardware.topics import GOAL, VELOCITY
    from rollgait.hardware.transports.elsewhere import Elsewhere
    from rollgait.hardware.window import Showing, Window

    transport = Elsewhere(others)
    try:
        yield Showing(Window(transport, f"rollgait: {name}", (VELOCITY, GOAL) if heard else ()), loop)
    finally:
        transport.close()
