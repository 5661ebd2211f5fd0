"""What is written beside a bag, so that it can be seen at once: a layout, a configuration, and the meshes.

The folder of meshes is an installation prefix as ROS 2 has them. Who adds it to `AMENT_PREFIX_PATH` has the
packages in it, and Foxglove's desktop app finds them below its `share`.
"""

from __future__ import annotations

import json
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path, PurePosixPath
from typing import Final

from rollgait.errors import FileError
from rollgait.export.foxglove import layout_of
from rollgait.export.ros2 import Recording
from rollgait.export.rviz import rviz_of
from rollgait.files import replacing

SHARE: Final = "share"
INDEX: Final = Path(SHARE, "ament_index", "resource_index", "packages")
"""Where an installation prefix says which packages it has, by an empty file of the name of each."""


def write_beside(recording: Recording, path: Path) -> None:
    """Writes what shows a bag. Raises `FileError`."""
    for name, text in texts_beside(recording, path).items():
        with replacing(name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    if recording.robot.meshes:
        _write_meshes(recording.robot.meshes, path.with_name(f"{path.stem}_meshes"))


def texts_beside(recording: Recording, path: Path) -> dict[Path, str]:
    """The texts beside a bag by their places."""
    return {
        path.with_name(f"{path.stem}.foxglove.json"): json.dumps(layout_of(recording), indent=1) + "\n",
        path.with_name(f"{path.stem}.rviz"): rviz_of(recording),
    }


def _write_meshes(meshes: dict[PurePosixPath, Path], folder: Path) -> None:
    packages = sorted({place.parts[0] for place in meshes})
    try:
        for place, file in meshes.items():
            target = folder / SHARE / place
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
        for package in packages:
            mark = folder / INDEX / package
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.touch()
            (folder / SHARE / package / "package.xml").write_text(_manifest(package), encoding="utf-8")
    except OSError as error:
        raise FileError("file", str(folder), f"cannot be written: {error.strerror or error}") from None


def _manifest(package: str) -> str:
    """The `package.xml` of meshes, which is all that this package has."""
    root = ET.Element("package", format="3")
    said = {
        "name": package,
        "version": "0.0.0",
        "description": "Meshes that a bag of rollgait names",
        "license": "that of the meshes",
    }
    for tag, text in said.items():
        ET.SubElement(root, tag).text = text
    ET.indent(root)
    return f'<?xml version="1.0"?>\n{ET.tostring(root, encoding="unicode")}\n'
