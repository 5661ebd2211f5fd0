"""What a person sees while the solver works: one line that changes, on a terminal only."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Self

from rollgait.cli.output import console_of_stderr, number, print_note
from rollgait.cli.verbosity import Verbosity, verbosity

if TYPE_CHECKING:
    from rich.status import Status

    from rollgait.solvers import Iteration


class StatusLine:
    """Shows one line, and then another in its place; nothing if stderr is not a terminal."""

    def __init__(self, text: str, quiet: bool = False) -> None:
        self._status: Status | None = None
        quiet = quiet or verbosity() is not Verbosity.NORMAL
        if not quiet and (console := console_of_stderr()).is_terminal:
            self._status = console.status(text)

    def __enter__(self) -> Self:
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._status is not None:
            self._status.stop()

    def show(self, text: str) -> None:
        """Another line."""
        if self._status is not None:
            self._status.update(text)


class SolverLine(StatusLine):
    """Shows each iteration of the solver that it is called with; with `-v` as lines that stay."""

    def __init__(self, quiet: bool = False) -> None:
        super().__init__("building the problem …", quiet)
        self._each = not quiet and verbosity() is Verbosity.VERBOSE

    def __call__(self, iteration: Iteration) -> None:
        """Shows the iteration."""
        cost, violation = number(iteration.cost, 6), number(iteration.violation, 2)
        text = f"{iteration.task} … iteration {iteration.number:3d}   cost {cost}   violation {violation}"
        if self._each:
            print_note(text)
        self.show(text)
