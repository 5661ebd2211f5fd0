"""An interruption leaves the old file or none, never half of one."""

from pathlib import Path

import pytest

from rollgait.errors import FileError
from rollgait.files import check_writable, replacing


def test_what_ends_well_takes_the_place(tmp_path: Path) -> None:
    with replacing(tmp_path / "new" / "a.txt") as temporary:
        temporary.write_text("done")
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["a.txt"]


def _write_half(path: Path, interruption: type[BaseException]) -> None:
    path.write_text("ha")
    raise interruption


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, RuntimeError])
def test_what_is_interrupted_leaves_the_old(tmp_path: Path, interruption: type[BaseException]) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(interruption), replacing(target) as temporary:
        _write_half(temporary, interruption)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_failing_disk_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be written"), replacing(tmp_path / "a.txt"):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_known_before(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    for place in (tmp_path, file / "a.npz"):
        with pytest.raises(FileError, match="cannot be written"):
            check_writable(place)
    check_writable(tmp_path / "some" / "new" / "folder" / "a.npz")
    assert list(tmp_path.iterdir()) == [file]
