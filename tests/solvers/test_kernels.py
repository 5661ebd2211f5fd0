"""Compiled kernels: the same numbers, one for all robots, and never in the way of a plan."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from rollgait.solvers.kernels import cache_folder, cached_kernels, clear_cache, compiled
from rollgait.transcription.condensed import transcribe
from tests.transcription.problems import small_problem

PLANNING = """
import logging, sys
logging.basicConfig(format="log: %(message)s", level=logging.INFO, stream=sys.stdout)
import rollgait as rg
scenario = rg.find_scenario("wheeled").with_values({"horizon": 2.0, "goal": {"x": 0.1}})
for _ in range(2):
    plan = rg.plan(scenario)
print("cost:", round(plan.statistics.cost, 6))
"""
"""Plans twice and prints what is logged."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("ROLLGAIT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def small_functions(name: str = "small") -> list[ca.Function]:
    x = ca.SX.sym("x", 3)
    return [
        ca.Function(f"{name}_a", [x], [ca.sin(x) * x[0], ca.sumsqr(x)]),
        ca.Function(f"{name}_b", [x], [ca.jacobian(ca.exp(x), x)]),
    ]


def assert_same(fast: Sequence[ca.Function] | None, slow: Sequence[ca.Function], *arguments: Any) -> None:
    assert fast is not None
    for a, b in zip(fast, slow, strict=True):
        for found, wanted in zip(a.call(list(arguments)), b.call(list(arguments)), strict=True):
            np.testing.assert_allclose(np.array(found), np.array(wanted), rtol=1e-12, atol=1e-12)


# -- numbers -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["steerable", "fixed"])
def test_compiled_and_uncompiled_functions_agree(kind: str) -> None:
    problem = small_problem(kind)
    slow, fast = transcribe(problem).nlp, transcribe(problem, compiled).nlp
    generator = np.random.default_rng(0)
    w = slow.lower.clip(-1.0, None).clip(None, slow.upper) + generator.uniform(0.0, 0.1, slow.size)
    lam = generator.normal(size=slow.rows)
    for name, arguments in (("nlp_grad_f", ()), ("nlp_jac_g", ()), ("nlp_hess_l", (0.7, lam))):
        results = [nlp.functions[name].call([w, nlp.parameters, *arguments]) for nlp in (fast, slow)]
        for found, wanted in zip(*results, strict=True):
            scale = max(1.0, float(np.abs(np.array(wanted)).max()))
            np.testing.assert_allclose(np.array(found) / scale, np.array(wanted) / scale, atol=1e-12)


def test_one_kernel_serves_all_robots_intervals_and_goals() -> None:
    """A kernel is known by its C text, so that all of these must have the same."""
    texts = set()

    def note(functions: Sequence[ca.Function]) -> None:
        generator = ca.CodeGenerator("kernel.c")
        for function in functions:
            generator.add(function)
        texts.add(generator.dump())

    for values in (
        {"robot": "centauro-2020"},
        {"robot": "centauro"},
        {"interval": 0.1},
        {"horizon": 1.8, "goal": {"x": 0.3, "yaw_deg": 20}, "weights": {"acc": 3.0}},
        {"gait": {"kind": "schedule", "FR": [[0.3, 0.6]]}, "ground": {"height": 0.5, "friction": 0.3}},
    ):
        transcribe(small_problem(**values, profile="paper"), note)  # whose terms no robot is without
        assert len(texts) == 1, values


# -- the cache -----------------------------------------------------------------------------------------------


def test_a_kernel_is_built_once_and_cleared_away(folder: Path) -> None:
    assert cache_folder() == folder
    assert cached_kernels() == []
    functions = small_functions()
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])
    (kernel,) = cached_kernels()
    assert kernel.path.parent == folder
    assert kernel.size == kernel.path.stat().st_size > 0
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])
    assert cached_kernels() == [kernel]
    compiled(small_functions("other"))
    assert len(cached_kernels()) == 2
    assert clear_cache() == 2
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("damage", [b"", b"\x7fELF", b"not a library", None], ids=repr)
def test_a_damaged_or_foreign_file_is_rebuilt(folder: Path, damage: bytes | None) -> None:
    name = f"damaged{0 if damage is None else len(damage)}"  # a library that is loaded stays loaded
    functions = small_functions(name)
    subprocess.run([sys.executable, "-c", BUILD.format(name=name)], check=True, env=os.environ)
    (kernel,) = cached_kernels()
    whole = kernel.path.read_bytes()
    kernel.path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])
    assert kernel.path.read_bytes() == whole


def test_a_file_without_its_digest_is_rebuilt(folder: Path) -> None:
    functions = small_functions("undigested")
    subprocess.run([sys.executable, "-c", BUILD.format(name="undigested")], check=True, env=os.environ)
    (kernel,) = cached_kernels()
    kernel.path.write_bytes(b"whatever")
    kernel.path.with_suffix(".sha256").unlink()
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])


BUILD = """
import numpy as np
from tests.solvers.test_kernels import assert_same, small_functions
from rollgait.solvers.kernels import compiled
functions = small_functions("{name}")
assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])
"""


def test_processes_that_start_at_once_do_not_disturb_each_other(folder: Path) -> None:
    command = [sys.executable, "-c", BUILD.format(name="together")]
    started = [subprocess.Popen(command, env=os.environ, stderr=subprocess.PIPE) for _ in range(4)]
    errors = [process.communicate()[1].decode() for process in started]
    assert [process.returncode for process in started] == [0] * 4, errors
    (kernel,) = cached_kernels()
    assert {path.name for path in folder.iterdir()} == {
        kernel.path.name,
        kernel.path.with_suffix(".sha256").name,
    }
    functions = small_functions("together")
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])


# -- without -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"CC": "no-such-compiler"}, ["no C compiler found: planning without compiled kernels"]),
        ({"PATH": ""}, ["no C compiler found: planning without compiled kernels"]),
        ({"CC": "false"}, ["kernels cannot be compiled (the compiler failed): planning without"]),
        (
            {"ROLLGAIT_CACHE": "{file}/cache"},
            ["kernels cannot be compiled (Not a directory): planning without"],
        ),
        ({"ROLLGAIT_CACHE": "off"}, []),  # as was asked for
    ],
    ids=["unknown compiler", "empty path", "failing compiler", "no place", "off"],
)
def test_without_kernels_it_plans_all_the_same_and_says_so_once(
    environment: dict[str, str], said: list[str], tmp_path: Path
) -> None:
    file = tmp_path / "file"
    file.write_text("in the way of a folder")
    given = {"ROLLGAIT_CACHE": str(tmp_path / "cache")}
    given |= {name: value.format(file=file) for name, value in environment.items()}
    done = subprocess.run(
        [sys.executable, "-c", PLANNING], env=os.environ | given, capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    log = [line.removeprefix("log: ") for line in lines if line.startswith("log: ")]
    assert [line for line in log if not line.startswith("compiling")] == said
    assert lines[-1].startswith("cost: ")
    assert done.stderr == ""
