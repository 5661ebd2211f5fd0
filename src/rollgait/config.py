"""Reading and writing of YAML, and validation whose errors are one sentence.

The only place that touches ruamel.yaml, and the only one that turns a pydantic error into an `InputError`.
ruamel.yaml and not PyYAML because the latter reads `1e-3` as a string.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from rollgait.errors import FileError, InputError, nearest_first


class Config(BaseModel):
    """Base of all data that users write: immutable, no unknown keys, no NaN, no numbers in quotes."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True, use_attribute_docstrings=True
    )


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


Positive = Annotated[float, AfterValidator(_positive)]
NonNegative = Annotated[float, AfterValidator(_non_negative)]
Vector3 = tuple[float, float, float]
PositiveVector3 = tuple[Positive, Positive, Positive]
Range = Annotated[tuple[float, float], AfterValidator(_ordered)]
"""[smallest, largest]"""

ModelT = TypeVar("ModelT", bound=BaseModel)


def validate(model: type[ModelT], data: Mapping[str, Any], prefix: str = "") -> ModelT:
    """`data` as a `model`; raises `InputError` with the first thing that is wrong, as one sentence."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise _as_input_error(model, error, prefix) from None


def load_yaml(path: Path) -> dict[str, Any]:
    """The mapping that a YAML file holds. Raises `FileError`."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not text"
        raise FileError("file", str(path), f"cannot be read: {reason}") from None
    return parse_yaml(text, str(path))


def parse_yaml(text: str, origin: str) -> dict[str, Any]:
    """The mapping in a YAML text. Raises `FileError` naming `origin`."""
    try:
        data = YAML(typ="safe", pure=True).load(text)
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark is not None else ""
        raise FileError(
            "file", origin, f"is not valid YAML{where}: {getattr(error, 'problem', error)}"
        ) from None
    if not isinstance(data, dict):
        raise FileError("file", origin, "must hold a mapping of keys to values")
    return data


def parse_value(text: str) -> Any:
    """One value as YAML reads it: `1e-3`, `true`, `[1, 2]`, `crawl`."""
    try:
        return YAML(typ="safe", pure=True).load(text)
    except YAMLError:
        return text


def dump_yaml(data: Mapping[str, Any]) -> str:
    """`data` as YAML text; lists of plain values stay in one line."""
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 110
    stream = io.StringIO()
    yaml.dump(dict(data), stream)
    return stream.getvalue()


def set_key(data: dict[str, Any], key: str, value: Any) -> None:
    """Sets the dotted `key` in nested mappings in place; a list index is a number: `goal.then.0.x`."""
    *path, last = key.split(".")
    node: Any = data
    for name in path:
        child = _child(node, name)
        if not isinstance(child, dict | list):
            child = {} if child is None else {"kind": child} if isinstance(child, str) else None
            if child is None:
                raise InputError(key, value, f"cannot be set: {name} is not a mapping")
            node[name] = child
        node = child
    if isinstance(node, list):
        node[_index(node, last, key)] = value
    else:
        node[last] = value


def _child(node: Any, name: str) -> Any:
    return node[_index(node, name, name)] if isinstance(node, list) else node.get(name)


def _index(node: list[Any], name: str, key: str) -> int:
    if not name.isdigit() or int(name) >= len(node):
        raise InputError(key, name, f"must be a number below {len(node)}")
    return int(name)


def _as_input_error(model: type[BaseModel], error: ValidationError, prefix: str) -> InputError:
    first = next((e for e in error.errors() if e["type"] == "extra_forbidden"), error.errors()[0])
    location = [str(part) for part in first["loc"] if not str(part).endswith("]")]
    field = ".".join(([prefix] if prefix else []) + location) or model.__name__
    value, kind = first["input"], first["type"]
    if kind == "extra_forbidden":
        valid = _siblings(model, first["loc"])
        return InputError(field, value, "is not a known key", nearest_first(location[-1], valid))
    if kind == "missing":
        return InputError(field, None, "is required")
    if isinstance(value, float) and not math.isfinite(value):
        return InputError(field, value, "must be a finite number")
    message = first["msg"].removeprefix("Value error, ")
    return InputError(field, value, _as_rule(message))


def _as_rule(message: str) -> str:
    if message.startswith("Input should be "):
        return "must be " + message.removeprefix("Input should be ")
    if message.startswith("Input should have "):
        return "must have " + message.removeprefix("Input should have ")
    return message[:1].lower() + message[1:] if message[:2].istitle() else message


def _siblings(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """The keys that are valid where the unknown one stands."""
    current: Any = model
    for part in location[:-1]:
        current = _descend(current, part)
        if current is None:
            return []
    return list(current.model_fields)


def _descend(current: type[BaseModel], part: int | str) -> Any:
    """The model behind a field, or behind a tag of a union of models; `current` itself for an index or key."""
    field = current.model_fields.get(str(part))
    candidates = _models_in(field.annotation) if field is not None else []
    if len(candidates) == 1:
        return candidates[0]
    if candidates:
        return _Union(candidates)
    return current.tagged(part) if isinstance(current, _Union) else current


class _Union:
    """Stands for a tagged union while an error's location is followed through it."""

    model_fields: dict[str, Any]

    def __init__(self, models: list[type[BaseModel]]) -> None:
        self.models = models
        self.model_fields = {name: field for model in models for name, field in model.model_fields.items()}

    def tagged(self, tag: int | str) -> Any:
        for model in self.models:
            kind = model.model_fields.get("kind")
            if kind is not None and kind.default == tag:
                return model
        return self


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in getattr(annotation, "__args__", ()) for model in _models_in(argument)]
