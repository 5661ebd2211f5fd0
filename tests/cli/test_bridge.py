"""`rollgait bridge` on the command line: what is refused, and a robot that nobody enables."""

import socket
from pathlib import Path

import pytest
from tests.domain import DOMAIN

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
        (["--ground", "nowhere.yaml"], "nowhere.yaml"),
        (["--speed", "-1"], "speed"),
        (["--torque", "nan"], "torque"),
        (["--foxglove-port", "5"], "goes with --foxglove"),
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
    monkeypatch.setattr("rollgait.hardware.transports.reach.need_dds", missing)
    assert run(["bridge"]) == 2
    assert "pip install 'rollgait[ros]'" in capsys.readouterr().err


def test_a_port_in_use_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
    pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert run(["bridge", "--domain", str(DOMAIN), "--foxglove", "--foxglove-port", port]) == 2
    shown = capsys.readouterr()
    assert f"foxglove-port: {port} cannot be listened on" in shown.err
    assert len(shown.err.strip().splitlines()) == 1
    assert shown.out == ""


def test_a_robot_cannot_be_put_where_nobody_can_stand(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
    (tmp_path / "edge.yaml").write_text("parts: [{kind: step, x: 0.35, height: 0.4}]\n")
    assert run(["bridge", "--simulate", "--ground", str(tmp_path / "edge.yaml")]) == 2
    shown = capsys.readouterr()
    assert "ground" in shown.err
    assert len(shown.err.strip().splitlines()) == 1


@pytest.mark.slow
def test_nobody_to_talk_to_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
    assert run(["bridge", "--domain", str(DOMAIN), "--seconds", "4", "--no-kernels"]) == 0
    assert (
        "nothing comes on /joint_states; nothing comes on /imu; nothing comes on /odom"
        in capsys.readouterr().out
    )


@pytest.mark.slow
def test_a_robot_that_nobody_enables_stays_off(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
    arguments = ["--simulate", "--slow", "5", "--domain", str(DOMAIN), "--seconds", "0.5", "--no-kernels"]
    assert run(["bridge", *arguments]) == 0
    said = capsys.readouterr().out
    assert "waits for /enable" in said
    assert "off after" in said
