"""A motion as one MCAP file with messages of ROS 2: Foxglove opens it, `ros2 bag play FILE` plays it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rollgait.errors import MissingExtraError
from rollgait.export.beside import write_beside
from rollgait.export.controllers import Controllers
from rollgait.export.description import Meshes
from rollgait.export.motion import Motion
from rollgait.export.qualities import offered, offered_text
from rollgait.export.ros2 import Recording
from rollgait.files import replacing
from rollgait.ros.cdr import definition


def write_mcap(
    motion: Motion, path: Path, rate: float, meshes: Meshes = "beside", controllers: Controllers | None = None
) -> Path:
    """Writes the motion, sampled at `rate` (Hz), as MCAP, and what shows it beside it; returns the path.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        raise MissingExtraError("an export to mcap", "mcap") from None
    recording = Recording(motion, rate, meshes, controllers)
    with replacing(path) as temporary, temporary.open("wb") as stream:
        writer: Any = Writer(stream)
        writer.start(profile="ros2", library="rollgait")
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for topic in recording.topics:
            if topic.type not in schemas:
                text = definition(topic.type).encode()
                schemas[topic.type] = writer.register_schema(topic.type, "ros2msg", text)
            metadata = {"offered_qos_profiles": offered_text(offered(topic.quality))}
            channels[topic.name] = writer.register_channel(topic.name, "cdr", schemas[topic.type], metadata)
        for number, message in enumerate(recording.messages()):
            writer.add_message(
                channel_id=channels[message.topic.name],
                log_time=message.time,
                publish_time=message.time,
                data=message.data,
                sequence=number,
            )
        writer.finish()
    write_beside(recording, path)
    return path
