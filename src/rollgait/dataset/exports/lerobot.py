"""A LeRobot data set, v3.0: each motion is an episode of states and actions at a fixed rate.

meta/info.json, meta/stats.json       features, counts, their statistics
meta/tasks.parquet                    one task for each family
meta/episodes/chunk-000/file-000.…    where each episode begins and ends, its statistics
data/chunk-000/file-000.parquet       the frames of all episodes, one after the other
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dataset.columns import arrow
from rollgait.dataset.exports.motions import Frames, Motions, Written
from rollgait.files import MB
from rollgait.robot.robot import LEG_NAMES

Array = NDArray[np.float64]

VERSION: Final = "v3.0"
FILE_SIZE: Final = 100
"""Size after which frames go into another file, MB; the format's own default."""
CHUNK: Final = 1000
"""Files in a folder at most; the format's own default."""
PATHS: Final = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
STATE: Final = "observation.state"
CONTACT: Final = "observation.contact"
GOAL: Final = "observation.environment_state"
ACTION: Final = "action"
COUNTERS: Final = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
"""What every frame has, beside its features."""
STATISTICS: Final = ("min", "max", "mean", "std")


def write_lerobot(motions: Motions, folder: Path) -> Written:
    """Writes the data set; returns what was written. The folder appears when it is whole."""
    fps = motions.require_whole_rate("lerobot")
    temporary = folder.with_name(f".{folder.name}.partial")
    shutil.rmtree(temporary, ignore_errors=True)
    written = Written()
    tasks = {name: _task(motions, name) for name in motions.dataset.spec.families}
    with _Writer(temporary, fps, list(tasks.values())) as writer:
        for frames in motions.each(written):
            names, values = features_of(frames)
            if not writer.takes(names):
                written.motions -= 1
                written.frames -= frames.count
                written.left_out.append((frames.row, "has other joints than the first row"))
                continue
            task = list(tasks).index(motions.dataset.sampler.asked(frames.row).family)
            writer.add(values, task, frames.plan.robot.name)
    if folder.exists():
        folder.rmdir()
    temporary.replace(folder)
    return written


def _task(motions: Motions, family: str) -> str:
    """What is done, in words."""
    described = str(motions.dataset.sampler.bases[family].get("description", ""))
    return f"{family}: {described}" if described else family


def features_of(frames: Frames) -> tuple[dict[str, list[str]], dict[str, Array]]:
    """Names of the components of each feature, and their values, (n, …)."""
    names, values = _whole_body(frames) if frames.joints is not None else _centroidal(frames)
    last = frames.plan.scenario.goal_at(frames.samples.time)
    names[GOAL], values[GOAL] = ["goal_x", "goal_y", "goal_yaw"], last[:, [0, 1, 3]]
    names[CONTACT] = [f"{leg}_contact" for leg in LEG_NAMES]
    values[CONTACT] = frames.samples.contact.astype(float)
    return names, values


def _centroidal(frames: Frames) -> tuple[dict[str, list[str]], dict[str, Array]]:
    """Of a plan: body and feet as the state, what moves the feet and pushes the body as the action."""
    s = frames.samples
    n = frames.count
    axes = ("x", "y", "z")
    state = [
        *(f"com_{a}" for a in axes),
        *("yaw", "pitch", "roll"),
        *(f"com_velocity_{a}" for a in axes),
        *("yaw_rate", "pitch_rate", "roll_rate"),
        *(f"{leg}_{a}" for leg in LEG_NAMES for a in axes),
        *(f"{leg}_heading" for leg in LEG_NAMES),
    ]
    action = [
        *(f"{leg}_velocity_{a}" for leg in LEG_NAMES for a in axes),
        *(f"{leg}_heading_rate" for leg in LEG_NAMES),
        *(f"{leg}_force_{a}" for leg in LEG_NAMES for a in axes),
    ]
    feet = s.foot_position.reshape(n, -1)
    values = {
        STATE: np.hstack([s.com_position, s.euler, s.com_velocity, s.euler_rate, feet, s.heading]),
        ACTION: np.hstack([s.foot_velocity.reshape(n, -1), s.heading_rate, s.force.reshape(n, -1)]),
    }
    return {STATE: state, ACTION: action}, values


