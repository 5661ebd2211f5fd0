"""The keys of `ground:`, every format read back, and bad grounds of all kinds: one sentence each."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from rollgait.config import dump_yaml, parse_yaml, validate
from rollgait.errors import InputError
from rollgait.terrain import Ground, Terrain
from rollgait.terrain import map_file as map_file_module
from tests.terrain.bags import write_bag
from tests.terrain.worlds import Array

NX, NY = 7, 5
HEIGHTS: Array = (0.01 * np.arange(NX * NY, dtype=float)).reshape(NX, NY)
PROFILE = {"driver": "GTiff", "width": NX, "height": NY, "count": 1, "dtype": "float32"}


def ground(**keys: Any) -> Ground:
    return validate(Ground, keys, "ground")


def check_nodes(terrain: Terrain, resolution: float, x0: float, y0: float, atol: float = 1e-12) -> None:
    """Value [i, j] at x0 + i · resolution, y0 + j · resolution."""
    for i in range(NX):
        for j in range(NY):
            z = terrain.height(x0 + i * resolution, y0 + j * resolution)
            np.testing.assert_allclose(z, HEIGHTS[i, j], atol=atol)


# -- keys --


def test_the_old_keys_go_on_to_mean_a_plane() -> None:
    old = ground(kind="flat", height=0.3, friction=0.7)
    assert old == ground(height=0.3, friction=0.7)
    terrain = old.terrain()
    assert terrain == Terrain(level=0.3, friction=0.7)
    assert terrain.height(5.0, -3.0) == 0.3
    assert ground().terrain() == Terrain()


def test_the_kind_follows_from_the_keys() -> None:
    step = {"kind": "step", "x": 1.0, "height": 0.1}
    assert ground().kind == "flat"
    assert ground(parts=[step], kind="parts").kind == "parts"
    assert ground(map={"file": "a.npy"}, parts=[step]).kind == "map"
    assert "kind" not in ground(parts=[step]).model_dump()


def test_ground_goes_through_yaml_and_back() -> None:
    text = """
ground:
  friction: 0.6
  parts:
    - {kind: ramp, x: 1.0, length: 2.0, slope_deg: 10.0, width: 1.5}
    - {kind: stairs, x: 4.0, y: 0.5, yaw_deg: 90.0, steps: 3, rise: 0.12, tread: 0.4, friction: 0.8}
    - {kind: block, x: -1.0, length: 0.3, width: 0.3, height: -0.1}
