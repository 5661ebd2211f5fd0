"""From a URDF that someone owns to a robot: with a file that names its legs, or without any."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollgait.errors import MISSING, FileError, InputError, MissingExtraError
from rollgait.robot.model_files import model_file
from rollgait.robot.whole_body import (
    EXTRA,
    WholeBody,
    library_whole_body,
    load_whole_body,
    whole_body_names,
)

if TYPE_CHECKING:
    from rollgait.robot.urdf import ImportedRobot


def import_robot(
    model: str | Path,
    *,
    legs: str | Path | None = None,
    srdf: str | Path | None = None,
    posture: str | None = None,
) -> ImportedRobot:
    """The planner's robot of a URDF, and what it is made of; `save` writes it.

    Args:
        model: a .urdf, MJCF or xacro file, also `example-robot-data:PATH` in that package; the .yaml that
            describes one; or the name of a robot: in the library, or in the package `robot_descriptions`
            where that is installed.
        legs: file that names the legs' frames and joints; if not given the .yaml beside the URDF; if there is
            none, they are found by chains, symmetry and axes.
        srdf: SRDF with the posture; only that is read of it.
        posture: group state of the SRDF from which the stance is derived; must be given with an SRDF.

    Raises:
        InputError: a file is wrong or missing, or the legs must be named.
        MissingExtraError: the extra `whole-body` is not installed.
    """
    try:
        import pinocchio  # noqa: F401
    except ImportError:
        raise MissingExtraError("importing a URDF", EXTRA) from None
    from rollgait.robot.urdf import import_robot as import_body

    place = model if str(model) in whole_body_names() else model_file(model)
    file, body = _described(Path(place), None if legs is None else Path(legs))
    found = body is None
    if body is None:
        from rollgait.robot.urdf_discovery import discover

        body = discover(Path(place))
    given: dict[str, Any] = {"srdf": srdf and str(_existing("srdf", Path(srdf))), "posture": posture}
    if found and posture is not None:
        given["joints"] = {}  # those that were found would be over those of the SRDF
    body = body.model_copy(update={key: value for key, value in given.items() if value is not None})
    if srdf is not None and body.posture is None:
        from rollgait.robot.urdf_files import posture_names

        rule = "must name a group state of the SRDF, of which nothing else is read"
        raise InputError("posture", MISSING, rule, posture_names(str(body.srdf)))
    return import_body(body, None if file is None else str(file.absolute()), found=found)


def _described(model: Path, legs: Path | None) -> tuple[Path | None, WholeBody | None]:
    """The file that describes the whole body (None for one of the library), and what it says, if any does."""
    if model.suffix in (".yaml", ".yml"):
        return model, load_whole_body(model)
    if model.suffix == "" and legs is None and not model.exists():
        return None, library_whole_body(str(model))
    _existing("urdf", model)
    if legs is not None:
        _existing("legs", legs)
    file = legs or model.with_suffix(".yaml")
    if not file.is_file():
        return None, None
    return file, load_whole_body(file).model_copy(update={"urdf": str(model.absolute())})


def _existing(field: str, path: Path) -> Path:
    if path.is_dir():
        raise FileError(field, str(path), "cannot be read: it is a folder")
    if not path.is_file():
        raise FileError(field, str(path), "cannot be read: there is no such file")
    return path.absolute()
