"""What a stage needs of the terms: which of them, at which places, with which numbers of what size.

One walk over the terms serves both sides, the symbols of a stage (`code.py`) and their numbers
(`stage.py`), and its outline is the key under which the code is kept.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.instant import Body, Inputs, Instant, make_instant
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Constraint, Cost, FootConstraint, Place, Term
from rollgait.robot.robot import LEG_NAMES, FootKind

Array = NDArray[np.float64]

BODY_SIZES: Mapping[str, int] = {
    "mass": 1,
    "weight": 1,
    "inertia": 6,
    "inertia_inverse": 6,
    "stance": 12,
    "heading_offset": 4,
    "interval": 1,
    "ground": 4,
}
"""Parameters that every stage has: figures of the robot, length of the interval, height of the ground."""
INPUT_NAMES = ("now_", "before_", "rise_")
"""How the names of symbols begin that stand for inputs."""
OWN_PACKAGES = ("dynamics", "footing", "ocp", "transcription")
"""Folders of the package whose code the expressions of a stage come from."""


@dataclass(frozen=True)
class TermUse:
    """A term in a stage, for one leg or for the whole robot.

    Attributes:
        term: the term.
        leg: 0 … 3 for a foot's constraint, else None.
        places: where it holds in this stage, in the order of the stage; none for a cost.
        data: numbers that it reads, as it gives them.
    """

    term: Term
    leg: int | None
    places: tuple[Place, ...]
    data: Mapping[str, Array]

    @property
    def _prefix(self) -> str:
        return self.term.name if self.leg is None else f"{self.term.name}_{LEG_NAMES[self.leg]}"

    @property
    def parameters(self) -> Mapping[str, str]:
        """Names of the parameters by what the term itself calls them."""
        return {name: f"{self._prefix}_{name}" for name in self.data}

    @property
    def weight(self) -> str:
        """Name of the parameter that is a cost's weight."""
        return f"{self.term.name}_weight"

    @property
    def numbers(self) -> Mapping[str, Array]:
        """The numbers by the names of the parameters; a cost's weight among them."""
        values = {self.parameters[name]: value for name, value in self.data.items()}
        if isinstance(self.term, Cost):
            values[self.weight] = np.array([[self.term.weight]])
        return values

    @property
    def sizes(self) -> tuple[tuple[str, int], ...]:
        """Names and sizes of the parameters."""
        return tuple((name, value.shape[0]) for name, value in self.numbers.items())

    def source(self, place: Place) -> str:
        """Under which name the limits of its rows at a place are known."""
        return f"{self._prefix}@{place.name}"

    def expression(self, x: Instant, d: SimpleNamespace) -> ca.SX:
        """What is limited or weighed, at an instant."""
        if isinstance(self.term, FootConstraint):
            assert self.leg is not None
            return ca.SX(self.term.expression(x, x.feet[self.leg], d))
        return ca.SX(self.term.expression(x, d))

    def reads_inputs(self, kinds: tuple[FootKind, ...]) -> bool:
        """Whether its expression depends on forces, motions or rates, which do not exist at the very end."""
        symbols = ca.symvar(self.expression(_any_instant(kinds, None), _any_data(self)))
        return any(symbol.name().startswith(INPUT_NAMES) for symbol in symbols)


@dataclass(frozen=True)
class Outline:
    """All that the code of a stage depends on.

    Attributes:
        name: of the transcription and its stage.
        kinds: of the feet.
        places: how many instants there are at each place.
        uses: the terms.
        extra: names and sizes of further parameters.
    """

    name: str
    kinds: tuple[FootKind, ...]
    places: Mapping[Place, int]
    uses: tuple[TermUse, ...]
    extra: tuple[tuple[str, int], ...] = ()

    @property
    def key(self) -> str:
        """The same for outlines of the same code; another where the package itself has changed."""
        parts: list[Any] = [_version(), self.name, self.kinds, self.extra]
        parts.append([(place.name, count) for place, count in self.places.items()])
        for use in self.uses:
            places = [place.name for place in use.places]
            parts.append((_signature(use, self.kinds), use.leg, use.sizes, places))
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def outline(
    name: str,
    terms: Sequence[Term],
    problem: Problem,
    places: Mapping[Place, int],
    terminal: bool,
    extra: Sequence[tuple[str, int]] = (),
) -> Outline:
    """The outline of a problem's stage: costs first, then constraints, as the problem lists them."""
    kinds = tuple(leg.foot for leg in problem.robot.leg_list)
    return Outline(name, kinds, places, tuple(_uses(terms, problem, places, terminal)), tuple(extra))


