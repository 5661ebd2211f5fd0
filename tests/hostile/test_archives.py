"""Hostile .npz files: bombs, members that are not what they should be, motions that are none."""

from __future__ import annotations

import io
import math
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from rollgait.errors import FileError
from rollgait.view.opening import open_clip
from tests.hostile.conftest import Run
from tests.hostile.motions import BUILDERS, Change, changed, parts, plan, write

MB = 1_000_000
BOMB = 700 * MB
"""Bytes unpacked, more than the budget; packed, zeros take a hundredth or less."""


# -- bombs ---------------------------------------------------------------------------------------------------


def zeros(shape: tuple[int, ...], dtype: str = "<f8") -> tuple[bytes, int]:
    """The beginning of an array of zeros, and how many zero bytes follow."""
    stream = io.BytesIO()
    described = {"descr": dtype, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(stream, described)
    return stream.getvalue(), math.prod(shape) * np.dtype(dtype).itemsize


def add(archive: zipfile.ZipFile, name: str, begin: bytes, more: int) -> None:
    """A member that begins so and goes on with so many zeros."""
    block = bytes(MB)
    with archive.open(name, "w", force_zip64=True) as member:
        member.write(begin)
        for done in range(0, more, MB):
            member.write(block[: min(MB, more - done)])


def bomb(kind: str, file: Path) -> None:
    plan().save(file)
    header, arrays = parts(file)
    if kind == "unknown member":
        with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            add(archive, "more.npy", *zeros((BOMB // 8,)))
        return
    if kind == "known member":
        del arrays["trajectory/force"]
        write(file, header, arrays)
        with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            add(archive, "trajectory/force.npy", *zeros((BOMB // 96, 4, 3)))
    elif kind == "all members":
        count = BOMB // 1500
        header["scenario"]["horizon"] = 0.1 * count
        write(file, header, {})
        layout: dict[str, Any] = {"contact": ("|b1", (4, count)), "lengths": ("<f8", (count,))}
        for name, array in plan().trajectory.arrays().items():
            layout[f"trajectory/{name}"] = (array.dtype.str, (count, *array.shape[1:]) if array.ndim else ())
        with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for name, (dtype, shape) in layout.items():
                add(archive, f"{name}.npy", *zeros(shape, dtype))
    elif kind == "header":
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            add(archive, "header.npy", *zeros((), f"<U{BOMB // 4}"))
    elif kind == "description":  # NumPy reads as many bytes as version 2 says, before it looks at them
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            add(archive, "header.npy", b"\x93NUMPY\x02\x00" + struct.pack("<I", BOMB), BOMB)
    elif kind == "another compression":
        with zipfile.ZipFile(file, "w", zipfile.ZIP_LZMA) as archive:
            add(archive, "header.npy", *zeros((), f"<U{BOMB // 40}"))
    elif kind == "huge shape":
        del arrays["trajectory/force"]
        write(file, header, arrays)
        with zipfile.ZipFile(file, "a") as archive:
            archive.writestr("trajectory/force.npy", zeros((10**12, 4, 3))[0])
    elif kind == "many members":
        with zipfile.ZipFile(file, "a") as archive:
            for number in range(60_000):
                archive.writestr(f"{number}" + 200 * "x", b"")
    elif kind == "nested header":
        np.savez_compressed(file, header=np.array("[" * 3_000_000))
    elif kind == "long numbers":
        np.savez_compressed(file, header=np.array('{"format": ' + "9" * 3_000_000 + "}"))


NO_PLAN = "is not a plan that rollgait saved"
BOMBS = {
    "known member": "is damaged: trajectory/force: ",  # its length differs from that of the others
    "all members": "is damaged: arrays: take ",
    "header": NO_PLAN,
    "description": NO_PLAN,
    "another compression": NO_PLAN,
    "huge shape": "is damaged: trajectory/force: ",
    "many members": NO_PLAN,
    "nested header": NO_PLAN,
    "long numbers": NO_PLAN,
}


@pytest.mark.parametrize(("kind", "says"), BOMBS.items(), ids=list(BOMBS))
def test_a_bomb_is_refused(kind: str, says: str, tmp_path: Path, rollgait: Run) -> None:
    bomb(kind, tmp_path / "bomb.npz")
    rollgait("check", "bomb.npz").assert_refused(f"plan: 'bomb.npz' {says}")


def test_what_nobody_needs_is_not_read(tmp_path: Path, rollgait: Run) -> None:
    bomb("unknown member", tmp_path / "bomb.npz")
    answer = rollgait("check", "bomb.npz")
    assert answer.status == 1, answer  # judged: the plan itself is sound, though not certified
    assert not answer.written


# -- members -------------------------------------------------------------------------------------------------


def set_array(name: str, value: Any) -> Change:
    return lambda header, arrays: arrays.update({name: np.asarray(value)})


DAMAGES: dict[str, Change] = {
    "a text for times": set_array("time", ["a", "b"]),
    "no time": lambda header, arrays: arrays.pop("time"),
    "negated times": lambda header, arrays: arrays.update(time=-arrays["time"] - 1.0),
    "times backwards": lambda header, arrays: arrays.update(time=arrays["time"][::-1]),
    "times that stand still": lambda header, arrays: arrays.update(time=0.0 * arrays["time"]),
    "endless times": lambda header, arrays: arrays.update(time=arrays["time"] * 1e300),
    "times of a century": lambda header, arrays: arrays.update(time=arrays["time"] * 3e9),
    "NaN in times": lambda header, arrays: arrays.update(time=arrays["time"] * np.nan),
    "a number for an array": set_array("base_position", 3.0),
    "one row less": lambda header, arrays: arrays.update(base_position=arrays["base_position"][1:]),
    "complex numbers": lambda header, arrays: arrays.update(base_position=arrays["base_position"] * 1j),
    "truth values": lambda header, arrays: arrays.update(base_position=arrays["base_position"] > 0.0),
    "objects": lambda header, arrays: arrays.update(base_position=arrays["base_position"].astype(object)),
    "records": set_array("base_position", np.zeros(3, dtype=[("x", "f8"), ("y", "O")])),
    "no rows": lambda header, arrays: arrays.update({n: a[:0] for n, a in arrays.items() if a.ndim}),
    "one joint more": lambda header, arrays: header["joint_names"].append("more"),
    "joints are a number": lambda header, arrays: header.update(joint_names=3),
    "a joint is a number": lambda header, arrays: header.update(joint_names=[1, 2]),
    "no robot": lambda header, arrays: header.pop("robot"),
    "a robot of another type": lambda header, arrays: header.update(robot=[1]),
}
OF_CONTROLLER: dict[str, Change] = {
    "events are numbers": lambda header, arrays: header.update(events=[1]),
    "events without text": lambda header, arrays: header.update(events=[{"time": 1.0}]),
    "a period of nothing": lambda header, arrays: header.update(period=0.0),
    "a period without end": lambda header, arrays: header.update(period=math.inf),
    "a period of ages": lambda header, arrays: header.update(period=1e159),
    "a period of text": lambda header, arrays: header.update(period="x"),
    "a fall at no time": lambda header, arrays: header.update(fallen_at="never"),
    "an unknown mode": lambda header, arrays: arrays.update(mode=arrays["mode"] + 7),
    "NaN in the state": lambda header, arrays: arrays.update(heading=arrays["heading"] * np.nan),
}
OF_JOINTS: dict[str, Change] = {
    "a report of numbers": lambda header, arrays: header.update(report={"rows": [3]}),
    "a report is a list": lambda header, arrays: header.update(report=[]),
    "quaternions of 0": lambda header, arrays: arrays.update(base_quaternion=0 * arrays["base_quaternion"]),
    "a shorter reference": lambda header, arrays: arrays.update(
        {"reference/force": arrays["reference/force"][1:]}
    ),
    "another time for the reference": lambda header, arrays: arrays.update(
        {"reference/time": arrays["time"] + 1.0}
    ),
    "NaN for joints": lambda header, arrays: arrays.update(joint_position=np.nan * arrays["joint_position"]),
}
OF_SIMULATION: dict[str, Change] = {
    "disturbances are a list": lambda header, arrays: header.update(disturbances=[]),
    "feedback is a text": lambda header, arrays: header.update(feedback="x"),
    "efforts are NaN": lambda header, arrays: arrays.update(effort_max=np.nan * arrays["effort_max"]),
}
CASES = [
    (kind, name, change)
    for kind, changes in (
        ("controller", DAMAGES | OF_CONTROLLER),
        ("simulation", DAMAGES | OF_SIMULATION),
        ("joints", DAMAGES | OF_JOINTS),
    )
    for name, change in changes.items()
]


@pytest.mark.parametrize(
    ("kind", "change"), [(k, c) for k, _, c in CASES], ids=[f"{k}: {n}" for k, n, _ in CASES]
)
def test_a_file_that_is_no_motion_is_refused(kind: str, change: Change, tmp_path: Path) -> None:
    file = changed(kind, tmp_path / "motion.npz", change)
    with pytest.raises(FileError, match=r"motion\.npz' is damaged: ") as caught:
        open_clip(file)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("kind", "arguments"),
    [
        ("joints", ["export", "motion.npz", "--format", "json"]),
        ("joints", ["simulate", "motion.npz", "--record", "log.npz"]),
        ("joints", ["record", "motion.npz"]),
        ("simulation", ["record", "motion.npz"]),
        ("controller", ["record", "motion.npz"]),
        ("controller", ["mpc", "--plant", "replay:motion.npz", "--record", "log.npz"]),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value[:3:2]),
)
def test_commands_refuse_it_in_one_sentence(
    kind: str, arguments: list[str], tmp_path: Path, rollgait: Run
) -> None:
    changed(kind, tmp_path / "motion.npz", DAMAGES["negated times"])
    rollgait(*arguments).assert_refused("'motion.npz' is damaged: time: ")


def test_costs_may_be_as_high_as_numbers_go(tmp_path: Path) -> None:
    def dear(header: dict[str, Any], arrays: dict[str, Any]) -> None:
        arrays["cost"] = np.full(arrays["cost"].shape, 1e308)

    assert open_clip(changed("controller", tmp_path / "dear.npz", dear)).passed


def test_a_rate_without_measure_is_refused(tmp_path: Path, rollgait: Run) -> None:
    BUILDERS["joints"]().save(tmp_path / "motion.npz")
    command = ["export", "motion.npz", "--format", "json", "--rate", "1e12"]
    rollgait(*command).assert_refused("rate: 1000000000000.0 must be at most ")


def test_a_motion_of_a_day_has_no_more_frames_than_one_of_an_hour(tmp_path: Path) -> None:
    def slow(header: dict[str, Any], arrays: dict[str, Any]) -> None:
        arrays["time"] = arrays["time"] * 86400.0

    clip = open_clip(changed("controller", tmp_path / "slow.npz", slow))
    assert clip.horizon == pytest.approx(0.99 * 86400.0)
    assert len(clip.time) == 108_000


STEERING = "\x1b]0;title\x07"


@pytest.mark.parametrize(
    "change",
    [
        lambda header, arrays: header["robot"].update(name=STEERING),
        lambda header, arrays: header["statistics"].update(status=STEERING),
        lambda header, arrays: header["statistics"].update(worst=5000 * "x"),
    ],
    ids=["robot", "status", "a long text"],
)
def test_what_would_be_printed_steers_no_terminal(change: Change, tmp_path: Path) -> None:
    file = changed("plan", tmp_path / "motion.npz", change)
    with pytest.raises(FileError, match="must be one line of at most 1000 printable characters"):
        open_clip(file)


# -- anything ------------------------------------------------------------------------------------------------

DTYPES = st.sampled_from(["<f8", ">f8", "<f4", "<f2", "<i8", "|b1", "<c16", "<U3", "|S2", "|V4", "<M8[s]"])
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[dict[str, Any], dict[str, Any]]]:
    """Header and arrays of a file of each kind."""
    folder = tmp_path_factory.mktemp("sound")
    return {kind: parts(build().save(folder / kind)) for kind, build in BUILDERS.items()}


@settings(max_examples=1000, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_change_of_a_member_is_refused_or_can_be_shown(
    data: st.DataObject, sound: dict[str, tuple[dict[str, Any], dict[str, Any]]], tmp_path: Path
) -> None:
    kind = data.draw(st.sampled_from(["joints", "controller"]))
    header, arrays = dict(sound[kind][0]), dict(sound[kind][1])
    if data.draw(st.booleans()):
        header[data.draw(st.sampled_from(sorted(header)))] = data.draw(JSON)
    else:
        name = data.draw(st.sampled_from(sorted(arrays)))
        shapes = st.just(arrays[name].shape) | npst.array_shapes(min_dims=0, min_side=0, max_side=3)
        dtype, shape = np.dtype(data.draw(DTYPES)), data.draw(shapes)
        fill = data.draw(st.binary(min_size=dtype.itemsize, max_size=dtype.itemsize))
        arrays[name] = np.full(shape, np.frombuffer(fill, dtype)[0], dtype)
    file = write(tmp_path / "changed.npz", header, arrays)
    try:
        clip = open_clip(file)
    except FileError as error:
        assert str(error).isprintable()  # noqa: PT017 (either way is right)
    else:
        assert np.isfinite(clip.samples.com_position).all()


@settings(max_examples=1000, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_change_of_the_bytes_is_refused_or_harmless(
    data: st.DataObject, tmp_path: Path, sound: dict[str, tuple[dict[str, Any], dict[str, Any]]]
) -> None:
    file = tmp_path / "bytes.npz"
    if not file.exists():
        write(tmp_path / "whole.npz", *sound["plan"])
        file.touch()
    content = bytearray((tmp_path / "whole.npz").read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        piece = data.draw(st.binary(max_size=8))
        content[at : at + data.draw(st.integers(0, 8))] = piece
    file.write_bytes(content)
    try:
        open_clip(file)
    except FileError as error:
        assert str(error).isprintable()  # noqa: PT017 (either way is right)
