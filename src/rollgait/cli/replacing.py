"""Files that are there already: replaced with a word, or refused where they hold something else."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rollgait.cli.output import print_note
from rollgait.errors import FileError

if TYPE_CHECKING:
    from rollgait.scenario.scenario import Scenario


def note_replacing(path: Path) -> None:
    """Says on stderr that a file is there and is about to be replaced."""
    if path.exists():
        print_note(f"{path} was there before and is replaced")


def refuse_other_plan(path: Path, asked: Scenario, overwrite: bool) -> None:
    """Raises `FileError` where a plan would replace what is not a plan of the same robot.

    Planning again after a change is usual; another robot under the same name is a slip.
    """
    if overwrite or not path.exists():
        return
    from rollgait.plan.plan import Plan

    wanted = asked.body.name
    try:
        found = Plan.load(path).robot.name
    except FileError:
        rule = "is there already and is no plan that can be read: choose another --out, or --overwrite"
        raise FileError("out", str(path), rule) from None
    if found != wanted:
        rule = f"holds a plan of {found}, and {wanted} is to be planned: choose another --out, or --overwrite"
        raise FileError("out", str(path), rule)