def _uses(
    terms: Sequence[Term], problem: Problem, places: Mapping[Place, int], terminal: bool
) -> Iterator[TermUse]:
    for term in terms:
        if isinstance(term, Cost) and term.terminal == terminal:
            yield TermUse(term, None, (), _columns(term.data(problem)))
    for term in terms:
        if isinstance(term, Cost) or not (own := tuple(place for place in places if place in term.places)):
            continue
        if isinstance(term, Constraint):
            yield TermUse(term, None, own, _columns(term.data(problem)))
            continue
        for leg in range(len(LEG_NAMES)):
            if term.applies(problem, leg):
                yield TermUse(term, leg, own, _columns(term.data(problem, leg)))


def _columns(data: Mapping[str, Any]) -> dict[str, Array]:
    """Numbers as columns: (n, 1) for all the horizon, (n, N) by interval."""
    arrays = {name: np.atleast_1d(np.asarray(value, dtype=float)) for name, value in data.items()}
    return {name: a[:, None] if a.ndim == 1 else a for name, a in arrays.items()}


# -- the key of a term -----------------------------------------------------------------------------------


def _signature(use: TermUse, kinds: tuple[FootKind, ...]) -> Any:
    """What tells a term's expressions apart: a built-in one's name, another one's expressions."""
    wrapped = getattr(use.term, "term", use.term)  # a constraint as a cost
    if all(type(term).__module__.startswith("rollgait.") for term in (use.term, wrapped)):
        return f"{type(use.term).__module__}.{type(use.term).__qualname__}", use.term.structure
    x, d = _any_instant(kinds, None), _any_data(use)
    instants = [x, *(_any_instant(kinds, point) for point in range(2) if Place.HEIGHT_POINTS in use.places)]
    return [_text(use.expression(at, d)) for at in instants]


def _text(expression: ca.SX) -> str:
    symbols = ca.symvar(expression)
    function = ca.Function("term", symbols, [expression])
    return str([symbol.name() for symbol in symbols]) + str(function.serialize())


@lru_cache(maxsize=16)
def _any_instant(kinds: tuple[FootKind, ...], height_point: int | None) -> Instant:
    """An instant all of whose numbers are symbols of their own."""

    def some(name: str, size: int) -> ca.SX:
        return ca.SX.sym(name, size)

    body = Body(
        mass=some("mass", 1),
        weight=some("weight", 1),
        inertia=ca.SX.sym("inertia", 3, 3),
        stance=ca.SX.sym("stance", 3, 4),
        heading_offset=some("heading_offset", 4),
        interval=some("interval", 1),
        ground=some("ground", 4),
    )
    feet = range(len(LEG_NAMES))

    def inputs(name: str) -> Inputs:
        sizes = {"force": 3, "motion": 2, "lift_rate": 2}
        return Inputs(**{key: [some(f"{name}_{key}_{i}", n) for i in feet] for key, n in sizes.items()})

    return make_instant(
        body,
        kinds,
        some("base", 6),
        some("base_rate", 6),
        [some(f"xy_{i}", 2) for i in feet],
        [some(f"z_{i}", 1) for i in feet],
        [some(f"sigma_{i}", 1) for i in feet],
        [some(f"rise_{i}", 1) for i in feet],
        inputs("now"),
        inputs("before"),
        height_point,
    )


def _any_data(use: TermUse) -> SimpleNamespace:
    return SimpleNamespace(**{name: ca.SX.sym(f"d_{name}", a.shape[0]) for name, a in use.data.items()})


@lru_cache(maxsize=1)
def _version() -> str:
    """Of the code that writes stages: of CasADi's and of the package's own files."""
    digest = hashlib.sha256(ca.CasadiMeta.version().encode())
    root = Path(__file__).parents[1]
    for folder in OWN_PACKAGES:
        for file in sorted((root / folder).glob("*.py")):
            digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()
