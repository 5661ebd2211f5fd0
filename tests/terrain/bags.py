"""Bags with GridMaps, written by rosbags from what grid_map documents, cell by cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rollgait.terrain.readers.grid_map import GRID_MAP, typestore
from tests.terrain.worlds import Array


def write_bag(
    path: Path,
    layers: dict[str, Array],
    resolution: float,
    centre: tuple[float, float] = (0.0, 0.0),
    start: tuple[int, int] = (0, 0),
    quaternion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0),
    topic: str = "/elevation_map",
    plugin: str = "MCAP",
    **changes: Any,
) -> Path:
    """A rosbag2 of one message; [i, j] of a layer (nx, ny) is the cell at the i-th x and j-th y."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = typestore()
    T = store.types
    shape = next(iter(layers.values())).shape
    stamp = T["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    pose = T["geometry_msgs/msg/Pose"](
        position=T["geometry_msgs/msg/Point"](x=centre[0], y=centre[1], z=0.0),
        orientation=T["geometry_msgs/msg/Quaternion"](*quaternion),
    )
    info = {
        "resolution": resolution,
        "length_x": shape[0] * resolution,
        "length_y": shape[1] * resolution,
        "pose": pose,
    } | changes
    message = T[GRID_MAP](
        header=T["std_msgs/msg/Header"](stamp=stamp, frame_id="map"),
        info=T["grid_map_msgs/msg/GridMapInfo"](**info),
        layers=list(layers),
        basic_layers=[],
        data=[_multi_array(T, values, start) for values in layers.values()],
        outer_start_index=start[0],
        inner_start_index=start[1],
    )
    with Writer(path, version=9, storage_plugin=getattr(StoragePlugin, plugin)) as writer:
        connection = writer.add_connection(topic, GRID_MAP, typestore=store)
        writer.write(connection, 1, store.serialize_cdr(message, GRID_MAP))
    return path


def _multi_array(T: Any, values: Array, start: tuple[int, int]) -> Any:
    rows, columns = values.shape
    buffer = np.zeros((rows, columns), dtype=np.float32)
    for i in range(rows):
        for j in range(columns):  # the first cell, where the ring starts, is at +x, +y
            row, column = (start[0] + rows - 1 - i) % rows, (start[1] + columns - 1 - j) % columns
            buffer[row, column] = values[i, j]
    dimension = T["std_msgs/msg/MultiArrayDimension"]
    layout = T["std_msgs/msg/MultiArrayLayout"](
        dim=[
            dimension(label="column_index", size=columns, stride=rows * columns),
            dimension(label="row_index", size=rows, stride=rows),
        ],
        data_offset=0,
    )
    return T["std_msgs/msg/Float32MultiArray"](layout=layout, data=buffer.ravel(order="F"))
