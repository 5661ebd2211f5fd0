"""Robots that no one can have built: one sentence that names the link, exit status 2, nothing written."""

import os
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from rollgait.cli.app import run
from rollgait.errors import InputError
from rollgait.robot.urdf_files import read_urdf
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import load_whole_body

FIXTURES = Path(__file__).parent.parent / "fixtures"
ROLLER = (FIXTURES / "roller.urdf").read_text()
LONG = 5_000

Change = Callable[[ET.Element], object]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for suffix in (".urdf", ".srdf", ".yaml"):
        shutil.copy(FIXTURES / f"roller{suffix}", tmp_path)
    return tmp_path


@pytest.fixture
def refused(folder: Path, capfd: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Imports the robot of the folder and returns the one sentence; capfd sees what libraries print, too."""

    def sentence() -> str:
        before = sorted(folder.iterdir())
        status = run(["robot", "import", str(folder / "roller.urdf"), "--out", str(folder / "robot.yaml")])
        out, err = capfd.readouterr()
        assert status == 2
        assert out == ""
        assert err.count("\n") == 1
        assert len(err) < 1000
        assert sorted(folder.iterdir()) == before
        return err

    return sentence


def spoil(folder: Path, change: Change) -> None:
    root = ET.fromstring(ROLLER)
    change(root)
    (folder / "roller.urdf").write_text(ET.tostring(root, encoding="unicode"))


def element(root: ET.Element, name: str, path: str = ".") -> ET.Element:
    found = next(part for part in root if part.get("name") == name).find(path)
    assert found is not None
    return found


def setting(name: str, path: str, key: str, value: str) -> Change:
    return lambda root: element(root, name, path).set(key, value)


def without(name: str, path: str, tag: str) -> Change:
    return lambda root: element(root, name, path).remove(element(root, name, f"{path}/{tag}"))


def add(text: str) -> Change:
    return lambda root: root.append(ET.fromstring(text))


NO_NUMBERS = ("nan", "inf", "-inf", "abc", "", "0x10", "1_0", "1 2", "١", "1e999")
NO_BODY = ("1e300", "-1", "0")


@pytest.mark.parametrize("value", [*NO_NUMBERS, *NO_BODY, "1e-999"])
@pytest.mark.parametrize("link", ["FL_shank", "trunk"])
def test_masses(folder: Path, refused: Callable[[], str], link: str, value: str) -> None:
    spoil(folder, setting(link, "inertial/mass", "value", value))
    assert f"'{link}'" in refused()


@pytest.mark.parametrize("key", ["ixx", "izz", "ixy"])
@pytest.mark.parametrize("value", [*NO_NUMBERS, "1e300", "-1", "7"])
def test_inertias(folder: Path, refused: Callable[[], str], key: str, value: str) -> None:
    spoil(folder, setting("HR_thigh", "inertial/inertia", key, value))
    assert "'HR_thigh'" in refused()


def test_inertias_of_zero(folder: Path, refused: Callable[[], str]) -> None:
    spoil(folder, setting("HR_thigh", "inertial/inertia", "ixx", "0"))
    assert "'HR_thigh'" in refused()


@pytest.mark.parametrize("value", [*NO_NUMBERS, *NO_BODY])
def test_radii(folder: Path, refused: Callable[[], str], value: str) -> None:
    spoil(folder, setting("FR_wheel", "collision/geometry/cylinder", "radius", value))
    assert "'FR_wheel'" in refused()


def test_radii_in_the_file_of_the_legs(folder: Path, refused: Callable[[], str]) -> None:
    file = folder / "roller.yaml"
    text = file.read_text()
    for value in ("0", "-1", ".nan", "1e300"):
        file.write_text(text.replace("FL_roll}", f"FL_roll, radius: {value}}}"))
        assert "legs.FL" in refused()


OTHER_NUMBERS = {
    "offset of the mass": ("FL_hip", "inertial/origin", "xyz", "0 nan 0"),
    "offset of a joint": ("FL_haa", "origin", "xyz", "1e300 0 0"),
    "offset of two numbers": ("FL_haa", "origin", "xyz", "1 0"),
    "box": ("trunk", "collision/geometry/box", "size", "0.7 0 0.2"),
    "length": ("FL_wheel", "collision/geometry/cylinder", "length", "inf"),
    "sphere": ("FL_hip", "collision/geometry/sphere", "radius", "0"),
    "turn of a shape": ("FL_wheel", "collision/origin", "rpy", "nan 0 0"),
    "axis": ("FL_hfe", "axis", "xyz", "0 0 0"),
    "axis of text": ("FL_hfe", "axis", "xyz", "a b c"),
    "limit": ("FL_hfe", "limit", "lower", "nan"),
    "limits crossed": ("FL_hfe", "limit", "lower", "3"),
    "effort": ("FL_hfe", "limit", "effort", "-5"),
    "speed": ("FL_roll", "limit", "velocity", "fast"),
    "kind of joint": ("FL_hfe", ".", "type", "revolut"),
    "missing link": ("FL_hfe", "child", "link", "FL_thi"),
}


@pytest.mark.parametrize("case", OTHER_NUMBERS)
def test_other_numbers(folder: Path, refused: Callable[[], str], case: str) -> None:
    name, *change = OTHER_NUMBERS[case]
    spoil(folder, setting(name, *change))
    assert f"'{name}'" in refused()


@pytest.mark.parametrize(
    ("name", "path", "tag"),
    [
        ("FL_hip", "inertial", "mass"),
        ("FL_hip", "inertial", "inertia"),
        ("FL_hip", ".", "inertial"),
        ("FL_hip", "collision", "geometry"),
        ("FL_hfe", ".", "limit"),
        ("FL_hfe", ".", "child"),
    ],
)
def test_what_is_missing(folder: Path, refused: Callable[[], str], name: str, path: str, tag: str) -> None:
    spoil(folder, without(name, path, tag))
    assert f"'{name}'" in refused()


HANG = '<joint name="more" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
TREES: dict[str, tuple[Change, str]] = {
    "cycle at the root": (add(HANG.format("FL_wheel", "world")), "world"),
    "cycle of one": (add(HANG.format("trunk", "trunk")), "trunk"),
    "cycle in a leg": (setting("FL_haa", "parent", "link", "FL_wheel"), "FL_hip"),
    "cycle apart": (
        lambda root: [
            add(text)(root)
            for text in (
                '<link name="a"/>',
                '<link name="b"/>',
                HANG.format("a", "b"),
                HANG.format("b", "a").replace("more", "still more"),
            )
        ],
        "a",
    ),
    "link on two joints": (add(HANG.format("FR_shank", "FL_wheel")), "FL_wheel"),
    "joint to the wheel of another leg": (setting("FR_roll", "child", "link", "FL_wheel"), "FL_wheel"),
    "link on no joint": (add('<link name="lost"/>'), "lost"),
    "link twice": (add('<link name="FL_hip"/>'), "FL_hip"),
    "joint twice": (add(HANG.format("a", "b").replace("more", "FL_haa")), "FL_haa"),
}


@pytest.mark.parametrize("case", TREES)
def test_trees(folder: Path, refused: Callable[[], str], case: str) -> None:
    change, name = TREES[case]
    spoil(folder, change)
    assert f"'{name}'" in refused()


def test_a_chain_longer_than_the_stack(folder: Path, refused: Callable[[], str]) -> None:
    def lengthen(root: ET.Element) -> None:
        for k in range(30_000):
            root.append(ET.fromstring(f'<link name="l{k}"/>'))
            above = f"l{k - 1}" if k else "trunk"
            root.append(ET.fromstring(HANG.format(above, f"l{k}").replace("more", f"j{k}")))

    spoil(folder, lengthen)
    assert "links" in refused()


def test_a_wheel_for_two_legs(folder: Path, refused: Callable[[], str]) -> None:
    file = folder / "roller.yaml"
    text = file.read_text()
    file.write_text(text.replace("FR_wheel", "FL_wheel").replace("FR_roll", "FL_roll"))
    said = refused()
    assert "legs.FR: 'FL_wheel'" in said
    assert "FL_haa" in said


@pytest.mark.parametrize("value", [v for v in NO_NUMBERS if len(v.split()) == 1])
def test_angles_of_the_srdf(folder: Path, refused: Callable[[], str], value: str) -> None:
    file = folder / "roller.srdf"
    file.write_text(file.read_text().replace('value="1.4"', f'value="{value}"', 1))
    assert "'FL_kfe'" in refused()


BOMB = "".join(f'<!ENTITY b{k + 1} "{f"&b{k};" * 10}">' for k in range(9))
FILES = {
    "entities that multiply": f'<!DOCTYPE robot [<!ENTITY b0 "b">{BOMB}]><robot>&b9;</robot>',
    "entity of another file": '<!DOCTYPE robot [<!ENTITY b SYSTEM "file:///etc/passwd">]><robot>&b;</robot>',
    "nesting": "<robot>" * 100_000,
    "unknown encoding": '<?xml version="1.0" encoding="klingon"?><robot/>',
    "encoding of several bytes": '<?xml version="1.0" encoding="utf-7"?><robot/>',
    "encoding of no text": '<?xml version="1.0" encoding="hex"?><robot/>',
    "long encoding": f'<?xml version="1.0" encoding="{"a" * LONG}"?><robot/>',
    "null character": '<robot name="\0"/>',
    "nothing": "",
    "another tag": "<sdf/>",
    "a version to come": ROLLER.replace('<robot name="roller">', '<robot name="roller" version="9.0">'),
    "unknown shape": ROLLER.replace('<sphere radius="0.05"/>', "<torus/>", 1),
}


@pytest.mark.parametrize("case", FILES)
@pytest.mark.parametrize("suffix", [".urdf", ".srdf"])
def test_files(folder: Path, refused: Callable[[], str], case: str, suffix: str) -> None:
    (folder / f"roller{suffix}").write_text(FILES[case])
    assert f"roller{suffix}" in refused()


def test_files_of_millions_of_parts(folder: Path, refused: Callable[[], str]) -> None:
    for text in (
        "<a/>" * 10**6,
        "<robot><link {}/></robot>".format(" ".join(f"a{k}=''" for k in range(10**6))),
    ):
        (folder / "roller.urdf").write_text(f"<robot>{text}</robot>")
        refused()


def test_files_that_have_no_end(folder: Path, refused: Callable[[], str]) -> None:
    file = folder / "roller.urdf"
    with file.open("r+b") as stream:
        stream.truncate(10**12)  # takes no room on the disk
    assert "bytes" in refused()
    file.unlink()
    os.mkfifo(file)
    refused()
    file.unlink()
    file.symlink_to("/dev/zero")
    refused()


MESHES = {
    "long": "m" * LONG,
    "long package": "package://" + "m" * LONG + "/m.stl",
    "long path": "/m" * LONG,
    "device": "/dev/zero",
    "folder": "/etc",
}


@pytest.mark.parametrize("case", MESHES)
def test_names_of_meshes_that_no_file_can_have(
    folder: Path, capfd: pytest.CaptureFixture[str], case: str
) -> None:
    """They are missing like others: nothing but pictures needs meshes."""
    text = ROLLER.replace('<box size="0.7 0.3 0.2"/>', f'<mesh filename="{MESHES[case]}"/>')
    (folder / "roller.urdf").write_text(text)
    assert run(["robot", "import", str(folder / "roller.urdf"), "--out", str(folder / "robot.yaml")]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert "1 without file" in out
    assert max(len(line) for line in out.splitlines()) < 500


def test_a_mesh_that_is_none_for_the_wheel(folder: Path, refused: Callable[[], str]) -> None:
    (folder / "wheel.stl").write_bytes(b"solid nonsense" * 1000)
    wheel = '<geometry><cylinder radius="0.1" length="0.04"/></geometry>'
    text = ROLLER.replace(wheel, '<geometry><mesh filename="wheel.stl"/></geometry>', 1)
    (folder / "roller.urdf").write_text(text)
    assert "legs.FL.radius: 'FL_wheel'" in refused()


# -- whatever is written into a URDF --

PLACES = [(k, key) for k, part in enumerate(ET.fromstring(ROLLER).iter()) for key in part.attrib]
NAMES = sorted({value for part in ET.fromstring(ROLLER).iter() for value in part.attrib.values()})
VALUES = st.one_of(
    st.floats().map(str),
    st.floats(-1.0, 1.0).map(str),
    st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=4).map(lambda numbers: " ".join(map(str, numbers))),
    st.sampled_from(NAMES),
    st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs"), exclude_characters="\ufffe\uffff")),
)
CHANGES = st.one_of(
    st.tuples(st.just("set"), st.sampled_from(PLACES), VALUES),
    st.tuples(st.just("remove"), st.integers(0, len(PLACES)), st.none()),
    st.tuples(st.just("repeat"), st.integers(0, len(PLACES)), st.integers(0, len(PLACES))),
)


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("changed")
    for suffix in (".urdf", ".srdf", ".yaml"):
        shutil.copy(FIXTURES / f"roller{suffix}", place)
    return place / "roller.yaml"


@settings(max_examples=1000, suppress_health_check=[HealthCheck.too_slow])
@given(changes=st.lists(CHANGES, min_size=1, max_size=3))
def test_a_urdf_is_read_wholly_or_refused(changed: Path, changes: list[tuple]) -> None:
    """Whatever is in it: all of its mass arrives and all is finite, or there is one sentence."""
    root = ET.fromstring(ROLLER)
    for what, where, value in changes:
        parts = list(root.iter())
        if what == "set":
            parts[min(where[0], len(parts) - 1)].set(where[1], value)
            continue
        place = parts[where % len(parts)]
        if what == "remove":
            for parent in parts:
                if place in list(parent):
                    parent.remove(place)
        else:
            parts[value % len(parts)].append(deepcopy(place))
    urdf = changed.with_suffix(".urdf")
    urdf.write_text(ET.tostring(root, encoding="unicode"))
    try:
        model = WholeBodyModel(load_whole_body(changed))
    except InputError as error:
        said = str(error)
    else:
        said = ""
    assert "\n" not in said
    assert len(said) < 1000
    if said:
        return
    masses = [
        float(mass.get("value", ""))
        for link in read_urdf(urdf).root.findall("link")
        if (mass := link.find("inertial/mass")) is not None
    ]
    assert model.mass == pytest.approx(sum(masses), rel=1e-9)
    state = model.state(model.posture)
    assert all(abs(value) < 1e6 for value in (*state.p_com, *state.p_foot.ravel()))
