"""Compiled kernels: the same numbers, one for all robots, and never in the way of a plan."""

from __future__ import annotations

import hashlib
import logging
import os
import stat
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from rollgait.errors import FileError, shown
from rollgait.solvers import kernels
from rollgait.solvers.cache_folder import cache_folder
from rollgait.solvers.code_store import DiskStore
from rollgait.solvers.kernels import cached_kernels, clear_cache
from rollgait.solvers.kernels import compiled as compiled_when_needed
from rollgait.transcription.condensed import transcribe
from rollgait.transcription.stage import forget_codes
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


def compiled(functions: Sequence[ca.Function]) -> list[ca.Function] | None:
    names = [function.name() for function in functions]
    return compiled_when_needed(lambda: functions, names, known_by=" ".join(names))


def assert_same(fast: Sequence[ca.Function] | None, slow: Sequence[ca.Function], *arguments: Any) -> None:
    assert fast is not None
    for a, b in zip(fast, slow, strict=True):
        for found, wanted in zip(a.call(list(arguments)), b.call(list(arguments)), strict=True):
            np.testing.assert_allclose(np.array(found), np.array(wanted), rtol=1e-12, atol=1e-12)


# -- numbers -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["steerable", "fixed"])
def test_compiled_and_uncompiled_functions_agree(kind: str) -> None:
    problem = small_problem(kind)
    slow, fast = transcribe(problem).nlp, transcribe(problem, DiskStore(kernels=True)).nlp
    generator = np.random.default_rng(0)
    w = slow.lower.clip(-1.0, None).clip(None, slow.upper) + generator.uniform(0.0, 0.1, slow.size)
    lam = generator.normal(size=slow.rows)
    for name, arguments in (("nlp_grad_f", ()), ("nlp_jac_g", ()), ("nlp_hess_l", (0.7, lam))):
        results = [nlp.functions[name].call([w, nlp.parameters, *arguments]) for nlp in (fast, slow)]
        for found, wanted in zip(*results, strict=True):
            scale = max(1.0, float(np.abs(np.array(wanted)).max()))
            np.testing.assert_allclose(np.array(found) / scale, np.array(wanted) / scale, atol=1e-12)


def test_one_code_serves_all_robots_intervals_and_goals() -> None:
    codes = set()
    for values in (
        {"robot": "centauro-2020"},
        {"robot": "centauro"},
        {"interval": 0.1},
        {"horizon": 1.8, "goal": {"x": 0.3, "yaw_deg": 20}, "weights": {"acc": 3.0}},
        {"gait": {"kind": "schedule", "FR": [[0.3, 0.6]]}, "ground": {"height": 0.5, "friction": 0.3}},
    ):
        nlp = transcribe(small_problem(**values, profile="paper")).nlp  # whose terms no robot is without
        codes |= {block.stage.code for block in nlp.blocks}
        assert len(codes) == 2, values


@pytest.mark.parametrize("kernels", [True, False])
def test_a_code_from_disk_is_the_one_that_was_derived(folder: Path, kernels: bool) -> None:
    problem = small_problem()
    derived = transcribe(problem).nlp
    results = []
    for _ in range(2):  # derived and kept, then read
        forget_codes()
        results.append(transcribe(problem, DiskStore(kernels)).nlp)
    assert len(list(folder.glob("*.code.npz"))) == 2
    w = np.random.default_rng(0).uniform(0.0, 0.1, derived.size)
    for nlp in results:
        assert [block.stage.labels for block in nlp.blocks] == [b.stage.labels for b in derived.blocks]
        for name in ("nlp_grad_f", "nlp_jac_g"):
            for found, wanted in zip(
                nlp.functions[name].call([w, nlp.parameters]),
                derived.functions[name].call([w, derived.parameters]),
                strict=True,
            ):
                np.testing.assert_allclose(np.array(found), np.array(wanted), rtol=1e-9, atol=1e-9)


def test_a_cold_process_derives_nothing(folder: Path) -> None:
    forget_codes()
    transcribe(small_problem(), DiskStore(kernels=False))
    forbidden = """
import sys; sys.path.insert(0, {root!r})
import casadi as ca
def derive(*_, **__): raise AssertionError("derived")
ca.jacobian = ca.hessian = ca.gradient = derive
from rollgait.solvers.code_store import DiskStore
from rollgait.transcription.condensed import transcribe
from tests.transcription.problems import small_problem
print(transcribe(small_problem(), DiskStore(kernels=False)).nlp.size)
"""
    root = str(Path(__file__).parents[2])
    command = [sys.executable, "-c", forbidden.format(root=root)]
    subprocess.run(command, check=True, env=os.environ, stdout=subprocess.DEVNULL)


def test_a_damaged_code_is_derived_again(folder: Path) -> None:
    problem = small_problem()
    forget_codes()
    size = transcribe(problem, DiskStore(kernels=False)).nlp.size
    for file in folder.glob("*.code.npz"):
        file.write_bytes(file.read_bytes()[:-200])
    forget_codes()
    assert transcribe(problem, DiskStore(kernels=False)).nlp.size == size


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
from tests.solvers.test_kernels import assert_same, compiled, small_functions
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


# -- whom it trusts ------------------------------------------------------------------------------------------

PLANTED = """
#include <stdio.h>
__attribute__((constructor)) static void run(void) { fclose(fopen("%s", "w")); }
"""
"""A library that leaves a file when it is loaded."""


