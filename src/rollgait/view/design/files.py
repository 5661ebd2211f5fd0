"""A draft as a file and back: YAML, with a map beside it in a zip, and as Python."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path
from pprint import pformat
from typing import Any, Final

import numpy as np

from rollgait.config import dump_yaml, parse_yaml
from rollgait.errors import FileError, InputError, RollgaitError
from rollgait.scenario.library_maps import heights_of_the_library
from rollgait.scenario.scenario import Scenario, without_none

PYTHON: Final = """\
import rollgait as rg

scenario = rg.Scenario.from_dict(
{data}{folder}
)
plan = rg.plan(scenario)
print(plan.certificate())
plan.save({name!r})
"""
WIDTH: Final = 96
"""Of lines of Python."""
NAME: Final = "scenario"
"""Of files of a draft without one."""
MAPS_MAX: Final = 16
"""Maps that a page keeps: designs before this one may stand on them."""
MAP_MAX: Final = 256 * 2**20
"""Of the map in a zip, bytes: the largest that is read from a folder."""


def scenario_file(scenario: Scenario, name: str, maps: Path) -> tuple[str, bytes]:
    """The file that a scenario is saved as, its name and content.

    Args:
        scenario: to be saved.
        name: that a person calls it.
        maps: folder in which the file of its map lies, if it has one of its own.
    """
    stem = file_name(name)
    beside = _map_beside(scenario, stem, maps)
    if beside is None:
        return f"{stem}.yaml", scenario.to_yaml(brief=True).encode()
    keys, content = beside
    data = scenario.to_brief_dict()
    data["ground"] = {**data["ground"], "map": keys}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"{stem}.yaml", dump_yaml(without_none(data)))
        archive.writestr(str(keys["file"]), content)
    return f"{stem}.zip", stream.getvalue()


def _map_beside(scenario: Scenario, stem: str, maps: Path) -> tuple[dict[str, Any], bytes] | None:
    """The keys and the content of the map that a saved scenario needs beside it; None if it needs none."""
    keys, heights = scenario.ground.map, scenario.ground.heights
    if keys is None or heights is None:
        return None
    if keys.digest is not None and heights_of_the_library(keys.digest) is not None:
        return None
    if keys.file is not None and keys.lies_in(maps):
        return keys.model_dump(mode="json", exclude_defaults=True), (maps / keys.file).read_bytes()
    if heights.yaw != 0.0:
        return None  # a .npy cannot say that it is turned; the digest in the file says what is missing
    stream = io.BytesIO()
    np.save(stream, heights.values)
    place = {"resolution": heights.resolution, "origin": heights.origin.tolist()}
    return {"file": f"{stem}.npy", **place}, stream.getvalue()


def scenario_from_page(content: bytes, name: str, maps: Path | None = None) -> Scenario:
    """The scenario in a file that a page sent: it names no other file, but a map that came with it.

    Args:
        content: of the file.
        name: of the file.
        maps: folder into which a map that came with it is put; None if none is taken.

    Raises:
        InputError: it breaks a rule, or names a file of this machine.
        FileError: it cannot be read.
    """
    if name.endswith(".zip"):
        return _unpacked(content, name, maps)
    return Scenario.from_dict(_data(content, name))


def file_name(name: str) -> str:
    """A name as that of a file, without what means something to a shell."""
    return re.sub(r"[^\w.-]+", "-", Path(name).stem, flags=re.ASCII).strip("-.") or NAME


def as_python(scenario: Scenario, name: str) -> str:
    """A program that plans a scenario."""
    data = pformat(scenario.to_brief_dict(), width=WIDTH, sort_dicts=False, indent=1)
    indented = "".join(f"    {line}\n" for line in f"{data},".splitlines())
    folder = ""
    if scenario.ground.map is not None and scenario.ground.map.file is not None:
        folder = "\n    folder=Path(),  # with its map"
    text = PYTHON.format(data=indented.rstrip("\n"), folder=folder, name=f"{file_name(name)}.npz")
    return f"from pathlib import Path\n\n{text}" if folder else text


def _data(content: bytes, name: str) -> dict[str, Any]:
    """What a scenario says; refused where it names a file of this machine as its robot."""
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError("file", name, "is not text") from None
    data = parse_yaml(text, name)
    robot = data.get("robot")
    if isinstance(robot, str) and Path(robot).suffix:
        raise InputError("robot", robot, "names a file; a scenario sent by a page names a robot or holds it")
    return data


def _unpacked(content: bytes, name: str, maps: Path | None) -> Scenario:
    """The scenario in a zip with one YAML file and at most one map."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries: dict[str, Any] = {entry.filename: entry for entry in archive.infolist()}
            texts = [each for each in entries if each.endswith((".yaml", ".yml"))]
            if len(texts) != 1 or len(entries) > 2 or any(Path(each).name != each for each in entries):
                raise FileError("file", name, "must hold one scenario (.yaml) and at most its map")
            text, others = archive.read(texts[0]), set(entries) - set(texts)
            beside = {each: archive.read(each) for each in others if entries[each].file_size <= MAP_MAX}
    except RollgaitError:
        raise
    except Exception:  # damaged bytes lead anywhere
        raise FileError("file", name, "is not a zip that can be read") from None
    data = _data(text, name)
    ground = data.get("ground")
    keys = ground.get("map") if isinstance(ground, dict) else None
    if maps is not None and isinstance(keys, dict) and keys.get("file") in beside:
        keys["file"] = kept_map(maps, keys["file"], beside[keys["file"]])
    return Scenario.from_dict(data, maps)


def kept_map(maps: Path, name: str, content: bytes) -> str:
    """Keeps a map that a page sent; the name of its file, which no other map has.

    Raises:
        FileError: there are too many, or it cannot be written.
    """
    stem, suffix = file_name(name), Path(name).suffix.lower()
    for number in range(1, MAPS_MAX + 1):
        file = maps / (f"{stem}{suffix}" if number == 1 else f"{stem}-{number}{suffix}")
        if file.exists() and file.read_bytes() == content:
            return file.name
        if not file.exists() and sum(1 for _ in maps.iterdir()) < MAPS_MAX:
            try:
                file.write_bytes(content)
            except OSError as error:
                raise FileError("map", name, f"cannot be kept: {error.strerror}") from None
            return file.name
    raise FileError("map", name, f"is one too many: a page keeps {MAPS_MAX}; begin anew")
