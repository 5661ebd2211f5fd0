"""From a bare URDF to a robot on its feet in MuJoCo, in two commands; what is corrected in between counts."""

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from tests.robot.lookalikes import LOOKALIKES

import rollgait as rg
from rollgait.cli.app import run


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def bare(name: str) -> str:
    Path(f"{name}.urdf").write_text(LOOKALIKES[name].urdf())
    return f"{name}.urdf"


@pytest.mark.slow
@pytest.mark.parametrize("name", LOOKALIKES)
def test_two_commands(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Imported; then certified, tracked within its limits, and on its feet in MuJoCo."""
    assert run(["robot", "import", bare(name)]) == 0
    command = f"rollgait run {name}-first.yaml"
    assert f"next:    {command}" in capsys.readouterr().out
    assert run(command.split()[1:]) == 0
    plan = rg.Plan.load(f"{name}-first-run/plan.npz")
    assert plan.certificate().passed
    assert plan.scenario.goal.x >= 0.15 * np.ptp(plan.robot.stance[:, 0])


@pytest.mark.slow
def test_a_robot_of_which_there_are_no_meshes_is_filmed() -> None:
    name = "point-small"
    assert run(["robot", "import", bare(name)]) == 0
    assert run(["plan", f"{name}-first.yaml", "--out", "plan.npz"]) == 0
    assert run(["track", "plan.npz", "--out", "joints.npz"]) == 0
    for file in ("plan.npz", "joints.npz"):
        assert run(["record", file, "--out", f"{file}.gif"]) == 0
        assert Path(f"{file}.gif").stat().st_size > 10_000


def proposed(said: str) -> list[str]:
    """The command for the controller that an import proposes."""
    (line,) = [line for line in said.splitlines() if line.startswith("or:")]
    words = line.split()[1:]
    assert words[:2] == ["rollgait", "mpc"]
    return words[1:]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fixed-planar", "point-small", "steerable-plain"])
def test_the_controller_follows_the_command_that_an_import_proposes(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mujoco", reason="needs the extra whole-body")
    assert run(["robot", "import", bare(name)]) == 0
    command = proposed(capsys.readouterr().out)
    assert ("turn_rate" in command[-1]) == (name != "fixed-planar")
    assert run([*command, "--duration", "3", "--set", "deadline=10"]) == 0
    said = capsys.readouterr().out
    assert "is cut to" not in said
    assert ("cannot go sideways or turn" in said) == (name == "fixed-planar")


@pytest.mark.slow
def test_the_controller_leads_a_small_robot() -> None:
    """4.5 kg: forces that press a foot of a large robot would lift it."""
    name = "point-small"
    assert run(["robot", "import", bare(name)]) == 0
    command = ["mpc", f"{name}-robot.yaml", "--command", "forward=0.05", "--duration", "3"]
    assert run([*command, "--set", "deadline=10"]) == 0


def test_corrected_legs_are_read(capsys: pytest.CaptureFixture[str]) -> None:
    name = "fixed-plain"
    assert run(["robot", "import", bare(name)]) == 0
    legs = Path(f"{name}-legs.yaml")
    legs.write_text(legs.read_text().replace("radius: 0.1", "radius: 0.12"))
    assert run(["robot", "import", f"{name}.urdf"]) == 0
    assert rg.find_robot(f"{name}-robot.yaml").legs.FL.wheel_radius == 0.12
    assert "radius: 0.12" in legs.read_text()


def test_a_radius_that_no_one_but_its_owner_knows(capsys: pytest.CaptureFixture[str]) -> None:
    """A wheel whose mesh is missing: the legs are named, and only the radius is to be added."""
    name = "fixed-plain"
    urdf = Path(bare(name))
    mesh = '<mesh filename="package://none/wheel.stl"/>'
    urdf.write_text(re.sub(r'<cylinder radius="0.1"[^>]*>', mesh, urdf.read_text()))
    assert run(["robot", "import", str(urdf)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"{name}-legs.yaml names the legs" in said
    legs = Path(f"{name}-legs.yaml")
    legs.write_text(re.sub(r"(wheel_joint: \w+)", r"\1, radius: 0.11", legs.read_text()))
    assert run(["robot", "import", str(urdf)]) == 0
    robot = rg.find_robot(f"{name}-robot.yaml")
    assert robot.legs.HR.wheel_radius == 0.11
    assert robot.legs.HR.stance[1] == pytest.approx(-LOOKALIKES[name].half_track, abs=0.01)


def test_a_wrong_urdf_leaves_nothing_behind(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(bare("fixed-plain"))
    file.write_text(file.read_text().replace('type="continuous"', 'type="prismatic"'))
    assert run(["robot", "import", str(file)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert list(folder.iterdir()) == [folder / file]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["folder"], "urdf: 'folder' cannot be read: it is a folder"),
        (["MODEL", "--out", "mine.txt"], "out: 'mine.txt' must end in .yaml or .yml"),
        (["MODEL", "--legs", "other.yaml"], "goal: 'goal' is not a known key, in other.yaml; valid: "),
    ],
)
def test_slips_are_told_before_any_work(
    arguments: list[str], message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = bare(next(iter(LOOKALIKES)))
    Path("folder").mkdir()
    Path("other.yaml").write_text("goal: {x: 1}\n", encoding="utf-8")
    before = sorted(folder.iterdir())
    assert run(["robot", "import", *(model if word == "MODEL" else word for word in arguments)]) == 2
    assert message in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before
