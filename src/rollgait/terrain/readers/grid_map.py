"""Heights out of a ROS 2 bag: the last `grid_map_msgs/GridMap` on a topic, a layer of it.

A GridMap's matrix has rows along x and columns along y, but counts both backwards: its first cell stands at
the largest x and y. It is a ring in both directions: `outer_start_index` and `inner_start_index` say where
the first cell lies in it, so that a map that moves with the robot need not be copied.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import MISSING, FileError, InputError, MissingExtraError, UnknownNameError
from rollgait.terrain.map_file import MAX_BYTES, RawMap, Source, check_cells

GRID_MAP: Final = "grid_map_msgs/msg/GridMap"

DEFINITIONS: Final = {
    "grid_map_msgs/msg/GridMapInfo": """
float64 resolution
float64 length_x
float64 length_y
geometry_msgs/Pose pose
""",
    GRID_MAP: """
std_msgs/Header header
grid_map_msgs/GridMapInfo info
string[] layers
string[] basic_layers
std_msgs/Float32MultiArray[] data
uint16 outer_start_index
uint16 inner_start_index
""",
}
"""The messages, which are not among those that come with ROS 2 itself, nor with rosbags."""


def typestore() -> Any:
    """The types of ROS 2 and those of a GridMap. Raises `MissingExtraError`."""
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise MissingExtraError("a map out of a ROS 2 bag", "mcap") from None
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def read(source: Source) -> RawMap:
    """The last GridMap in a bag.

    Raises:
        FileError: it cannot be read, or holds no GridMap, or one that contradicts itself.
        UnknownNameError: there is no such topic or layer; lists those that there are.
        MissingExtraError: the extra `mcap` is not installed.
    """
    types = typestore()
    try:
        message = types.deserialize_cdr(_last(source), GRID_MAP)
    except (FileError, InputError):
        raise
    except Exception:  # rosbags raises what it meets, down to struct.error and sqlite3.Error
        raise source.fault("is not a ROS 2 bag that can be read") from None
    return placed(source, message)


def _last(source: Source) -> bytes:
    """The last GridMap on the topic, as CDR."""
    from rosbags.rosbag2 import Reader

    with Reader(source.path) as bag:
        topics = sorted({c.topic for c in bag.connections if c.msgtype == GRID_MAP})
        if not topics:
            raise source.fault(f"must hold a {GRID_MAP}")
        if source.topic is None and len(topics) > 1:
            raise InputError("ground.map.topic", MISSING, f"must say which map in {source.name}", topics)
        if source.topic is not None and source.topic not in topics:
            raise UnknownNameError("ground.map.topic", source.topic, topics, "has no GridMap in this bag")
        wanted = source.topic or topics[0]
        last: bytes | None = None
        for _, _, data in bag.messages([c for c in bag.connections if c.topic == wanted]):
            last = data
    if last is None:
        raise source.fault(f"must hold a message on {wanted}")
    if len(last) > MAX_BYTES:
        raise source.fault(f"must hold a map of at most {MAX_BYTES // 1024**2} MB")
    return bytes(last)


def placed(source: Source, message: Any) -> RawMap:
    """The heights of a GridMap, as rosbags decodes it. Raises `FileError`, `UnknownNameError`."""
    layers = list(message.layers)
    if source.layer not in layers:
        raise UnknownNameError("ground.map.layer", source.layer, layers, "is not a layer of this GridMap")
    info = message.info
    data = message.data[layers.index(source.layer)] if len(message.data) == len(layers) else None
    matrix = None if data is None else _matrix(data)
    resolution, length = float(info.resolution), np.array([info.length_x, info.length_y])
    if matrix is None or not (np.isfinite(length).all() and np.isfinite(resolution) and resolution > 0.0):
        raise source.fault("holds a GridMap that contradicts itself")
    if (np.abs(np.round(length / resolution) - matrix.shape) > 0.5).any():
        sides = " × ".join(f"{side:g}" for side in length)
        raise source.fault(f"holds a GridMap of {sides} m with {matrix.shape} cells of {resolution:g} m")
    check_cells(source, matrix.shape)
    start = np.array([message.outer_start_index, message.inner_start_index])
    cells = np.roll(matrix, -start, axis=(0, 1))[::-1, ::-1]  # now the first cell is at the smallest x and y
    yaw = _yaw(source, info.pose.orientation)
    c, s = np.cos(yaw), np.sin(yaw)
    centre = np.array([info.pose.position.x, info.pose.position.y])
    corner = -0.5 * resolution * (np.array(cells.shape) - 1.0)
    return RawMap(cells.astype(float), resolution, centre + np.array([[c, -s], [s, c]]) @ corner, yaw)


def _matrix(data: Any) -> NDArray[np.float32] | None:
    """The layer as (rows along x, columns along y); None if its layout is none.

    Column after column is how grid_map itself writes it: the outer dimension is then `column_index`.
    """
    if len(data.layout.dim) != 2:
        return None
    (outer, inner), values = data.layout.dim, np.asarray(data.data, dtype=np.float32)
    if outer.size * inner.size != values.size - data.layout.data_offset or not values.size:
        return None
    block = values[data.layout.data_offset :].reshape(outer.size, inner.size)
    return block if outer.label == "row_index" else block.T


def _yaw(source: Source, q: Any) -> float:
    """Of the map's pose; a quaternion of zeros is one that nobody set."""
    quaternion = np.array([q.x, q.y, q.z, q.w])
    if not quaternion.any():
        return 0.0
    if not np.isfinite(quaternion).all() or np.hypot(q.x, q.y) > 1e-3 * np.linalg.norm(quaternion):
        raise source.fault("must hold a GridMap that is level")
    return float(2.0 * np.arctan2(q.z, q.w))
