"""`rollgait cache`: what is there, and its end."""

from __future__ import annotations

import json
from pathlib import Path

import casadi as ca
import pytest

from rollgait.cli.app import run
from rollgait.solvers.kernels import cached_kernels, compiled


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ROLLGAIT_CACHE", str(tmp_path / "kernels"))
    return tmp_path / "kernels"


def output(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert run(["cache", *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def make_kernel(name: str) -> None:
    x = ca.SX.sym("x")
    assert compiled(lambda: [ca.Function(name, [x], [ca.sin(x)])], [name], known_by=name) is not None


def test_an_empty_cache(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert output(capsys) == f"folder:  {folder}\nkernels: 0, 0 KiB\n"
    assert json.loads(output(capsys, "--json")) == {"folder": str(folder), "kernels": []}


def test_it_shows_every_kernel_and_clears_them(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make_kernel("one_kernel")
    make_kernel("another_kernel")
    names = [kernel.path.name for kernel in cached_kernels()]
    text = output(capsys)
    assert text.startswith(f"folder:  {folder}\nkernels: 2, ")
    for name in names:
        assert f"\n  {name}" in text
    listed = json.loads(output(capsys, "--json"))["kernels"]
    assert {kernel["file"] for kernel in listed} == set(names)
    assert all(0.0 <= kernel["age"] < 600.0 and kernel["bytes"] > 0 for kernel in listed)
    assert output(capsys, "--clear") == f"folder:  {folder}\nremoved: 2\n"
    assert list(folder.iterdir()) == []


def test_a_cache_that_is_switched_off(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROLLGAIT_CACHE", "off")
    assert output(capsys).startswith("folder:  off")
    assert output(capsys, "--clear").endswith("removed: 0\n")
