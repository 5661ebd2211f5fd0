"""xacro files as URDF, where a package is installed that expands them."""

from __future__ import annotations

import importlib
import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from rollgait.errors import FileError

NAMESPACES: Final = (
    "{http://www.ros.org/wiki/xacro}",
    "{http://ros.org/wiki/xacro}",
    "{https://www.ros.org/wiki/xacro}",
)
"""Begin the tags of a file that is yet to be expanded."""

REASON_MAX: Final = 200
"""Most characters of the package's own words in a message."""


def is_xacro(root: ET.Element) -> bool:
    """Whether a file is yet to be expanded."""
    return any(str(part.tag).startswith(NAMESPACES) for part in root.iter())


def expanded(file: Path) -> ET.Element:
    """The URDF that a xacro file stands for, with the defaults of its arguments.

    Raises:
        FileError: no package that expands it is installed, or that one does not understand it.
    """
    return ET.fromstring(_text(file.absolute(), file.stat().st_mtime_ns))


@lru_cache(maxsize=8)
def _text(file: Path, written: int) -> str:
    """The URDF of a file that was written at this time, ns."""
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
    command = f"xacro {file.name} > {_plain(file)}"
    rule = f"is a xacro file: pip install xacrodoc, or run {command} and give the file that it writes"
    raise FileError("urdf", str(file), rule)


def _plain(file: Path) -> str:
    """A name for the URDF that comes out of a xacro file."""
    name = file.name.removesuffix(".xacro").removesuffix(".urdf")
    return f"{name}.urdf" if file.name != f"{name}.urdf" else f"{name}-expanded.urdf"