"""
    first = ground(**parse_yaml(text, "here")["ground"])
    again = ground(**parse_yaml(dump_yaml({"ground": first.model_dump(mode="json")}), "there")["ground"])
    assert again == first
    assert again.terrain() == first.terrain()
    assert [part.kind for part in first.parts] == ["ramp", "stairs", "block"]


# -- formats --


def test_npy(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", HEIGHTS)
    keys = {"file": "map.npy", "resolution": 0.1, "origin": [1.0, -2.0]}
    check_nodes(ground(map=keys).terrain(tmp_path), 0.1, 1.0, -2.0)
    np.save(tmp_path / "mm.npy", np.round(1000 * HEIGHTS).astype(np.int32) - 500)
    keys = {"file": "mm.npy", "resolution": 0.1, "scale": 0.001, "offset": 0.5}
    check_nodes(ground(map=keys).terrain(tmp_path), 0.1, 0.0, 0.0)


def test_a_map_is_raised_with_the_ground(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", HEIGHTS)
    block = {"kind": "block", "x": 0.3, "y": 0.2, "length": 0.1, "width": 0.1, "height": 0.5}
    terrain = ground(height=1.0, map={"file": "map.npy", "resolution": 0.1}, parts=[block]).terrain(tmp_path)
    np.testing.assert_allclose(terrain.height([0.0, 0.3], [0.4, 0.2]), [1.0 + HEIGHTS[0, 4], 1.5])


def test_png_rows_run_down_from_the_largest_y(tmp_path: Path) -> None:
    levels = np.round(HEIGHTS * 1000).astype(np.uint16)
    picture = np.zeros((NY, NX), dtype=np.uint16)
    for i in range(NX):
        for j in range(NY):
            picture[NY - 1 - j, i] = levels[i, j] + 300
    Image.fromarray(picture).save(tmp_path / "map.png")
    keys = {"file": "map.png", "resolution": 0.05, "origin": [2.0, 1.0], "scale": 0.001, "offset": -0.3}
    check_nodes(ground(map=keys).terrain(tmp_path), 0.05, 2.0, 1.0)


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.0])
@pytest.mark.parametrize("mirrored", [False, True], ids=["rows-down", "rows-up"])
def test_geotiff_is_where_its_transform_says(tmp_path: Path, yaw: float, mirrored: bool) -> None:
    rasterio = pytest.importorskip("rasterio", reason="the extra 'geotiff' is not installed")
    from rasterio.transform import Affine

    down = 1.0 if mirrored else -1.0
    place = (
        Affine.translation(450.0, -120.0) @ Affine.rotation(np.degrees(yaw)) @ Affine.scale(0.5, down * 0.5)
    )
    rows = np.zeros((NY, NX), dtype=np.float32)
    for i in range(NX):
        for j in range(NY):
            rows[j if mirrored else NY - 1 - j, i] = HEIGHTS[i, j]
    rows[0, 0] = -9999.0
    profile = {
        "driver": "GTiff",
        "width": NX,
        "height": NY,
        "count": 1,
        "dtype": "float32",
        "nodata": -9999.0,
    }
    with rasterio.open(tmp_path / "map.tif", "w", transform=place, crs="EPSG:32633", **profile) as data:
        data.write(rows, 1)
    terrain = ground(map={"file": "map.tif"}).terrain(tmp_path)
    for row in range(NY):
        for column in range(NX):
            a, b = column + 0.5, row + 0.5  # the middle of the pixel
            x, y = place.a * a + place.b * b + place.c, place.d * a + place.e * b + place.f
            z = terrain.height(x, y)
            wanted = np.nan if (row, column) == (0, 0) else rows[row, column]
            np.testing.assert_allclose(z, wanted, atol=1e-6)


@pytest.mark.parametrize("plugin", ["MCAP", "SQLITE3"])
@pytest.mark.parametrize("start", [(0, 0), (2, 0), (3, 4)])
def test_grid_map_out_of_a_bag(tmp_path: Path, start: tuple[int, int], plugin: str) -> None:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    unknown = HEIGHTS.copy()
    unknown[6, 0] = np.nan
    layers = {"variance": 0.0 * HEIGHTS, "elevation": unknown}
    write_bag(tmp_path / "bag", layers, 0.04, (1.0, 2.0), start, plugin=plugin)
    terrain = ground(map={"file": "bag"}).terrain(tmp_path)
    x0, y0 = 1.0 - 0.02 * (NX - 1), 2.0 - 0.02 * (NY - 1)
    for i in range(NX):
        for j in range(NY):
            z = terrain.height(x0 + 0.04 * i, y0 + 0.04 * j)
            np.testing.assert_allclose(z, unknown[i, j], atol=1e-7)
    flat = ground(map={"file": "bag", "layer": "variance", "topic": "/elevation_map"}).terrain(tmp_path)
    assert flat.height(1.0, 2.0) == 0.0
    (storage,) = (tmp_path / "bag").glob("*.mcap" if plugin == "MCAP" else "*.db3")
    alone = ground(map={"file": f"bag/{storage.name}"}).terrain(tmp_path)
    assert alone == terrain


def test_a_grid_map_may_be_turned(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    quaternion = (0.0, 0.0, np.sin(0.25), np.cos(0.25))
    write_bag(tmp_path / "bag", {"elevation": HEIGHTS}, 0.1, (1.0, 2.0), quaternion=quaternion)
    terrain = ground(map={"file": "bag"}).terrain(tmp_path)
    c, s = np.cos(0.5), np.sin(0.5)
    for i in range(NX):
        for j in range(NY):
            local = 0.1 * (np.array([i, j]) - 0.5 * np.array([NX - 1, NY - 1]))
            x, y = np.array([1.0, 2.0]) + np.array([[c, -s], [s, c]]) @ local
            np.testing.assert_allclose(terrain.height(x, y), HEIGHTS[i, j], atol=1e-6)


def test_holes_are_filled_where_that_is_asked_for(tmp_path: Path) -> None:
    values = np.zeros((9, 9))
    values[4, 4] = np.nan
    np.save(tmp_path / "map.npy", values)
    keys = {"file": "map.npy", "resolution": 0.04}
    assert not ground(map=keys).terrain(tmp_path).known(0.16, 0.16)
    assert ground(map={**keys, "fill": 0.04}).terrain(tmp_path).height(0.16, 0.16) == 0.0


# -- bad grounds --

BAD_KEYS: list[tuple[dict[str, Any], str, str]] = [
    # keys of `ground`, the field that is named, what is said of it
    ({"kind": "hills"}, "ground.kind", "valid: flat"),
    ({"kind": "flat", "parts": [{"kind": "gap", "x": 1.0, "length": 0.3}]}, "ground", "mean 'parts'"),
    ({"friction": 0.0}, "ground.friction", "greater than 0"),
    ({"friction": 50.0}, "ground.friction", "less than or equal to 10"),
    ({"hight": 0.1}, "ground.hight", "valid: height"),
    ({"parts": {"kind": "gap"}}, "ground.parts", "must be a list"),
    ({"parts": [{"kind": "stair", "x": 1.0}]}, "ground.parts.0.kind", "valid: stairs"),
    ({"parts": [{"x": 1.0}]}, "ground.parts.0", "kind"),
    ({"parts": [{"kind": "gap", "x": 1.0}]}, "ground.parts.0.length", "must be given"),
    (
        {"parts": [{"kind": "step", "x": 1.0, "height": 0.1, "witdh": 1.0}]},
        "ground.parts.0.witdh",
        "valid: width",
    ),
    ({"parts": [{"kind": "step", "x": 1.0, "height": 0.0}]}, "ground.parts.0.height", "must not be 0"),
    ({"parts": [{"kind": "step", "x": 1.0, "height": 250.0}]}, "ground.parts.0.height", "at most 100 m"),
    ({"parts": [{"kind": "gap", "x": 5000.0, "length": 0.3}]}, "ground.parts.0.x", "within 1000 m"),
    ({"parts": [{"kind": "gap", "x": 1.0, "length": -0.3}]}, "ground.parts.0.length", "greater than 0"),
    (
        {"parts": [{"kind": "ramp", "x": 1.0, "length": 1.0}]},
        "ground.parts.0",
        "either its rise or its slope",
    ),
    ({"parts": [{"kind": "ramp", "x": 1.0, "length": 1.0, "rise": 3.0}]}, "ground.parts.0", "60 degrees"),
    (
        {"parts": [{"kind": "stairs", "x": 1.0, "steps": 2.5, "rise": 0.1, "tread": 0.3}]},
        "ground.parts.0.steps",
        "whole number",
    ),
    (
        {"parts": [{"kind": "stairs", "x": 1.0, "steps": 100, "rise": 0.1, "tread": 0.3}] * 5},
        "ground.parts",
        "at most 400 planar pieces",
    ),
    ({"map": "hill.npy"}, "ground.map", "mapping"),
    ({"map": {"resolution": 0.1}}, "ground.map.file", "must be given"),
    ({"map": {"file": "hill.npy", "resolution": 0.0}}, "ground.map.resolution", "greater than 0"),
    ({"map": {"file": "hill.npy", "scale": 0.0}}, "ground.map.scale", "must not be 0"),
    ({"map": {"file": "hill.npy", "origin": [0.0]}}, "ground.map.origin", "2 values"),
]


@pytest.mark.parametrize(("keys", "field", "rule"), BAD_KEYS)
def test_keys_that_are_no_ground(keys: dict[str, Any], field: str, rule: str) -> None:
    with pytest.raises(InputError) as caught:
        ground(**keys).terrain()
    assert caught.value.field == field
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)


def _npy(values: Any) -> Callable[[Path], None]:
    return lambda folder: np.save(folder / "map.npy", values)


def _bytes(name: str, content: bytes) -> Callable[[Path], None]:
    return lambda folder: (folder / name).write_bytes(content) and None


def _png(values: Any) -> Callable[[Path], None]:
    return lambda folder: Image.fromarray(values).save(folder / "map.png")


def _huge_png(folder: Path) -> None:
    """A header that promises 60000 × 60000 pixels, and nothing behind it."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 60000, 60000, 16, 0, 0, 0, 0)
    (folder / "map.png").write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(b""))
        + chunk(b"IEND", b"")
    )


