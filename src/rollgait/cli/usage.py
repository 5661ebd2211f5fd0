"""A wrong command or option, as one sentence with the valid ones nearest first."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperGroup

from rollgait.errors import UnknownNameError, nearest_first, shown


class Commands(TyperGroup):
    """The group of commands, in the order in which they were added."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """As the library's own, with our error for an unknown command."""
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            raise UnknownNameError("command", args[0], self.commands, "is not a command of rollgait")
        return super().resolve_command(ctx, args)


def usage_error(error: typer.TyperException) -> str:
    """The sentence for a usage error that the argument parser found."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else "rollgait"
    option = getattr(error, "option_name", None)
    if option is not None and context is not None and option not in _options(context):
        valid = ", ".join(nearest_first(option, _options(context)))
        return f"{option}: is not an option of '{command}'; valid: {valid}"
    return f"{_sentence(error)} ('{command} --help' tells more)"


def _sentence(error: typer.TyperException) -> str:
    parameter = getattr(error, "param", None)
    if parameter is None:
        message = " ".join(error.format_message().split()).rstrip(".")
        return message[:1].lower() + message[1:]
    name = parameter.opts[0] if parameter.param_type_name == "option" else parameter.metavar
    rule = " ".join(error.message.split()).rstrip(".") or "must be given"
    if error.__cause__ is not None:
        rule = _broken_rule(error.__cause__) or rule
    return f"{name or parameter.name.upper()}: {rule}"


def _broken_rule(cause: BaseException) -> str | None:
    """Value and rule, where the parser had pydantic look at a value."""
    from pydantic import ValidationError  # a help page shall not load it

    from rollgait.explain import rule_of

    if not isinstance(cause, ValidationError):
        return None
    first = cause.errors()[0]
    return f"{shown(first['input'])} {rule_of(first)}"


def _options(context: Any) -> list[str]:
    return [name for p in context.command.get_params(context) for name in p.opts if name.startswith("--")]
