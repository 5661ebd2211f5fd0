"""The loop in its own process: it goes on alone, stops when nobody asks; its end is an error, not a hang."""

import os
import signal
import time
from collections.abc import Iterator

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from rollgait.errors import UnknownNameError
from rollgait.mpc.command import VelocityCommand
from rollgait.view.driving.messages import Request
from rollgait.view.driving.process import LoopEndedError, LoopProcess, Setup

PATIENCE = 300.0
"""s: only a test that fails waits for so long."""
STILL = Request(VelocityCommand(gait="drive"))
FORWARD = Request(VelocityCommand(forward=0.3, gait="drive"))


@pytest.fixture(scope="module")
def loop() -> Iterator[LoopProcess]:
    running = LoopProcess(Setup("centauro", "rigid", "drive"))
    yield running
    running.close()


def test_time_goes_on_between_requests(loop: LoopProcess) -> None:
    before = loop.exchange(STILL)
    end = time.monotonic() + PATIENCE
    while loop.exchange(STILL).state.time < before.state.time + 0.1:
        assert time.monotonic() < end
        time.sleep(0.3)


def test_a_page_that_asks_for_nothing_any_more_stops_the_robot(loop: LoopProcess) -> None:
    end = time.monotonic() + PATIENCE
    while (moving := loop.exchange(FORWARD)).actual[0] < 0.2:
        assert time.monotonic() < end
        time.sleep(0.03)
    while True:
        time.sleep(2.0)  # a page that is stuck
        stopped = loop.exchange(STILL)
        if stopped.state.time > moving.state.time + 1.5:
            break
        assert time.monotonic() < end
    assert abs(stopped.wanted[0]) < 0.1


def test_ctrl_c_is_for_the_page(loop: LoopProcess) -> None:
    for _ in range(20):  # whatever the loop does just then
        os.kill(loop.pid, signal.SIGINT)
        time.sleep(0.02)
        assert loop.exchange(STILL).mode in ("tracking", "coasting")  # a busy machine is late


def test_what_is_wrong_with_the_setup_is_said_as_everywhere() -> None:
    with pytest.raises(UnknownNameError, match="valid: centauro"):
        LoopProcess(Setup("centaur", "rigid", "drive"))


def test_a_loop_that_is_gone_is_an_error() -> None:
    loop = LoopProcess(Setup("centauro", "rigid", "drive"))
    os.kill(loop.pid, signal.SIGTERM)
    with pytest.raises(LoopEndedError, match="has ended"):
        _ask_for_ever(loop)
    loop.close()


def _ask_for_ever(loop: LoopProcess) -> None:
    while True:
        loop.exchange(STILL)
        time.sleep(0.05)