def _huge_npy(folder: Path) -> None:
    """A header that promises 80 GB."""
    with (folder / "map.npy").open("wb") as stream:
        header = {"descr": "<f8", "fortran_order": False, "shape": (100000, 100000)}
        np.lib.format.write_array_header_1_0(stream, header)


def _half_npy(folder: Path) -> None:
    np.save(folder / "map.npy", HEIGHTS)
    os.truncate(folder / "map.npy", (folder / "map.npy").stat().st_size - 9)


def _link_out(folder: Path) -> None:
    outside = folder.parent / "outside.npy"
    np.save(outside, HEIGHTS)
    (folder / "map.npy").symlink_to(outside)


def _nothing(folder: Path) -> None:
    pass


BAD_FILES: dict[str, tuple[Callable[[Path], None], dict[str, Any], str]] = {
    # what lies in the folder, keys of `map`, what is said
    "absent": (_nothing, {"file": "map.npy"}, "No such file"),
    "absolute": (_nothing, {"file": "/etc/passwd"}, "not an absolute path"),
    "windows": (_nothing, {"file": "C:\\map.npy"}, "not an absolute path"),
    "dots": (_nothing, {"file": "maps/../../map.npy"}, "by '..'"),
    "backslash-dots": (_nothing, {"file": "maps\\..\\map.npy"}, "by '..'"),
    "link": (_link_out, {"file": "map.npy"}, "by a link"),
    "loop": (lambda f: (f / "map.npy").symlink_to("map.npy"), {"file": "map.npy"}, "cannot be read"),
    "pipe": (lambda f: os.mkfifo(f / "map.npy"), {"file": "map.npy"}, "must be a plain file"),
    "empty-name": (_nothing, {"file": ""}, "must be the name of a file"),
    "format": (_bytes("map.xyz", b"0 0 0"), {"file": "map.xyz"}, "valid: .npy"),
    "no-suffix": (_bytes("map", b"0 0 0"), {"file": "map"}, "valid: .npy"),
    "folder": (lambda f: (f / "maps").mkdir(), {"file": "maps"}, "is not a ROS 2 bag"),
    "no-npy": (_bytes("map.npy", b"hills"), {"file": "map.npy"}, "is not an array that NumPy saved"),
    "half-npy": (
        lambda f: (
            np.save(f / "a.npy", HEIGHTS),
            (f / "map.npy").write_bytes((f / "a.npy").read_bytes()[:-9]),
        ),
        {"file": "map.npy"},
        "ends before its last height",
    ),
    "objects": (_npy(np.array([[{}]], dtype=object)), {"file": "map.npy"}, "must hold numbers, not object"),
    "text": (_npy(np.array([["a", "b"]])), {"file": "map.npy"}, "must hold numbers"),
    "three-axes": (_npy(np.zeros((3, 3, 3))), {"file": "map.npy"}, "grid of heights"),
    "huge-npy": (_huge_npy, {"file": "map.npy"}, "at most 4000000 cells, not 100000 × 100000"),
    "all-nan": (_npy(np.full((5, 5), np.nan)), {"file": "map.npy"}, "all its heights are NaN"),
    "infinite": (_npy(np.full((5, 5), np.inf)), {"file": "map.npy"}, "finite heights"),
    "millimetres": (_npy(1000.0 * HEIGHTS), {"file": "map.npy"}, "0.001 for mm"),
    "one-row": (_npy(np.zeros((1, 5))), {"file": "map.npy"}, "at least 2 × 2"),
    "no-png": (_bytes("map.png", b"hills"), {"file": "map.png", "scale": 0.001}, "is not a PNG"),
    "colour-png": (
        _png(np.zeros((5, 5, 3), dtype=np.uint8)),
        {"file": "map.png", "scale": 0.001},
        "grey levels of 16 bits, not RGB",
    ),
    "8-bit-png": (_png(np.zeros((5, 5), dtype=np.uint8)), {"file": "map.png", "scale": 0.001}, "not L"),
    "png-scale": (_png(np.zeros((5, 5), dtype=np.uint16)), {"file": "map.png"}, "map.scale: must be given"),
    "huge-png": (_huge_png, {"file": "map.png", "scale": 0.001}, "too many pixels"),
    "no-mcap": (_bytes("map.mcap", b"hills"), {"file": "map.mcap"}, "is not a ROS 2 bag"),
}


