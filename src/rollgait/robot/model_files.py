"""Where the file of a robot is that is given by a path or by a name."""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from typing import Any, Final

from rollgait.errors import FileError
from rollgait.robot.whole_body import DATA_PREFIX, PUBLIC, data_file
from rollgait.robot.xacro_files import expand, is_xacro
from rollgait.robot.xml_files import read_xml

MODULES: Final = ("{}", "{}_description", "{}_mj_description")
"""How its modules may be named after a robot: URDFs before MJCF."""

PATHS: Final = ("URDF_PATH", "XACRO_PATH", "MJCF_PATH")
"""Under which names they tell their files."""


def model_file(model: str | Path) -> Path:
    """The file of a robot: as given, or that of a public robot of this name, where that package is there.

    A xacro file is expanded: the file is the URDF that is written beside it.

    Args:
        model: a path, also one that begins with `example-robot-data:`, in that package; or a name such as
            `go2_description` or `go2`, which no file and no folder has.

    Raises:
        FileError: the package knows the robot, but its files cannot be had; or a file is no XML, or xacro
            that cannot be expanded.
    """
    path = _named(model)
    if not path.is_file() or path.suffix in (".yaml", ".yml") or not is_xacro(read_xml("urdf", path)):
        return path
    return expand(path)


def _named(model: str | Path) -> Path:
    path = Path(model)
    name = str(model)
    if name.startswith(DATA_PREFIX):
        return data_file("urdf", name)
    if path.exists() or not name.isidentifier() or importlib.util.find_spec(PUBLIC) is None:
        return path
    for pattern in MODULES:
        module = f"{PUBLIC}.{pattern.format(name)}"
        if importlib.util.find_spec(module) is not None:
            return _file_of(name, module) or path
    return path


def _file_of(name: str, module: str) -> Path | None:
    """The file that a module of the package tells, fetched if it is not there yet; None if it tells none."""
    try:
        public: Any = importlib.import_module(module)
    except Exception as error:  # of git, of the network, of the package itself
        reason = " ".join(str(error).split())[:200]
        raise FileError("model", name, f"cannot be had from {PUBLIC}: {reason}") from None
    paths = [getattr(public, key) for key in PATHS if hasattr(public, key)]
    return Path(paths[0]) if paths else None
