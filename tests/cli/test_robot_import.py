"""From a bare URDF to a robot on its feet in MuJoCo, in two commands; what is corrected in between counts."""

from pathlib import Path

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
@pytest.mark.parametrize("name", ["fixed-planar", "point-small"])
def test_two_commands(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["robot", "import", bare(name)]) == 0
    assert f"next:    rollgait run {name}-first.yaml" in capsys.readouterr().out
    assert run(["run", f"{name}-first.yaml"]) == 0
    assert rg.Plan.load(f"{name}-first-run/plan.npz").certificate().passed


def test_corrected_legs_are_read(capsys: pytest.CaptureFixture[str]) -> None:
    name = "fixed-plain"
    assert run(["robot", "import", bare(name)]) == 0
    legs = Path(f"{name}-legs.yaml")
    legs.write_text(legs.read_text().replace("radius: 0.1", "radius: 0.12"))
    assert run(["robot", "import", f"{name}.urdf"]) == 0
    assert rg.find_robot(f"{name}-robot.yaml").legs.FL.wheel_radius == 0.12
    assert "radius: 0.12" in legs.read_text()


def test_a_wrong_urdf_leaves_nothing_behind(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(bare("fixed-plain"))
    file.write_text(file.read_text().replace('type="continuous"', 'type="prismatic"'))
    assert run(["robot", "import", str(file)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert list(folder.iterdir()) == [folder / file]