def tree(folder: Path) -> set[tuple[str, bool]]:
    return {(str(path), path.is_dir()) for path in folder.rglob("*")}


@pytest.mark.parametrize(("make", "keys", "rule"), BAD_FILES.values(), ids=list(BAD_FILES))
def test_files_that_are_no_map(
    tmp_path: Path, make: Callable[[Path], None], keys: dict[str, Any], rule: str
) -> None:
    folder = tmp_path / "scenario"
    folder.mkdir()
    make(folder)
    before = tree(tmp_path)
    with pytest.raises(InputError) as caught:
        ground(map={"resolution": 0.02, **keys}).terrain(folder)
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.field.startswith("ground.map")
    assert tree(tmp_path) == before


def test_a_file_over_the_limit_is_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.save(tmp_path / "map.npy", HEIGHTS)
    monkeypatch.setattr(map_file_module, "MAX_BYTES", 100)
    with pytest.raises(InputError, match="must be at most 0 MB"):
        ground(map={"file": "map.npy", "resolution": 0.1}).terrain(tmp_path)


def test_the_file_or_the_scenario_says_the_resolution(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    np.save(tmp_path / "map.npy", HEIGHTS)
    with pytest.raises(InputError, match=r"ground\.map\.resolution: must be given for map\.npy"):
        ground(map={"file": "map.npy"}).terrain(tmp_path)
    write_bag(tmp_path / "bag", {"elevation": HEIGHTS}, 0.04)
    with pytest.raises(InputError, match=r"must be left out: bag says itself that it is 0\.04 m"):
        ground(map={"file": "bag", "resolution": 0.1}).terrain(tmp_path)


def test_a_map_needs_a_folder() -> None:
    with pytest.raises(InputError, match="needs a scenario in a file"):
        ground(map={"file": "map.npy", "resolution": 0.1}).terrain()


BAD_BAGS: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "layer": (
        {},
        {"layer": "height"},
        "map.layer: 'height' is not a layer of this GridMap; valid: elevation",
    ),
    "topic": ({}, {"topic": "/map"}, "map.topic: '/map' has no GridMap in this bag; valid: /elevation_map"),
    "length": ({"length_x": 9.0}, {}, "holds a GridMap of 9 × 0.2 m"),
    "resolution": ({"resolution": float("nan")}, {}, "contradicts itself"),
    "tilted": ({"quaternion": (0.5, 0.0, 0.0, 0.8)}, {}, "that is level"),
}


