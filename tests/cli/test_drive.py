"""`rollgait drive`: wrong input is one sentence; it ends by itself when told so."""

import socket

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from rollgait.cli.app import run

CASES = {
    ("centaur",): "valid: centauro",
    ("--gait", "trott"): "valid: trot",
    ("--plant", "mujco"): "valid: mujoco, rigid",
    ("--port", "no"): "port",
    ("--port", "70000"): "65535",
    ("--seconds", "-1"): "seconds",
    ("--ground", "kerbb"): "valid: ",
    ("--ground", "none.yaml"): "none.yaml",
}


@pytest.mark.parametrize("arguments", CASES, ids=" ".join)
def test_wrong_input_is_one_sentence(arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["drive", *arguments]) == 2
    shown = capsys.readouterr()
    assert CASES[arguments] in shown.err
    assert shown.err.count("\n") == 1
    assert shown.out == ""


def test_a_port_in_use_is_refused_as_the_viewer_refuses_it(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert run(["drive", "--plant", "rigid", "--port", port]) == 2
    assert "is in use by another program" in capsys.readouterr().err


def test_it_ends_by_itself(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["drive", "--plant", "rigid", "--port", "0", "--seconds", "0.5"]) == 0
    first, last = capsys.readouterr().out.splitlines()
    assert first.startswith("open http://127.0.0.1:")
    assert "real time" in last
