"""What has the name of a file and is none: pipes, devices, folders, links to them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rollgait.errors import FileError
from rollgait.files import read_bytes
from tests.hostile.conftest import Run

NOT_A_FILE = "cannot be read: it is a pipe or a device, not a file"


def make(kind: str, path: Path) -> None:
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "circle":
        path.symlink_to(path.name)
    else:
        path.symlink_to(kind)


KINDS = {
    "pipe": NOT_A_FILE,
    "/dev/zero": NOT_A_FILE,
    "/dev/stdin": NOT_A_FILE,
    "folder": "cannot be read: Is a directory",
    "circle": "cannot be read: Too many levels of symbolic links",
    "/proc/self/mem": "cannot be read: ",
}


@pytest.mark.parametrize(
    "command",
    [
        "plan {}.yaml",
        "mpc --command {}.yaml",
        "check {}.npz",
        "export {}.npz",
        "record {}.npz",
        "mpc --plant replay:{}.npz",
    ],
)
@pytest.mark.parametrize("kind", ["pipe", "/dev/zero"])
def test_a_command_waits_for_no_pipe_and_reads_no_device(
    kind: str, command: str, tmp_path: Path, rollgait: Run
) -> None:
    for suffix in (".yaml", ".npz"):
        make(kind, tmp_path / f"odd{suffix}")
    rollgait(*command.format("odd").split()).assert_refused(NOT_A_FILE)


@pytest.mark.parametrize(("kind", "says"), KINDS.items())
def test_only_regular_files_are_read(kind: str, says: str, tmp_path: Path) -> None:
    make(kind, tmp_path / "odd")
    with pytest.raises(FileError, match=says):
        read_bytes(tmp_path / "odd", 1000)


def test_a_link_to_a_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"content")
    (tmp_path / "link").symlink_to("file")
    assert read_bytes(tmp_path / "link", 7) == b"content"
    with pytest.raises(FileError, match="is too large: 7e-06 MB; at most 6e-06 MB are read"):
        read_bytes(tmp_path / "link", 6)


def test_a_file_without_a_size_ends_at_the_limit() -> None:
    with pytest.raises(FileError, match="is too large"):
        read_bytes("/proc/self/maps", 100)


def test_a_path_that_no_system_takes() -> None:
    for path in ("a\0b", 5000 * "x", "a/" * 5000):
        with pytest.raises(FileError, match="cannot be read: "):
            read_bytes(path, 100)
