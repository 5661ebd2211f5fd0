"""A motion as a rosbag2: a folder with metadata.yaml and a database, as `ros2 bag` has it since Foxy."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Final

from rollgait.errors import FileError
from rollgait.export.beside import write_beside
from rollgait.export.controllers import Controllers
from rollgait.export.description import Meshes
from rollgait.export.motion import Motion
from rollgait.export.qualities import offered
from rollgait.export.ros2 import Recording
from rollgait.ros.cdr import typestore

VERSION: Final = 8
"""Of the metadata: Humble and all later ones read it."""


def write_rosbag2(
    motion: Motion, path: Path, rate: float, meshes: Meshes = "beside", controllers: Controllers | None = None
) -> Path:
    """Writes the motion, sampled at `rate` (Hz), as the folder `path`, and what shows it beside that.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
        FileError: there is something at `path`, or it cannot be written.
    """
    types = typestore()
    from rosbags.rosbag2 import Writer

    if path.exists():
        raise FileError("file", str(path), "cannot be written: a rosbag2 is a new folder, and this is there")
    recording = Recording(motion, rate, meshes, controllers)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    except OSError as error:
        raise FileError("file", str(path), f"cannot be written: {error.strerror}") from None
    try:
        with Writer(folder / path.name, version=VERSION) as writer:
            connections = {
                topic.name: writer.add_connection(
                    topic.name, topic.type, typestore=types, offered_qos_profiles=[offered(topic.quality)]
                )
                for topic in recording.topics
            }
            for message in recording.messages():
                writer.write(connections[message.topic.name], message.time, message.data)
        (folder / path.name).replace(path)
    except OSError as error:
        raise FileError("file", str(path), f"cannot be written: {error.strerror or error}") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    write_beside(recording, path)
    return path