def plant(kernel: Path, source: str) -> None:
    """Puts another library, with a matching digest, into the place of a kernel."""
    other = kernel.with_suffix(".other")
    subprocess.run(["cc", "-shared", "-fPIC", "-x", "c", "-", "-o", other], input=source.encode(), check=True)
    other.replace(kernel)
    kernel.with_suffix(".sha256").write_text(hashlib.sha256(kernel.read_bytes()).hexdigest())


@pytest.fixture
def said(caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    """What is logged, in a process that has said nothing yet."""
    kernels.say_once.cache_clear()
    caplog.set_level(logging.INFO, "rollgait")
    return caplog


def test_a_new_cache_belongs_to_its_user_alone(folder: Path) -> None:
    mask = os.umask(0)
    try:
        compiled(small_functions())
    finally:
        os.umask(mask)
    for path in (folder, *folder.iterdir()):
        assert stat.S_IMODE(path.stat().st_mode) == 0o700, path


@pytest.mark.parametrize("which", ["folder", "parent"])
def test_a_cache_that_others_can_write_is_refused(
    which: str, folder: Path, tmp_path: Path, said: pytest.LogCaptureFixture
) -> None:
    name = f"open_{which}"
    subprocess.run([sys.executable, "-c", BUILD.format(name=name)], check=True, env=os.environ)
    (kernel,) = cached_kernels()
    plant(kernel.path, PLANTED % (tmp_path / "ran"))
    (folder if which == "folder" else tmp_path).chmod(0o777)
    assert compiled(small_functions(name)) is None
    (line,) = said.messages
    assert line.startswith(f"ROLLGAIT_CACHE: '{folder}' cannot be used: other users can ")
    assert line.endswith(": planning without compiled kernels")
    assert not (tmp_path / "ran").exists()
    for refused in (cached_kernels, clear_cache):
        with pytest.raises(FileError, match="cannot be used: other users can"):
            refused()


def test_a_folder_of_another_user_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch, said: pytest.LogCaptureFixture
) -> None:
    if os.geteuid() == 0:
        folder.mkdir(0o700)
        os.chown(folder, 12345, 12345)
    else:
        monkeypatch.setenv("ROLLGAIT_CACHE", "/usr/lib")
    assert compiled(small_functions()) is None
    (line,) = said.messages
    assert "cannot be used: another user owns it" in line


def test_a_kernel_that_others_can_write_is_rebuilt(folder: Path, tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", BUILD.format(name="writable")], check=True, env=os.environ)
    (kernel,) = cached_kernels()
    plant(kernel.path, PLANTED % (tmp_path / "ran"))
    kernel.path.chmod(0o722)
    functions = small_functions("writable")
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("source", ["int nothing;", None], ids=["lacks the functions", "no library"])
def test_an_unloadable_kernel_with_a_matching_digest_is_rebuilt(folder: Path, source: str | None) -> None:
    name = f"unloadable{source is None}"
    subprocess.run([sys.executable, "-c", BUILD.format(name=name)], check=True, env=os.environ)
    (kernel,) = cached_kernels()
    plant(kernel.path, source or "int nothing;")
    if source is None:
        kernel.path.write_bytes(b"no library")
        kernel.path.with_suffix(".sha256").write_text(hashlib.sha256(b"no library").hexdigest())
    functions = small_functions(name)
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])


def test_what_is_no_kernel_is_not_listed(folder: Path) -> None:
    folder.mkdir(0o700)
    (folder / "folder.so").mkdir()
    (folder / "nowhere.so").symlink_to("missing")
    os.mkfifo(folder / "pipe.so")
    assert cached_kernels() == []
    assert clear_cache() == 0


@pytest.mark.parametrize("command", ["env cc", "'env' LANG=C cc -O0", "{here}/my compiler"])
def test_a_compiler_may_be_a_command_of_several_words(
    command: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = tmp_path / "my compiler"
    script.write_text('#!/bin/sh\nexec cc "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", command.format(here=tmp_path))
    functions = small_functions("words")
    assert_same(compiled(functions), functions, [1.0, 2.0, 3.0])


def test_a_compiler_that_changes_behind_a_launcher_makes_kernels_anew(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler = tmp_path / "compiler"
    monkeypatch.setenv("CC", f"env {compiler}")
    for remark in ("older", "a newer one"):
        compiler.write_text(f'#!/bin/sh\n# {remark}\nexec cc "$@"\n')
        compiler.chmod(0o755)
        compiled(small_functions("launched"))
    assert len(cached_kernels()) == 2


# -- without -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"CC": "no-such-compiler"}, ["no C compiler found: planning without compiled kernels"]),
        ({"PATH": ""}, ["no C compiler found: planning without compiled kernels"]),
        ({"CC": "cc 'open"}, ["no C compiler found: planning without compiled kernels"]),
        ({"CC": "false"}, ["kernels cannot be compiled (the compiler failed): planning without"]),
        (
            {"ROLLGAIT_CACHE": "{file}/cache"},
            [
                "ROLLGAIT_CACHE: '{file}/cache' cannot be used: Not a directory: "
                "planning without compiled kernels"
            ],
        ),
        ({"ROLLGAIT_CACHE": "off"}, []),  # as was asked for
    ],
    ids=["unknown compiler", "empty path", "open quote", "failing compiler", "no place", "off"],
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
    # a value in a message is shortened, and the folder of a test may be long
    shown_file = shown(f"{file}/cache").strip("'")
    assert [line for line in log if not line.startswith("compiling")] == [
        line.replace("{file}/cache", shown_file) for line in said
    ]
    assert lines[-1].startswith("cost: ")
    assert done.stderr == ""
