"""Data that users write: its base class, its kinds of numbers, and reading and writing it as YAML.

The only place that touches ruamel.yaml; ruamel.yaml and not PyYAML because the latter reads `1e-3` as a
string. What is wrong with the data becomes one sentence in `explain.py`.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Strict, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import YAMLError, YAMLWarning
from ruamel.yaml.scalarstring import DoubleQuotedScalarString

from rollgait.errors import FileError, InputError
from rollgait.explain import explain


class Config(BaseModel):
    """Base of all data that users write: immutable, no unknown keys, no NaN, no numbers in quotes.

    Raises:
        InputError: on construction, with the first thing that is wrong.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True, use_attribute_docstrings=True
    )

    if not TYPE_CHECKING:  # a type checker shall see the fields as arguments

        def __init__(self, **data: Any) -> None:
            try:
                super().__init__(**data)
            except ValidationError as error:
                raise explain(type(self), error) from None

        # Without this mark pydantic would build nested data through here, and an error would lose its place.
        __init__.__pydantic_base_init__ = True


def _number(value: Any) -> float:
    """Pydantic alone would take "1.5" and true for numbers."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError("must be a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("must be a finite number") from None


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError("must be a whole number")
    return int(value)


def _positive(value: float) -> float:
    if value <= 0.0:
        raise ValueError("must be greater than 0")
    return value


def _non_negative(value: float) -> float:
    if value < 0.0:
        raise ValueError("must not be negative")
    return value


def _ordered(value: tuple[float, float]) -> tuple[float, float]:
    if value[0] > value[1]:
        raise ValueError("must be [smallest, largest], in this order")
    return value


Number = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_whole)]
Flag = Annotated[bool, Strict()]
Positive = Annotated[Number, AfterValidator(_positive)]
NonNegative = Annotated[Number, AfterValidator(_non_negative)]
Vector3 = tuple[Number, Number, Number]
PositiveVector3 = tuple[Positive, Positive, Positive]
Range = Annotated[tuple[Number, Number], AfterValidator(_ordered)]
"""[smallest, largest]"""

ModelT = TypeVar("ModelT", bound=BaseModel)


PLAIN = re.compile(r"[^\W\d][\w ,;./()+-]*")
"""Text that may stand in YAML without quotes, unless it looks like a number or a word with a meaning."""

LINE = 80
"""Longest mapping or list that goes into one line of YAML, characters."""


def validate(model: type[ModelT], data: Mapping[str, Any], prefix: str = "") -> ModelT:
    """`data` as a `model`; raises `InputError` with the first thing that is wrong, as one sentence."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise explain(model, error, prefix) from None


def load_yaml(path: Path) -> dict[str, Any]:
    """The mapping that a YAML file holds. Raises `FileError`."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is not text"
        raise FileError("file", str(path), f"cannot be read: {reason}") from None
    return parse_yaml(text, str(path))


def parse_yaml(text: str, origin: str) -> dict[str, Any]:
    """The mapping in a YAML text. Raises `FileError` naming `origin`."""
    try:
        data = _read(text)
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark is not None else ""
        problem = getattr(error, "problem", None) or str(error)
        raise FileError("file", origin, f"is not valid YAML{where}: {' '.join(problem.split())}") from None
    if not isinstance(data, dict):
        raise FileError("file", origin, "must hold a mapping of keys to values")
    return data


def parse_value(text: str) -> Any:
    """One value as YAML reads it: `1e-3`, `true`, `[1, 2]`, `crawl`; what is not YAML is text."""
    try:
        return _read(text)
    except YAMLError:
        return text


def parse_setting(text: str) -> tuple[str, Any]:
    """The key and the value of `key=value`, as `--set` takes it. Raises `InputError`."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise InputError("set", text, "must have the form key=value, e.g. goal.x=1.5")
    return key.strip(), parse_value(value)


def _read(text: str) -> Any:
    """What a YAML text holds. Raises YAMLError and nothing else."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", YAMLWarning)
            return YAML(typ="safe", pure=True).load(text)
    except YAMLError:
        raise
    except Exception as error:  # ruamel raises what it meets: ValueError for the date 2001-99-99, and more
        raise YAMLError(str(error) or type(error).__name__) from None


def dump_yaml(data: Mapping[str, Any]) -> str:
    """`data` as YAML text; what is short and plain stays in one line."""
    yaml = YAML()
    yaml.width = 1_000_000  # a line that ruamel breaks is hard to read
    stream = io.StringIO()
    yaml.dump(_laid_out(data), stream)
    return stream.getvalue()


def _laid_out(data: Any) -> Any:
    """The same data, telling ruamel which mappings and lists go into one line."""
    if isinstance(data, Mapping):
        result: Any = CommentedMap({key: _laid_out(value) for key, value in data.items()})
    elif isinstance(data, list | tuple):
        result = CommentedSeq([_laid_out(value) for value in data])
    elif isinstance(data, str) and not PLAIN.fullmatch(data):
        return DoubleQuotedScalarString(data)  # ruamel itself leaves ": 1" bare, and cannot read it back
    else:
        return data
    values = result.values() if isinstance(result, CommentedMap) else result
    if not any(isinstance(v, CommentedMap | CommentedSeq) for v in values) and len(str(data)) <= LINE:
        result.fa.set_flow_style()
    return result


def set_key(data: dict[str, Any], key: str, value: Any) -> None:
    """Sets the dotted `key` in nested mappings in place; a list index is a number: `goal.then.0.x`.

    Raises `InputError` if the way to the key leads through a plain value or past the end of a list; whether
    the key itself exists is for the validation to say.
    """
    *path, last = key.split(".")
    node: Any = data
    for depth, name in enumerate(path):
        child = node[_index(node, name, key)] if isinstance(node, list) else node.get(name)
        if child is None:
            child = {}
        if not isinstance(child, dict | list):
            parent = ".".join(path[: depth + 1])
            raise InputError(key, value, f"cannot be set: {parent} is {child!r}, which has no keys")
        node[_index(node, name, key) if isinstance(node, list) else name] = child
        node = child
    node[_index(node, last, key) if isinstance(node, list) else last] = value


def _index(node: list[Any], name: str, key: str) -> int:
    places = [str(place) for place in range(len(node))]
    if name not in places:
        rule = "is not a place in this list" if places else "cannot be set: the list is empty"
        raise InputError(key, name, rule, places)
    return int(name)
