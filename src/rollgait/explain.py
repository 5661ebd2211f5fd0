"""Turns what pydantic finds wrong into one sentence: field, value, rule, valid choices."""

from __future__ import annotations

import math
import re
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rollgait.errors import MISSING, InputError, UnknownNameError

_RULES = {
    "bool_type": "must be true or false",
    "dict_type": "must be a mapping of keys to values",
    "model_type": "must be a mapping of keys to values",
    "model_attributes_type": "must be a name or a mapping of keys to values",
    "finite_number": "must be a finite number",
    "float_parsing": "must be a number",
    "int_from_float": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_type": "must be a whole number",
    "invalid_key": "must be text, as every key",
    "recursion_loop": "must not contain itself",
    "string_type": "must be text",
    "tuple_type": "must be a list",
}
"""Pydantic's kinds of errors whose own words are not ours."""

Location = tuple[int | str, ...]


def explain(model: type[BaseModel], error: ValidationError, prefix: str = "") -> InputError:
    """The first thing that is wrong with the data of a `model`; unknown keys come before anything else.

    Args:
        model: what the data should have been.
        error: what pydantic says.
        prefix: dotted name of the place where the data stands.
    """
    errors = error.errors()
    first = next((e for e in errors if e["type"] == "extra_forbidden"), errors[0])
    names, models = _follow(model, first["loc"])
    field = ".".join([prefix, *names] if prefix else names) or model.__name__.lower()
    value, kind, context = first["input"], first["type"], first.get("ctx", {})
    if kind == "extra_forbidden":
        valid = dict.fromkeys(name for m in models for name in m.model_fields)
        return UnknownNameError(field, names[-1], valid, "is not a known key")
    if kind == "missing":
        if isinstance(first["loc"][-1], int):
            return InputError(field.rpartition(".")[0], value, f"must have {_wanted(errors, first)} values")
        return InputError(field, MISSING, "must be given")
    if kind == "too_short":
        wanted = context["min_length"]
        return InputError(field, value, f"must have at least {wanted} value{'s' if wanted > 1 else ''}")
    if kind == "too_long":
        return InputError(field, value, f"must have at most {context['max_length']} values")
    if kind == "union_tag_invalid":
        choices = re.findall(r"'([^']*)'", context["expected_tags"])
        return UnknownNameError(f"{field}.kind", context["tag"], choices, "is not a known kind")
    if kind == "literal_error" and isinstance(value, str):
        choices = re.findall(r"'([^']*)'", context["expected"])
        if choices:
            return UnknownNameError(field, value, choices)
    if isinstance(value, float) and not math.isfinite(value):
        return InputError(field, value, _RULES["finite_number"])
    return InputError(field, value, rule_of(first))


def rule_of(error: ErrorDetails) -> str:
    """The rule that a value breaks, worded to follow it."""
    return _RULES.get(error["type"]) or _as_rule(error["msg"])


def _wanted(errors: list[ErrorDetails], first: ErrorDetails) -> int:
    """How many values a list of fixed length wants, from the errors about those that are missing."""
    lists = [e["loc"] for e in errors if e["type"] == "missing" and e["loc"][:-1] == first["loc"][:-1]]
    return 1 + max(place for *_, place in lists if isinstance(place, int))


def _as_rule(message: str) -> str:
    message = message.removeprefix("Value error, ")
    for begin in ("be", "have"):
        message = re.sub(f"^Input should {begin} ", f"must {begin} ", message)
    return message[:1].lower() + message[1:] if message[:2].istitle() else message


def _follow(model: type[BaseModel], location: Location) -> tuple[list[str], list[type[BaseModel]]]:
    """The names that a user would use for pydantic's location, and the models that may stand around its end.

    Pydantic puts the chosen alternative of a union into the location, which nobody wrote and is left out.
    """
    names: list[str] = []
    around = [model]
    within: list[type[BaseModel]] = [model]
    choice = in_list = False
    for part in location:
        if choice:
            within, choice = _chosen(within, str(part)), False
            continue
        if part == "[key]":
            continue
        names.append(str(part))
        if isinstance(part, int):
            choice, in_list = in_list, False
            continue
        around = within
        fields = [m.model_fields[str(part)] for m in within if str(part) in m.model_fields]
        if fields:
            within = [m for field in fields for m in _models_in(field.annotation)]
            choice = any(_is_choice(field.annotation) for field in fields)
            in_list = any(_is_list_of_choices(field.annotation) for field in fields)
    return names, around


def _chosen(models: list[type[BaseModel]], tag: str) -> list[type[BaseModel]]:
    """The models that the tag of a union stands for."""
    kinds = [m for m in models if "kind" in m.model_fields and m.model_fields["kind"].default == tag]
    return kinds or models


def _is_choice(annotation: Any) -> bool:
    """Whether a field takes one of several alternatives (None aside)."""
    if get_origin(annotation) is Annotated:
        return _is_choice(get_args(annotation)[0])
    if get_origin(annotation) not in (Union, UnionType):
        return False
    return len([a for a in get_args(annotation) if a is not NoneType]) > 1


def _is_list_of_choices(annotation: Any) -> bool:
    """Whether a field takes a list, each entry of which is one of several alternatives."""
    return get_origin(annotation) is tuple and _is_choice(get_args(annotation)[0])


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models_in(argument)]
