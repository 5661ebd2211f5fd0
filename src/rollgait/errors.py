"""Every error that rollgait raises on purpose.

One root, `RollgaitError`; each error carries what it knows (field, value, rule, choices, evidence), so that a
program can act on it and the command line can print it as one sentence. `exit_status` is what the command
line returns: 1 not solved or not passed, 2 wrong input.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher
from typing import Any


class _Missing:
    def __repr__(self) -> str:
        return "MISSING"


MISSING = _Missing()
"""Stands for the value of a field that was not given."""


class RollgaitError(Exception):
    """Root of all errors that rollgait raises on purpose. They can be pickled, to come home from a worker."""

    exit_status = 2

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), str(self), self.__dict__)


def _restored(kind: type[RollgaitError], message: str, attributes: dict[str, Any]) -> RollgaitError:
    """An error as it was pickled: its message is already put together."""
    error = kind.__new__(kind)
    error.args = (message,)
    error.__dict__.update(attributes)
    return error


class InputError(RollgaitError, ValueError):
    """A field of the input breaks a rule.

    Attributes:
        field: dotted name of the field, e.g. `goal.x`.
        value: the value that was given, or `MISSING`.
        rule: the rule it breaks, worded to follow "… must …" or as a full clause.
        choices: the valid choices, nearest first, where there is a finite set of them.
    """

    def __init__(self, field: str, value: Any, rule: str, choices: Iterable[str] = ()) -> None:
        self.field, self.value, self.rule, self.choices = field, value, rule, tuple(choices)
        listed = f"; valid: {', '.join(self.choices)}" if self.choices else ""
        shown = "" if value is MISSING else f"{_shown(value)} "
        super().__init__(f"{field}: {shown}{rule}{listed}")


class UnknownNameError(InputError):
    """A name that is not in a library; lists the valid ones, nearest first."""

    def __init__(self, field: str, value: str, choices: Iterable[str], rule: str = "is not known") -> None:
        super().__init__(field, value, rule, nearest_first(value, choices))


class FileError(InputError):
    """A file that is missing, unreadable, or not what it should be."""


class NotSolvedError(RollgaitError):
    """The solver found no solution.

    Attributes:
        plan: its last iterate, marked as not solved; or None.
        diagnosis: why there is none and what would help (`rollgait.Diagnosis`); None if it was not asked for.
    """

    exit_status = 1

    def __init__(self, message: str, plan: Any = None, diagnosis: Any = None) -> None:
        self.plan, self.diagnosis = plan, diagnosis
        super().__init__(message)


class NotCertifiedError(RollgaitError):
    """A plan whose certificate fails would have been executed."""

    exit_status = 1


class MissingExtraError(RollgaitError):
    """A feature needs an optional dependency that is not installed."""

    def __init__(self, feature: str, extra: str) -> None:
        self.feature, self.extra = feature, extra
        super().__init__(f"{feature} needs the extra '{extra}': pip install 'rollgait[{extra}]'")


def nearest_first(name: str, choices: Iterable[str]) -> list[str]:
    """The choices, sorted by their likeness to `name`, the most alike first."""
    wanted = str(name).lower()
    return sorted(choices, key=lambda choice: -SequenceMatcher(None, wanted, choice.lower()).ratio())


def _shown(value: Any) -> str:
    """A value as it stands in a message: short, strings in quotes. The end of a long path says the most."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:20]}…{text[-59:]}"
