"""A configuration of RViz 2 that shows a bag: `rviz2 -d FILE`. YAML."""

from __future__ import annotations

import io
from typing import Any, Final

from ruamel.yaml import YAML

from rollgait.export.ros2 import Recording
from rollgait.ros import topics
from rollgait.ros.markers import COLOURS
from rollgait.ros.topics import Topic

FRAME_RATE: Final = 30
"""Pictures per second."""
LINE_WIDTH: Final = 0.02
"""Of paths, m."""


def rviz_of(recording: Recording) -> str:
    """The text of the configuration."""
    names = recording.names
    manager = {
        "Class": "",
        "Displays": list(_displays(recording)),
        "Enabled": True,
        "Global Options": {
            "Background Color": "48; 48; 48",
            "Fixed Frame": names.odom,
            "Frame Rate": FRAME_RATE,
        },
        "Name": "root",
        "Tools": [{"Class": f"rviz_default_plugins/{tool}"} for tool in ("Interact", "MoveCamera", "Select")],
        "Transformation": {"Current": {"Class": "rviz_default_plugins/TF"}},
        "Value": True,
        "Views": {"Current": _view(names.base), "Saved": None},
    }
    panels = [
        {"Class": "rviz_common/Displays", "Name": "Displays"},
        {"Class": "rviz_common/Views", "Name": "Views"},
        {"Class": "rviz_common/Time", "Name": "Time"},
    ]
    content = {"Panels": panels, "Visualization Manager": manager}
    yaml, stream = YAML(typ="safe"), io.StringIO()
    yaml.default_flow_style = False
    yaml.dump(content, stream)
    return stream.getvalue()


def _view(frame: str) -> dict[str, Any]:
    return {
        "Class": "rviz_default_plugins/Orbit",
        "Name": "Current View",
        "Distance": 4.0,
        "Pitch": 0.5,
        "Yaw": 0.8,
        "Target Frame": frame,
        "Value": "Orbit (rviz)",
        "Focal Point": {"X": 0.0, "Y": 0.0, "Z": 0.0},
    }


def _displays(recording: Recording) -> list[dict[str, Any]]:
    markers = _display("MarkerArray", "Forces", topics.MARKERS)
    markers["Namespaces"] = {"body": False, "feet": False, "forces": True}
    tints = ((0.9, 0.9, 0.9), *COLOURS)
    return [
        {"Class": "rviz_default_plugins/Grid", "Name": "Grid", "Enabled": True, "Value": True},
        _display("RobotModel", "Robot", topics.ROBOT_DESCRIPTION, "Description Topic")
        | {"Description Source": "Topic", "Visual Enabled": True, "Collision Enabled": False},
        {"Class": "rviz_default_plugins/TF", "Name": "TF", "Enabled": False, "Value": False},
        _display("Marker", "Ground", topics.GROUND),
        _display("MarkerArray", "Footholds", topics.FOOTHOLDS),
        markers,
        *(
            _display("Path", f"Path {topic.name}", topic)
            | {"Line Style": "Billboards", "Line Width": LINE_WIDTH, "Color": _colour(tint)}
            for topic, tint in zip((topics.COM_PATH, *topics.FOOT_PATHS), tints, strict=True)
        ),
    ]


def _display(kind: str, name: str, topic: Topic, field: str = "Topic") -> dict[str, Any]:
    quality = topic.quality
    return {
        "Class": f"rviz_default_plugins/{kind}",
        "Name": name,
        "Enabled": True,
        "Value": True,
        field: {
            "Value": topic.name,
            "Depth": quality.depth,
            "Durability Policy": "Transient Local" if quality.latched else "Volatile",
            "History Policy": "Keep Last",
            "Reliability Policy": "Reliable",
        },
    }


def _colour(tint: tuple[float, float, float]) -> str:
    return "; ".join(str(round(255 * part)) for part in tint)