def _whole_body(frames: Frames) -> tuple[dict[str, list[str]], dict[str, Array]]:
    """Of joints: base and joints as the state, the joints of the next frame as the action."""
    joints, k = frames.joints, frames.index
    assert joints is not None
    names = joints.joint_names
    state = [
        *("base_x", "base_y", "base_z", "base_qw", "base_qx", "base_qy", "base_qz"),
        *(f"base_linear_{a}" for a in "xyz"),
        *(f"base_angular_{a}" for a in "xyz"),
        *(f"{name}.pos" for name in names),
        *(f"{name}.vel" for name in names),
    ]
    quaternion = joints.base_quaternion[k][:, [3, 0, 1, 2]]
    after = np.append(k[1:], k[-1])
    values = {
        STATE: np.hstack(
            [
                joints.base_position[k],
                quaternion,
                joints.base_velocity[k],
                joints.joint_position[k],
                joints.joint_velocity[k],
            ]
        ),
        ACTION: joints.joint_position[after],
    }
    return {STATE: state, ACTION: [f"{name}.pos" for name in names]}, values


@dataclass
class _Sums:
    """Statistics of a feature over many frames, added up."""

    low: Array
    high: Array
    total: Array
    squares: Array
    count: int = 0

    @classmethod
    def of(cls, values: Array) -> _Sums:
        wide = values.astype(float)
        sums = wide.sum(axis=0), (wide**2).sum(axis=0)
        return cls(wide.min(axis=0), wide.max(axis=0), *sums, len(wide))

    def __add__(self, other: _Sums) -> _Sums:
        return _Sums(
            np.minimum(self.low, other.low),
            np.maximum(self.high, other.high),
            self.total + other.total,
            self.squares + other.squares,
            self.count + other.count,
        )

    def to_dict(self) -> dict[str, list[float]]:
        """As the format has them."""
        mean = self.total / self.count
        std = np.sqrt(np.maximum(self.squares / self.count - mean**2, 0.0))
        numbers = zip(STATISTICS, (self.low, self.high, mean, std), strict=True)
        return {**{name: value.tolist() for name, value in numbers}, "count": [self.count]}


