"""A layout for Foxglove that shows a bag: the robot, its feet and forces, and what its joints do.

It is what the app imports by "Import from file": each panel's settings by its id, and how the panels lie.
"""

from __future__ import annotations

from typing import Any, Final

from rollgait.export.ros2 import Recording
from rollgait.ros import topics
from rollgait.ros.topics import LEGS

SCENE: Final = "3D!rollgait"
PLOTS: Final = ("Plot!forces", "Plot!base", "Plot!joints")
JOINTS_SHOWN: Final = 8
"""Most joints in the plot: more lines are not told apart."""
COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of the legs, as in the markers."""


def layout_of(recording: Recording) -> dict[str, Any]:
    """The layout as plain data for JSON."""
    forces, base, joints = PLOTS
    return {
        "configById": {
            SCENE: _scene(recording),
            forces: _plot("Normal contact forces, N", _forces()),
            base: _plot("Speed of the base, m/s and rad/s", _base()),
            joints: _plot("Joint velocities, rad/s", _joints(recording)),
        },
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1.0},
        "layout": {
            "direction": "row",
            "first": SCENE,
            "second": {
                "direction": "column",
                "first": forces,
                "second": {"direction": "column", "first": base, "second": joints, "splitPercentage": 50},
                "splitPercentage": 34,
            },
            "splitPercentage": 62,
        },
    }


def _scene(recording: Recording) -> dict[str, Any]:
    names = recording.names
    shown: dict[str, Any] = {
        topic.name: {"visible": True} for topic in recording.topics if topic.type in _SEEN
    }
    shown[topics.ROBOT_DESCRIPTION.name] = {"visible": True, "displayMode": "auto"}
    # the robot is there already, so of these only the forces
    hidden = {"visible": False}
    shown[topics.MARKERS.name] = {"visible": True, "namespaces": {"body": hidden, "feet": hidden}}
    frames = {f"frame:{link}": hidden for link in recording.links if link not in (names.odom, names.base)}
    return {
        "cameraState": {
            "perspective": True,
            "distance": 4.0,
            "phi": 65.0,
            "thetaOffset": 45.0,
            "fovy": 45.0,
            "near": 0.05,
            "far": 500.0,
        },
        "followMode": "follow-position",
        "followTf": names.base,
        # STL says nothing of up; ROS means z, and RViz takes no notice of what COLLADA says
        "scene": {"meshUpAxis": "z_up", "ignoreColladaUpAxis": True, "transforms": {"showLabel": False}},
        "transforms": frames,
        "topics": shown,
        "layers": {
            "grid": {
                "layerId": "foxglove.Grid",
                "instanceId": "grid",
                "label": "Grid",
                "visible": True,
                "frameId": names.odom,
                "size": 10.0,
                "divisions": 10,
                "position": [0.0, 0.0, 0.0],
                "rotation": [0.0, 0.0, 0.0],
            }
        },
    }


_SEEN: Final = ("nav_msgs/msg/Path", "visualization_msgs/msg/Marker", "visualization_msgs/msg/MarkerArray")
"""Types that the scene draws."""


def _plot(title: str, series: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "title": title,
        "paths": series,
        "xAxisVal": "timestamp",
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": False,
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "isSynced": True,
        "sidebarDimension": 240,
    }


def _series(value: str, label: str, colour: str | None = None) -> dict[str, Any]:
    found: dict[str, Any] = {
        "value": value,
        "label": label,
        "enabled": True,
        "timestampMethod": "receiveTime",
    }
    return found | ({"color": colour} if colour else {})


def _forces() -> list[dict[str, Any]]:
    wrenches = zip(topics.WRENCHES, LEGS, COLOURS, strict=True)
    return [_series(f"{topic.name}.wrench.force.z", leg, colour) for topic, leg, colour in wrenches]


def _base() -> list[dict[str, Any]]:
    twist = f"{topics.ODOMETRY.name}.twist.twist"
    parts = {"forward": "linear.x", "left": "linear.y", "turn": "angular.z"}
    return [_series(f"{twist}.{part}", name) for name, part in parts.items()]


def _joints(recording: Recording) -> list[dict[str, Any]]:
    """The wheels, or whatever moves first."""
    names = recording.robot.joint_names
    chosen = [name for name in names if name in recording.robot.wheels] or list(names)
    states = topics.JOINT_STATES.name
    return [_series(f"{states}.velocity[{names.index(name)}]", name) for name in chosen[:JOINTS_SHOWN]]
