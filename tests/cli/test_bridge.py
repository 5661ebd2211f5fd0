"""`rollgait bridge` on the command line: what is refused, and a robot that nobody enables."""

import pytest

from rollgait.cli.app import run
from rollgait.errors import MissingExtraError


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nobody"], "nobody"),
        (["--gait", "moonwalk"], "moonwalk"),
        (["--domain", "500"], "domain"),
        (["--slow", "3"], "hardware does not wait"),
        (["--plan", "nowhere.npz"], "nowhere.npz"),
    ],
)
def test_what_is_wrong_is_one_sentence(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
    assert run(["bridge", *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1


def test_a_missing_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing() -> None:
        raise MissingExtraError("DDS", "ros")

    pytest.importorskip("rosbags", reason="the extra 'ros' is not installed")
    monkeypatch.setattr("rollgait.hardware.transports.dds.need_dds", missing)
    assert run(["bridge"]) == 2
    assert "pip install 'rollgait[ros]'" in capsys.readouterr().err


@pytest.mark.slow
def test_a_robot_that_nobody_enables_stays_off(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
    arguments = ["--simulate", "--slow", "5", "--domain", "95", "--seconds", "0.5", "--no-kernels"]
    assert run(["bridge", *arguments]) == 0
    said = capsys.readouterr().out
    assert "waits for /enable" in said
    assert "off after" in said
