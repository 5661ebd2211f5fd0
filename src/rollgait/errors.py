"""Every error that rollgait raises on purpose.

One root, `RollgaitError`; each error carries what it knows (field, value, rule, choices, evidence), so that a
program can act on it and the command line can print it as one sentence. `exit_status` is what the command
line returns: 1 not solved or not passed, 2 wrong input.
"""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from difflib import SequenceMatcher
from typing import Any

VALUE_LENGTH = 80
"""Most that a message shows of a wrong value, characters: enough to find it again."""
FIELD_LENGTH = 120
"""Most of the name of a field, characters."""
MESSAGE_LENGTH = 2000
"""Longest message, characters: what is wrong with a file of many megabytes is still one sentence."""
CHOICES_SHOWN = 50
"""Valid choices that a message lists."""


class _Missing:
    def __repr__(self) -> str:
        return "MISSING"


MISSING = _Missing()
"""Stands for the value of a field that was not given."""


class RollgaitError(Exception):
    """Root of all errors that rollgait raises on purpose. They can be pickled, to come home from a worker."""

    exit_status = 2

    def __init__(self, message: str = "") -> None:
        super().__init__(readable(message))

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
        names = [_name(choice) for choice in self.choices[:CHOICES_SHOWN]]
        if len(self.choices) > CHOICES_SHOWN:
            names.append(f"and {len(self.choices) - CHOICES_SHOWN} more")
        listed = f"; valid: {', '.join(names)}" if names else ""
        value_text = "" if value is MISSING else f"{shown(value)} "
        super().__init__(f"{_name(field)}: {value_text}{rule}{listed}")


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
    wanted = str(name)[:FIELD_LENGTH].lower()
    return sorted(choices, key=lambda choice: -SequenceMatcher(None, wanted, choice.lower()).ratio())


def shown(value: Any) -> str:
    """A value as it stands in a message: at most `VALUE_LENGTH` characters, strings in quotes."""
    if isinstance(value, str):
        value = shortened(value, VALUE_LENGTH)  # before the quotes: a copy of 100 MB takes its time
        return shortened(repr(value), VALUE_LENGTH)
    try:
        return shortened(_REPR.repr(value), VALUE_LENGTH)
    except Exception:  # a foreign object whose repr fails
        return f"<{type(value).__name__}>"


def shortened(text: str, length: int) -> str:
    """A text of at most `length` characters, cut in the middle. The end of a long path says the most."""
    begin = length // 4
    return text if len(text) <= length else f"{text[:begin]}…{text[begin + 1 - length :]}"


def readable(text: str) -> str:
    """A text that a terminal may print: bounded, and what would steer the terminal shown as `\\x1b`."""
    return "\n".join(_escaped(line) for line in shortened(text, MESSAGE_LENGTH).split("\n"))


def _name(text: str) -> str:
    """The name of a field or a choice, which may come from a file, as part of a line."""
    return _escaped(shortened(str(text), FIELD_LENGTH))


def _escaped(text: str) -> str:
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


class _Repr(reprlib.Repr):
    """Of containers, their beginning; of whole numbers beyond any use, hexadecimal digits."""

    def __init__(self) -> None:
        super().__init__()
        self.maxdict = self.maxlist = self.maxtuple = self.maxset = self.maxfrozenset = self.maxdeque = 20
        self.maxstring = self.maxother = VALUE_LENGTH

    def repr_int(self, x: int, level: int) -> str:
        return repr(x) if abs(x) < 10**VALUE_LENGTH else hex(x)  # Python refuses more than 4300 decimals


_REPR = _Repr()