@dataclass
class _Writer:
    """Writes episodes one after the other; what stands at the end of the format is written at the end."""

    folder: Path
    fps: int
    tasks: Sequence[str]
    _names: dict[str, list[str]] = field(default_factory=dict)
    _sums: dict[str, _Sums] = field(default_factory=dict)
    _episodes: list[dict[str, Any]] = field(default_factory=list)
    _file: Any = None
    _path: Path = Path()
    _number: int = -1
    _frames: int = 0
    _robots: set[str] = field(default_factory=set)

    def __enter__(self) -> _Writer:
        self.folder.mkdir(parents=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._file is not None:
            self._file.close()
        if kind is None:
            self._finish()
        else:
            shutil.rmtree(self.folder, ignore_errors=True)

    def takes(self, names: dict[str, list[str]]) -> bool:
        """Whether an episode has the features of the first one."""
        self._names = self._names or names
        return names == self._names

    def add(self, values: Mapping[str, Array], task: int, robot: str) -> None:
        """Writes an episode."""
        pa = arrow()
        n, number = len(values[STATE]), len(self._episodes)
        frame = np.arange(n)
        counters = {
            "timestamp": frame / self.fps,
            "frame_index": frame,
            "episode_index": np.full(n, number),
            "index": frame + self._frames,
            "task_index": np.full(n, task),
        }
        schema = self._schema()
        columns = [
            pa.FixedSizeListArray.from_arrays(
                pa.array(values[name].astype(np.float32).ravel()), values[name].shape[1]
            )
            for name in self._names
        ]
        columns += [pa.array(counters[name]).cast(dtype) for name, dtype in COUNTERS.items()]
        self._open(schema).write_table(pa.Table.from_arrays(columns, schema=schema))
        sums = {name: _Sums.of(array) for name, array in values.items()}
        sums |= {name: _Sums.of(array[:, None]) for name, array in counters.items()}
        self._sums = {name: self._sums[name] + one if self._sums else one for name, one in sums.items()}
        statistics = {
            f"stats/{name}/{what}": numbers
            for name, one in sums.items()
            for what, numbers in one.to_dict().items()
        }
        chunk, file = divmod(self._number, CHUNK)
        self._episodes.append(
            {
                "episode_index": number,
                "tasks": [self.tasks[task]],
                "length": n,
                "data/chunk_index": chunk,
                "data/file_index": file,
                "dataset_from_index": self._frames,
                "dataset_to_index": self._frames + n,
                **statistics,
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
            }
        )
        self._frames += n
        self._robots.add(robot)

    def _open(self, schema: Any) -> Any:
        """The file for the next episode: another one if that of the last is large."""
        if self._file is not None and self._path.stat().st_size > FILE_SIZE * MB:
            self._file.close()
            self._file = None
        if self._file is None:
            self._number += 1
            chunk, file = divmod(self._number, CHUNK)
            self._path = self.folder / "data" / PATHS.format(chunk_index=chunk, file_index=file)
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = arrow().parquet.ParquetWriter(self._path, schema, compression="snappy")
        return self._file

    def _schema(self) -> Any:
        pa = arrow()
        own = [(name, pa.list_(pa.float32(), len(parts))) for name, parts in self._names.items()]
        return pa.schema([*own, *COUNTERS.items()])

    def _finish(self) -> None:
        pa = arrow()
        count = len(self._episodes)
        features: dict[str, Any] = {
            name: {"dtype": "float32", "shape": [len(parts)], "names": parts}
            for name, parts in self._names.items()
        }
        features |= {name: {"dtype": dtype, "shape": [1], "names": None} for name, dtype in COUNTERS.items()}
        info = {
            "codebase_version": VERSION,
            "robot_type": ", ".join(sorted(self._robots)),
            "total_episodes": count,
            "total_frames": self._frames,
            "total_tasks": len(self.tasks),
            "chunks_size": CHUNK,
            "data_files_size_in_mb": FILE_SIZE,
            "video_files_size_in_mb": 0,
            "fps": self.fps,
            "splits": {"train": f"0:{count}"},
            "data_path": f"data/{PATHS}",
            "video_path": None,
            "features": features,
        }
        meta = self.folder / "meta"
        episodes = meta / "episodes" / PATHS.format(chunk_index=0, file_index=0)
        episodes.parent.mkdir(parents=True)
        _write_json(meta / "info.json", info)
        _write_json(meta / "stats.json", {name: sums.to_dict() for name, sums in self._sums.items()})
        pa.parquet.write_table(pa.Table.from_pylist(self._episodes), episodes)
        pa.parquet.write_table(_tasks_table(self.tasks), meta / "tasks.parquet")


def _tasks_table(tasks: Sequence[str]) -> Any:
    """Numbers of tasks by their words: a table of pandas with the words as its index."""
    pa = arrow()
    about = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [
            {
                "name": "task_index",
                "field_name": "task_index",
                "pandas_type": "int64",
                "numpy_type": "int64",
                "metadata": None,
            },
            {
                "name": "task",
                "field_name": "task",
                "pandas_type": "unicode",
                "numpy_type": "object",
                "metadata": None,
            },
        ],
    }
    table = pa.table({"task_index": pa.array(range(len(tasks)), pa.int64()), "task": list(tasks)})
    return table.replace_schema_metadata({"pandas": json.dumps(about)})


def _write_json(path: Path, data: Any) -> None:
    path.write_text(json.dumps(data, indent=4), encoding="utf-8")
