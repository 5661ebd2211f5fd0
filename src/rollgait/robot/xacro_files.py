"""xacro files as URDF, where a package is installed that expands them."""

from __future__ import annotations

import importlib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, Final

from rollgait.errors import FileError
from rollgait.files import replacing

NAMESPACES: Final = (
    "{http://www.ros.org/wiki/xacro}",
    "{http://ros.org/wiki/xacro}",
    "{https://www.ros.org/wiki/xacro}",
)
"""Begin the tags of a file that is yet to be expanded."""

EXPANDED: Final = "-expanded.urdf"
"""Ends the name of a URDF that an import has written beside its xacro file."""

REASON_MAX: Final = 200
"""Most characters of the package's own words in a message."""


def is_xacro(root: ET.Element) -> bool:
    """Whether a file is yet to be expanded."""
    return any(str(part.tag).startswith(NAMESPACES) for part in root.iter())


def expand(file: Path) -> Path:
    """Writes the URDF that a xacro file stands for, with the defaults of its arguments, beside it.

    Asked for by an import only: such files hold expressions, and what else opens a robot runs none.

    Raises:
        FileError: no package that expands it is installed, that one does not understand it, or the URDF
            cannot be written.
    """
    urdf = file.with_name(f"{_plain(file)}{EXPANDED}")
    text = _text(file)
    with replacing(urdf) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return urdf


def refusal(file: Path) -> FileError:
    """What to do with a xacro file where a URDF must be."""
    command = f"xacro {file.name} > {_plain(file)}{EXPANDED}"
    rule = "is a xacro file: pip install xacrodoc, and rollgait robot import expands it; or run"
    return FileError("urdf", str(file), f"{rule} {command} and give the file that it writes")


def _text(file: Path) -> str:
    for name in ("xacrodoc", "xacro"):
        try:
            package: Any = importlib.import_module(name)
        except ImportError:
            continue
        try:
            if name == "xacrodoc":
                return str(package.XacroDoc.from_file(str(file)).to_urdf_string())
            return str(package.process_file(str(file)).toxml())
        except Exception as error:  # the package's own, and whatever an expression in the file raises
            reason = " ".join(str(error).split())[:REASON_MAX]
            raise FileError("urdf", str(file), f"is a xacro file that {name} refuses: {reason}") from None
    raise refusal(file)


def _plain(file: Path) -> str:
    """The name of a xacro file without what it ends in."""
    return file.name.removesuffix(".xacro").removesuffix(".urdf")
