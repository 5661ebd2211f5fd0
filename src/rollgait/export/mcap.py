"""A motion as one MCAP file with messages of ROS 2: Foxglove opens it, `ros2 bag play FILE` plays it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rollgait.errors import MissingExtraError
from rollgait.export.motion import Motion
from rollgait.export.ros2 import TOPICS, Topic, definition, messages, qualities
from rollgait.files import replacing


def write_mcap(motion: Motion, path: Path, rate: float) -> Path:
    """Writes the motion, sampled at `rate` (Hz), as MCAP; returns the path.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        raise MissingExtraError("an export to mcap", "mcap") from None
    with replacing(path) as temporary, temporary.open("wb") as stream:
        writer: Any = Writer(stream)
        writer.start(profile="ros2", library="rollgait")
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for topic in TOPICS:
            if topic.type not in schemas:
                text = definition(topic).encode()
                schemas[topic.type] = writer.register_schema(topic.type, "ros2msg", text)
            channels[topic.name] = writer.register_channel(
                topic.name, "cdr", schemas[topic.type], metadata=_metadata(topic)
            )
        for number, message in enumerate(messages(motion, rate)):
            writer.add_message(
                channel_id=channels[message.topic.name],
                log_time=message.time,
                publish_time=message.time,
                data=message.data,
                sequence=number,
            )
        writer.finish()
    return path


def _metadata(topic: Topic) -> dict[str, str]:
    """What `ros2 bag` looks for beside a topic."""
    from rosbags.rosbag2.metadata import dump_qos_v8

    offered = list(qualities(topic))
    return {"offered_qos_profiles": dump_qos_v8(offered)} if offered else {}
