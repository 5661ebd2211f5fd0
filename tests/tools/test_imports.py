"""Arrows between modules point one way, and each library has its rooms."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Literal, NamedTuple

import pytest

SOURCE = Path(__file__).parents[2] / "src"

When = Literal["load", "call", "types"]
"""When a module is imported: with the one that names it, in a call, or never, as it serves types only."""


class Import(NamedTuple):
    """One module names another."""

    by: str
    of: str
    when: When


def module_name(path: Path) -> str:
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in SOURCE.rglob("*.py")}


def imports_in(by: str, nodes: Iterable[ast.AST], when: When = "load") -> Iterator[Import]:
    """What the statements of a module import; the package imports absolutely throughout."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (Import(by, alias.name, when) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{by} imports relatively"
            for alias in node.names:
                inside = f"{node.module}.{alias.name}"
                yield Import(by, inside if inside in MODULES else str(node.module), when)
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            yield from imports_in(by, node.body, "types")
        else:
            calls = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            yield from imports_in(by, ast.iter_child_nodes(node), "call" if calls else when)


IMPORTS = frozenset(
    found
    for name, path in MODULES.items()
    for found in imports_in(name, ast.parse(path.read_text(encoding="utf-8")).body)
)


def circle(imports: Iterable[Import]) -> list[str]:
    """A circle among the package's modules; empty if there is none."""
    graph: dict[str, set[str]] = {}
    for found in imports:
        if found.of in MODULES:
            graph.setdefault(found.by, set()).add(found.of)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def is_within(name: str, packages: Iterable[str]) -> bool:
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def offenders(of: str, by: Iterable[str]) -> set[Import]:
    """Imports of a package by modules of some packages."""
    return {found for found in IMPORTS if is_within(found.of, [of]) and is_within(found.by, by)}


def test_a_circle_is_found() -> None:
    a, b = "rollgait.errors", "rollgait.config"
    assert circle([Import(a, b, "load")]) == []
    assert set(circle([Import(a, b, "load"), Import(b, a, "call")])) == {a, b}


def test_no_circle_even_of_types() -> None:
    assert circle(IMPORTS) == []


ROOMS = {
    "casadi": {"dynamics", "ocp", "transcription", "solvers"},
    "mujoco": {"simulation", "robot.mjcf"},
    "pinocchio": {"tracking", "robot"},
    "viser": {"view"},
}
INSTALLED = {Import("rollgait.mpc.setup", "mujoco", "call")}
"""It only asks whether the library is there, to say which extra is missing."""


@pytest.mark.parametrize("library", ROOMS)
def test_a_library_is_imported_in_its_rooms_only(library: str) -> None:
    found = {found for found in IMPORTS if is_within(found.of, [library])}
    assert found
    rooms = [f"rollgait.{room}" for room in ROOMS[library]]
    assert {one for one in found if not is_within(one.by, rooms)} <= INSTALLED


def test_controller_and_simulation_do_not_import_each_other() -> None:
    assert offenders("rollgait.mpc", ["rollgait.simulation"]) == set()
    joins = {Import("rollgait.mpc.setup", "rollgait.simulation.plant", "call")}
    assert offenders("rollgait.simulation", ["rollgait.mpc"]) == joins


def test_what_both_stand_on_knows_neither() -> None:
    for upper in ("mpc", "simulation", "tracking", "ocp", "transcription", "solvers", "plan"):
        assert offenders(f"rollgait.{upper}", ["rollgait.plant", "rollgait.angles"]) == set()


def test_the_judge_shares_nothing_with_the_optimiser() -> None:
    for room in ("ocp", "transcription", "solvers", "dynamics"):
        assert offenders(f"rollgait.{room}", ["rollgait.plan.certificate"]) == set()


def test_nobody_borrows_the_judges_physics() -> None:
    others = [name for name in MODULES if not is_within(name, ["rollgait.plan.certificate"])]
    found = {one for one in IMPORTS if one.of == "rollgait.plan.certificate.physics" and one.by in others}
    assert found == set()
