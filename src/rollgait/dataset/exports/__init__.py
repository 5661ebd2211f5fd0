"""Data sets as others load them: one module for each format, and one that makes the motions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rollgait.errors import FileError, UnknownNameError
from rollgait.files import check_writable

if TYPE_CHECKING:
    from rollgait.dataset.dataset import Dataset
    from rollgait.dataset.exports.motions import Written

FORMATS: Final = {
    "lerobot": "a LeRobot data set, v3.0: episodes of states and actions",
    "isaaclab": "one .npz of joints and bodies for each motion, as Isaac Lab's motion loader reads it",
    "mujoco": "one .xml of keyframes for each motion",
}
"""Every format by its name, and what it is."""


def export(
    dataset: Dataset,
    folder: str | Path,
    format: str = "lerobot",
    rate: float = 50.0,
    *,
    joints: bool = False,
    rows: Sequence[int] | None = None,
    workers: int = -1,
) -> Written:
    """Writes the motions of a data set, sampled at a fixed rate, in a format that others read.

    Args:
        dataset: the data set.
        folder: where to; must be empty or not there.
        format: a key of `FORMATS`.
        rate: frames per second, Hz; a whole number for lerobot and isaaclab.
        joints: lerobot: of the whole body, tracked; the other formats always are.
        rows: which; all whose certificate passes if not given.
        workers: how many motions are tracked at once; −1: one for each core.

    Returns:
        What was written, and what was left out.

    Raises:
        UnknownNameError: there is no such format.
        InputError: the rate is not one of the format.
        MissingExtraError: joints are wanted, and the extra `whole-body` is not installed.
        FileError: the folder cannot be written to, or is not empty.
    """
    if format not in FORMATS:
        raise UnknownNameError("format", format, FORMATS)
    target = Path(folder)
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise FileError("out", str(target), "is not an empty folder: choose another one")
    check_writable(target / "-")  # its name does not matter
    from rollgait.dataset.exports.isaaclab import write_isaaclab
    from rollgait.dataset.exports.lerobot import write_lerobot
    from rollgait.dataset.exports.motions import Motions
    from rollgait.dataset.exports.mujoco import write_mujoco

    motions = Motions(
        dataset, rate, joints or format != "lerobot", rows, workers, bodies=format == "isaaclab"
    )
    writers = {"lerobot": write_lerobot, "isaaclab": write_isaaclab, "mujoco": write_mujoco}
    try:
        return writers[format](motions, target)
    except OSError as error:
        raise FileError("out", str(target), f"cannot be written: {error.strerror or error}") from None


__all__ = ["FORMATS", "export"]
