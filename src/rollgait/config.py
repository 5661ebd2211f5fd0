"""Data that users write: its base class, its kinds of numbers, and reading and writing it as YAML.

The only place that touches ruamel.yaml; ruamel.yaml and not PyYAML because the latter reads `1e-3` as a
string. What is wrong with the data becomes one sentence in `explain.py`.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Strict, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import YAMLError, YAMLWarning
from ruamel.yaml.nodes import ScalarNode
from ruamel.yaml.scalarstring import DoubleQuotedScalarString

from rollgait.errors import FileError, InputError, shortened, shown
from rollgait.explain import explain
from rollgait.files import read_bytes


class Config(BaseModel):
    """Base of all data that users write: immutable, no unknown keys, no NaN, no numbers in quotes.

    Raises:
        InputError: on construction, with the first thing that is wrong.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)

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
    whole = int(value)
    if abs(whole) > WHOLE_MAX:
        raise ValueError("must be a whole number of at most 64 bits")
    return whole


def _positive(value: float) -> float:
    if value <= 0.0:
        raise ValueError("must be greater than 0")
    return value


def _non_negative(value: float) -> float:
    if value < 0.0:
        raise ValueError("must not be negative")
    return value


def _from_one(value: int) -> int:
    if value < 1:
        raise ValueError("must be at least 1")
    return value


def _ordered(value: tuple[float, float]) -> tuple[float, float]:
    if value[0] > value[1]:
        raise ValueError("must be [smallest, largest], in this order")
    return value


def _line(value: str) -> str:
    if len(value) > LINE_MAX or not value.isprintable():
        raise ValueError(f"must be one line of at most {LINE_MAX} printable characters")
    return value


Line = Annotated[str, AfterValidator(_line)]
"""Text that may be printed as it is: from a file, other text could steer the terminal."""
Number = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_whole)]
Count = Annotated[Whole, AfterValidator(_from_one)]
Seed = Annotated[Whole, AfterValidator(_non_negative)]
"""Of random numbers."""
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

LINE_MAX = 1000
"""Longest text that is shown in a line, characters."""

LINE = 80
"""Longest mapping or list that goes into one line of YAML, characters."""

TEXT_MAX = 500_000
"""Largest YAML text that is read, bytes."""

NODES_MAX = 30_000
"""Most keys and values in a YAML text, enough for a script of 2000 commands; more take seconds to read."""

DEPTH_MAX = 50
"""Deepest nesting of a YAML text; a scenario needs 4."""

WHOLE_MAX = 2**63 - 1
"""Largest whole number: what NumPy and files can hold."""


def validate(model: type[ModelT], data: Mapping[str, Any], prefix: str = "") -> ModelT:
    """`data` as a `model`; raises `InputError` with the first thing that is wrong, as one sentence."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise explain(model, error, prefix) from None


def load_yaml(path: Path) -> dict[str, Any]:
    """The mapping that a YAML file holds. Raises `FileError`."""
    content = read_bytes(path, TEXT_MAX)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise FileError("file", str(path), "cannot be read: it is not text") from None
    return parse_yaml(text, str(path))


def parse_yaml(text: str, origin: str) -> dict[str, Any]:
    """The mapping in a YAML text. Raises `FileError` naming `origin`."""
    try:
        data = _read(text)
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark is not None else ""
        problem = " ".join((getattr(error, "problem", None) or str(error)).split())
        raise FileError("file", origin, f"is not valid YAML{where}: {shortened(problem, LINE)}") from None
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
    if len(text) > TEXT_MAX:
        raise YAMLError(f"it is longer than {TEXT_MAX} characters")
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _Composer
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", YAMLWarning)
            root = yaml.compose(text)
            if root is None:
                return None
            # aliases and merge keys cost nothing here, and everything where each is followed
            if _unfolded(root, {}) > UNFOLDED_MAX:
                raise YAMLError("its aliases make it too large")
            return yaml.constructor.construct_document(root)
    except YAMLError:
        raise
    except Exception as error:  # ruamel raises what it meets: ValueError for the date 2001-99-99, and more
        raise YAMLError(str(error) or type(error).__name__) from None


class _Composer(Composer):
    """Ruamel's own, which stops at `NODES_MAX` and `DEPTH_MAX`."""

    nodes = level = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self.nodes += 1
        self.level += 1
        if self.nodes > NODES_MAX:
            raise YAMLError(f"it holds more than {NODES_MAX} keys and values")
        if self.level > DEPTH_MAX:
            raise YAMLError(f"it is nested more than {DEPTH_MAX} deep")
        node = super().compose_node(parent, index)
        self.level -= 1
        return node


NODE_SIZE = 16
"""What a key or value counts beside its characters."""

UNFOLDED_MAX = TEXT_MAX + NODE_SIZE * NODES_MAX
"""Largest size of a YAML text with every alias in full; no text without aliases comes near it."""


def _unfolded(node: Any, known: dict[int, int]) -> int:
    """Size of a node with every alias in full: characters, and `NODE_SIZE` for each value."""
    if id(node) not in known:
        known[id(node)] = 0  # while it is counted: what contains itself is for the validation to refuse
        parts = [node.value] if isinstance(node, ScalarNode) else [*_flat(node.value)]
        inner = (len(p) if isinstance(p, str) else _unfolded(p, known) for p in parts)
        known[id(node)] = NODE_SIZE + sum(inner)
    return known[id(node)]


def _flat(children: list[Any]) -> Iterator[Any]:
    """The nodes in a sequence, or the keys and values in a mapping."""
    for child in children:
        yield from child if isinstance(child, tuple) else (child,)


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
            raise InputError(key, value, f"cannot be set: {parent} is {shown(child)}, which has no keys")
        node[_index(node, name, key) if isinstance(node, list) else name] = child
        node = child
    node[_index(node, last, key) if isinstance(node, list) else last] = value


def _index(node: list[Any], name: str, key: str) -> int:
    places = [str(place) for place in range(len(node))]
    if name not in places:
        rule = (
            "is not a place in this list" if places else "is no place: the list is empty; set it as a whole"
        )
        raise InputError(key, name, rule, places)
    return int(name)
