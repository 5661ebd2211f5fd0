"""XML from files that may be hostile: bounded in size and depth, without entities."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Final

from rollgait.errors import FileError

BYTES_MAX: Final = 4_000_000
"""Largest file that is read: the largest public URDFs have 0.3 MB."""

DEPTH_MAX: Final = 100
"""Deepest nesting that is read: a URDF needs 6, its extensions for simulators a dozen."""


def read_xml(field: str, file: Path) -> ET.Element:
    """The root of an XML file.

    Args:
        field: what an error calls the file.
        file: the file.

    Raises:
        FileError: it is missing, no regular file, too large, or no XML that is read here.
    """
    if not file.is_file():
        raise FileError(field, str(file), "cannot be read: there is no such file")
    try:
        size = file.stat().st_size
        if size <= BYTES_MAX:
            return ET.parse(file, ET.XMLParser(target=_Builder())).getroot()
    except OSError as error:
        raise FileError(field, str(file), f"cannot be read: {error.strerror}") from None
    except LookupError:
        raise FileError(field, str(file), "names an encoding that is not known") from None
    except (ET.ParseError, ValueError) as error:  # ValueError: an encoding that expat does not read
        raise FileError(field, str(file), f"is not valid XML: {error}") from None
    raise FileError(field, str(file), f"has {size} bytes, must have at most {BYTES_MAX}")


class _Builder(ET.TreeBuilder):
    """Builds the tree as long as it stays one that a robot could need."""

    _depth = 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        """Called before the entities are read that a DOCTYPE may define, each by many of the one before."""
        raise ValueError("a DOCTYPE is not read")

    def start(self, tag: str, attributes: dict[str, str]) -> ET.Element:
        self._depth += 1
        if self._depth > DEPTH_MAX:
            raise ValueError(f"its elements are nested deeper than {DEPTH_MAX}")
        return super().start(tag, attributes)

    def end(self, tag: str) -> ET.Element:
        self._depth -= 1
        return super().end(tag)