@pytest.mark.parametrize(("changes", "keys", "rule"), BAD_BAGS.values(), ids=list(BAD_BAGS))
def test_bags_that_hold_no_such_map(
    tmp_path: Path, changes: dict[str, Any], keys: dict[str, Any], rule: str
) -> None:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    resolution = changes.pop("resolution", 0.04) if "resolution" in changes else 0.04
    write_bag(tmp_path / "bag", {"elevation": HEIGHTS}, resolution, **changes)
    with pytest.raises(InputError) as caught:
        ground(map={"file": "bag", **keys}).terrain(tmp_path)
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("fault", ["degrees", "oblong", "no-transform", "no-tiff"])
def test_geotiffs_that_are_no_map(tmp_path: Path, fault: str) -> None:
    rasterio = pytest.importorskip("rasterio", reason="the extra 'geotiff' is not installed")
    from rasterio.transform import Affine

    rules = {
        "degrees": "projection in metres",
        "oblong": "square pixels, not 0.5 m × 0.7 m",
        "no-transform": "must have a transform",
        "no-tiff": "is not a GeoTIFF",
    }
    where: dict[str, Any] = {
        "degrees": {"transform": Affine(0.5, 0, 0, 0, -0.5, 0), "crs": "EPSG:4326"},
        "oblong": {"transform": Affine(0.5, 0, 0, 0, -0.7, 0), "crs": "EPSG:32633"},
    }.get(fault, {})
    path = tmp_path / "map.tif"
    if fault == "no-tiff":
        path.write_bytes(b"II*\0hills")
    else:
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # rasterio warns of what is meant here
            with rasterio.open(path, "w", **PROFILE, **where) as data:
                data.write(HEIGHTS.T.astype(np.float32), 1)
    with pytest.raises(InputError) as caught:
        ground(map={"file": "map.tif"}).terrain(tmp_path)
    assert rules[fault] in str(caught.value)
    assert "\n" not in str(caught.value)
