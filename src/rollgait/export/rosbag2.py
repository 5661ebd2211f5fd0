"""A motion as a rosbag2: a folder with metadata.yaml and a database, as `ros2 bag` has it since Foxy."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Final

from rollgait.errors import FileError
from rollgait.export.motion import Motion
from rollgait.export.ros2 import TOPICS, messages, qualities, typestore

VERSION: Final = 8
"""Of the metadata: Humble and all later ones read it."""


def write_rosbag2(motion: Motion, path: Path, rate: float) -> Path:
    """Writes the motion, sampled at `rate` (Hz), as the folder `path`; returns it.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
        FileError: there is something at `path`, or it cannot be written.
    """
    types = typestore()
    from rosbags.rosbag2 import Writer

    if path.exists():
        raise FileError("file", str(path), "cannot be written: a rosbag2 is a new folder, and this is there")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    except OSError as error:
        raise FileError("file", str(path), f"cannot be written: {error.strerror}") from None
    try:
        with Writer(folder / path.name, version=VERSION) as writer:
            connections = {
                topic.name: writer.add_connection(
                    topic.name, topic.type, typestore=types, offered_qos_profiles=qualities(topic)
                )
                for topic in TOPICS
            }
            for message in messages(motion, rate):
                writer.write(connections[message.topic.name], message.time, message.data)
        (folder / path.name).replace(path)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return path
