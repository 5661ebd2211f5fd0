"""A plan file: saving and loading is the identity; whatever is wrong with a file is one sentence."""

from __future__ import annotations

import io
import json
import os
import pickle
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.errors import FileError
from rollgait.plan.plan import FORMAT_VERSION, Plan
from rollgait.plan.trajectory import CollocationTrajectory, Trajectory
from rollgait.scenario import Scenario, find_scenario
from tests.view.builders import motion_plan

SMALL = Scenario.from_dict({"robot": "centauro", "goal": {"x": 0.2}, "horizon": 1.0, "interval": 0.1})


@pytest.fixture(scope="module")
def plan() -> Plan:
    return motion_plan(find_scenario("hybrid-goback"))


@pytest.fixture(scope="module")
def file(plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return plan.save(tmp_path_factory.mktemp("plan") / "motion.npz")


def assert_same(a: Plan, b: Plan) -> None:
    assert (a.robot, a.scenario, a.statistics) == (b.robot, b.scenario, b.statistics)
    assert a.schedule == b.schedule
    assert type(a.trajectory) is type(b.trajectory)
    ours, theirs = a.trajectory.arrays(), b.trajectory.arrays()
    assert list(ours) == list(theirs)
    for name, array in ours.items():
        assert array.dtype == theirs[name].dtype
        np.testing.assert_array_equal(array, theirs[name], name)


@pytest.mark.parametrize("name", ["hybrid-forward", "hybrid-goback", "wheeled", "legged-forward"])
def test_saving_and_loading_is_the_identity(name: str, tmp_path: Path) -> None:
    plan = motion_plan(find_scenario(name), solved=name == "wheeled")
    assert_same(Plan.load(plan.save(tmp_path / "plan.npz")), plan)


@settings(max_examples=20, deadline=None)
@given(which=st.sets(st.integers(0, 9), min_size=1), parts=st.integers(2, 7))
def test_every_mesh_survives(which: set[int], parts: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    plan = motion_plan(SMALL, schedule=SMALL.schedule.refined(list(which), parts))
    path = plan.save(tmp_path_factory.mktemp("plan") / "mesh.npz")
    loaded = Plan.load(path)
    assert_same(loaded, plan)
    assert loaded.schedule.mesh == loaded.trajectory.mesh
    times = np.linspace(0.0, plan.horizon, 41)
    np.testing.assert_array_equal(loaded.sample(times).force, plan.sample(times).force)
    path.unlink()


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(1e-300, 1e300))
def test_every_double_survives(seed: int, size: float, tmp_path_factory: pytest.TempPathFactory) -> None:
    random = np.random.default_rng(seed)
    plan = motion_plan(SMALL)
    arrays = plan.trajectory.arrays()
    wild = {name: random.normal(size=a.shape) * size for name, a in arrays.items() if a.ndim > 2}
    wild["force"][0, 0] = [np.nan, np.inf, -0.0]  # the last iterate of a solver that failed
    plan = replace(plan, trajectory=CollocationTrajectory.from_arrays(arrays | wild))
    path = plan.save(tmp_path_factory.mktemp("plan") / "wild.npz")
    assert_same(Plan.load(path), plan)
    path.unlink()


def test_samples_of_a_loaded_plan_are_the_same(plan: Plan, file: Path) -> None:
    ours, theirs = plan.sample_every(37.0), Plan.load(file).sample_every(37.0)
    for name, values in vars(ours).items():
        np.testing.assert_array_equal(values, getattr(theirs, name), name)


def test_the_suffix_is_added(plan: Plan, tmp_path: Path) -> None:
    assert plan.save(tmp_path / "v1.2") == tmp_path / "v1.2.npz"
    assert plan.save(tmp_path / "new" / "folder" / "plan.npz").is_file()


def test_the_text_of_a_plan_cannot_break_its_file(plan: Plan, tmp_path: Path) -> None:
    odd = plan.scenario.model_copy(update={"description": 'ünïcode \u2028 "quotes" \\ and a\nline'})
    assert Plan.load(replace(plan, scenario=odd).save(tmp_path / "odd.npz")).scenario == odd


def refused(path: Path) -> str:
    """The one sentence with which a file is refused."""
    with pytest.raises(FileError) as caught:
        Plan.load(path)
    message = str(caught.value)
    assert "\n" not in message
    assert path.name in message
    assert caught.value.exit_status == 2
    return message


def rewritten(file: Path, target: Path, change: Callable[[dict[str, Any], dict[str, Any]], object]) -> Path:
    """A copy of a plan file after `change(header, arrays)`."""
    with np.load(file) as data:
        arrays = dict(data)
    header = json.loads(str(arrays.pop("header")))
    change(header, arrays)
    np.savez(target, header=np.array(json.dumps(header)), **arrays)
    return target


def test_missing_file_and_folder(tmp_path: Path) -> None:
    assert "cannot be read: No such file" in refused(tmp_path / "nowhere.npz")
    assert "cannot be read: Is a directory" in refused(tmp_path)


@pytest.mark.parametrize(
    "content",
    [b"", b"not a plan", b"PK\x03\x04", b"PK\x05\x06" + bytes(18), b"\x93NUMPY", b"robot: centauro\n"],
)
def test_foreign_bytes(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "foreign.npz"
    path.write_bytes(content)
    assert "is not a plan that rollgait saved" in refused(path)


def test_foreign_archives(tmp_path: Path) -> None:
    np.save(tmp_path / "array.npy", np.zeros(3))
    refused(tmp_path / "array.npy")
    np.savez(tmp_path / "arrays.npz", a=np.zeros(3))
    refused(tmp_path / "arrays.npz")
    for header in ("[]", "{}", "3", "no json", json.dumps({"format": "other", "version": FORMAT_VERSION})):
        np.savez(tmp_path / "header.npz", header=np.array(header))
        refused(tmp_path / "header.npz")
    with zipfile.ZipFile(tmp_path / "text.npz", "w") as archive:
        archive.writestr("header.npy", "text")
    refused(tmp_path / "text.npz")


class Trap:
    """Unpickling this creates a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.path),)


def test_a_file_runs_no_code(file: Path, tmp_path: Path) -> None:
    trap, sprung = Trap(tmp_path / "sprung"), tmp_path / "sprung"
    (tmp_path / "pickle.npz").write_bytes(pickle.dumps(trap))
    refused(tmp_path / "pickle.npz")
    objects = np.array([trap], dtype=object)
    np.savez(tmp_path / "header.npz", allow_pickle=True, header=objects)
    refused(tmp_path / "header.npz")
    refused(rewritten(file, tmp_path / "array.npz", lambda _, a: a.update({"trajectory/force": objects})))
    assert not sprung.exists()


def test_another_version_says_so(file: Path, tmp_path: Path) -> None:
    path = rewritten(file, tmp_path / "newer.npz", lambda h, _: h.update(version=FORMAT_VERSION + 1))
    known = f"has format version {FORMAT_VERSION + 1}; this rollgait knows version {FORMAT_VERSION}"
    assert known in refused(path)


DAMAGES: dict[str, Callable[[dict[str, Any], dict[str, Any]], object]] = {
    "no robot": lambda h, a: h.pop("robot"),
    "negative mass": lambda h, a: h["robot"].update(mass=-1.0),
    "unknown key": lambda h, a: h["scenario"].update(terrain="stairs"),
    "unknown kind": lambda h, a: h.update(kind="spline"),
    "statistics are no mapping": lambda h, a: h.update(statistics=3),
    "statistics lack a field": lambda h, a: h["statistics"].pop("solver"),
    "no contact": lambda h, a: a.pop("contact"),
    "five legs": lambda h, a: a.update(contact=np.ones((5, 3), dtype=bool)),
    "contact as numbers": lambda h, a: a.update(contact=a["contact"].astype(float)),
    "no force": lambda h, a: a.pop("trajectory/force"),
    "no intervals": lambda h, a: a.update({"trajectory/force": np.zeros((0, 4, 3))}),
    "one interval less": lambda h, a: a.update({"trajectory/base": a["trajectory/base"][1:]}),
    "text for numbers": lambda h, a: a.update({"trajectory/motion": a["trajectory/motion"].astype(str)}),
    "other intervals": lambda h, a: a.update(lengths=2.0 * a["lengths"]),
    "one length for all": lambda h, a: a.update(lengths=a["lengths"][0]),
    "intervals without contacts": lambda h, a: a.update(contact=a["contact"][:, 1:]),
    "no time": lambda h, a: a.update(lengths=0.0 * a["lengths"]),
    "NaN for the time": lambda h, a: a.update(lengths=np.nan * a["lengths"]),
    "NaN for the solution's time": lambda h, a: a["trajectory/lengths"].fill(np.nan),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=list(DAMAGES))
def test_a_damaged_plan_says_what_is_wrong(
    damage: Callable[[dict[str, Any], dict[str, Any]], object], file: Path, tmp_path: Path
) -> None:
    assert "is damaged: " in refused(rewritten(file, tmp_path / "damaged.npz", damage))


def test_what_is_damaged_is_named(file: Path, tmp_path: Path) -> None:
    path = rewritten(file, tmp_path / "damaged.npz", DAMAGES["negative mass"])
    assert "robot.mass: -1.0 must be greater than 0" in refused(path)


def test_a_truncated_file(file: Path, tmp_path: Path) -> None:
    content, path = file.read_bytes(), tmp_path / "truncated.npz"
    for part in np.linspace(0.0, 0.999, 23):
        path.write_bytes(content[: int(part * len(content))])
        refused(path)


@settings(max_examples=60, deadline=None)
@given(place=st.floats(0.0, 1.0, exclude_max=True), byte=st.integers(0, 255))
def test_one_wrong_byte_is_noticed_or_harmless(
    place: float, byte: int, file: Path, plan: Plan, tmp_path_factory: pytest.TempPathFactory
) -> None:
    content = bytearray(file.read_bytes())
    content[int(place * len(content))] = byte
    path = tmp_path_factory.mktemp("plan") / "byte.npz"
    path.write_bytes(content)
    try:
        loaded = Plan.load(path)
    except FileError as error:
        assert "\n" not in str(error)  # noqa: PT017 (either way is right)
    else:
        assert_same(loaded, plan)
    path.unlink()


class Interrupting(CollocationTrajectory):
    """Its arrays cannot all be written: the user presses Ctrl-C meanwhile."""

    kind = "interrupting"

    def arrays(self) -> dict[str, Any]:
        class Interrupted:
            def __array__(self, *_: Any, **__: Any) -> np.ndarray:
                raise KeyboardInterrupt

        return super().arrays() | {"late": Interrupted()}


del Trajectory.registry[Interrupting.kind]  # no file can ask for it


def test_an_interruption_leaves_the_old_file_and_nothing_else(plan: Plan, tmp_path: Path) -> None:
    path = plan.save(tmp_path / "plan.npz")
    before = path.read_bytes()
    broken = replace(plan, trajectory=Interrupting(**plan.trajectory.arrays()))
    with pytest.raises(KeyboardInterrupt):
        broken.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_place_that_cannot_be_written(plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        plan.save(tmp_path / "file" / "plan.npz")


def test_the_same_plan_gives_the_same_arrays_in_a_plain_npz(file: Path) -> None:
    """Anyone with NumPy can read the file."""
    with zipfile.ZipFile(file) as archive:
        names = archive.namelist()
        header = np.load(io.BytesIO(archive.read("header.npy")))
    assert {"header.npy", "contact.npy", "lengths.npy", "trajectory/force.npy"} <= set(names)
    assert json.loads(str(header))["format"] == "rollgait-plan"
