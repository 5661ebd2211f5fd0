"""The commands put together, and what becomes of errors: one line on stderr and an exit status."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer

import rollgait
from rollgait.cli import (
    bridge,
    cache,
    check,
    dataset,
    drive,
    execute,
    export,
    ground,
    library,
    many,
    mpc,
    plan,
    plot,
    record,
    robot,
    robot_show,
    search,
    simulate,
    track,
    view,
)
from rollgait.cli.exit_status import INTERRUPTED, INTERRUPTED_WORDS
from rollgait.cli.log import log_on_stderr
from rollgait.cli.output import print_error
from rollgait.cli.run import run as run_scenario
from rollgait.cli.usage import Commands, usage_error
from rollgait.cli.verbosity import Verbosity, flags_first, speaking
from rollgait.errors import MISSING, InputError, RollgaitError

app = typer.Typer(cls=Commands, rich_markup_mode=None, pretty_exceptions_enable=False, name="rollgait")
app.command("plan")(plan.plan)
app.command("many")(many.many)
app.command("search")(search.search)
app.command("check")(check.check)
app.command("plot")(plot.plot)
app.command("export")(export.export)
app.command("track")(track.track)
app.command("simulate")(simulate.simulate)
app.command("run")(run_scenario)
app.command("execute")(execute.execute)
app.command("mpc")(mpc.mpc)
app.command("view")(view.view)
app.command("drive")(drive.drive)
app.command("bridge")(bridge.bridge)
app.command("record")(record.record)
app.command("scenarios")(library.scenarios)
app.command("robots")(library.robots)
app.command("show")(library.show)
app.command("cache")(cache.cache)
robot.app.command("show")(robot_show.show)
app.add_typer(robot.app, name="robot")
app.add_typer(ground.app, name="ground")
app.add_typer(dataset.app, name="dataset")


def _version(asked: bool) -> None:
    if asked:
        print(f"rollgait {rollgait.__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def rollgait_command(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print errors only (and JSON, if asked for).")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Print all that is known: every iteration of the solver.")
    ] = False,
) -> None:
    """Motion generation for legged robots on wheels.

    Start with: rollgait plan hybrid-forward
    """
    if quiet and verbose:
        raise InputError("quiet", MISSING, "and verbose contradict each other: choose one")
    if quiet or verbose:
        context.with_resource(speaking(Verbosity.QUIET if quiet else Verbosity.VERBOSE))
    if context.invoked_subcommand is None:
        print(context.get_help())


def run(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit status: 0 done, 1 not solved or not passed, 2 wrong input.

    Args:
        arguments: as a shell would pass them; those of this process if not given.
    """
    try:
        with log_on_stderr():
            status: Any = app(
                flags_first(sys.argv[1:] if arguments is None else arguments),
                prog_name="rollgait",
                standalone_mode=False,
            )
    except RollgaitError as error:
        print_error(str(error))
        if (diagnosis := getattr(error, "diagnosis", None)) is not None:
            print(diagnosis, file=sys.stderr)
        return error.exit_status
    except typer.TyperException as error:
        print_error(usage_error(error))
        return 2
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    except BrokenPipeError:  # the reader of the output has gone, as in `rollgait scenarios | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    if status == INTERRUPTED:
        print_error(INTERRUPTED_WORDS)
    return status if isinstance(status, int) else 0
