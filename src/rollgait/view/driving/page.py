"""The page with which a person drives a robot."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np

from rollgait.errors import RollgaitError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.settings import CommandLimits
from rollgait.robot.library import find_robot
from rollgait.view.camera import Camera, aim, fit
from rollgait.view.clip import FRAME_RATE
from rollgait.view.driving.endpoint import Endpoint
from rollgait.view.driving.hands import Hands
from rollgait.view.driving.messages import Request, Snapshot
from rollgait.view.driving.panel import Panel
from rollgait.view.driving.process import LoopProcess, Setup
from rollgait.view.driving.scene import LiveScene
from rollgait.view.lights import add_lights, cast_shadows
from rollgait.view.server import LOOPBACK, PORT, start_server, stop_server

BEHIND: Final = (-3.4, -2.6, 2.7)
"""Place of the camera at first, from the point under the robot, in heights of its CoM."""
STATUS_EVERY: Final = 0.2
"""Between two values of the status, s: nobody reads faster."""


class DrivePage:
    """A page at `url` with a robot that is driven, until `close`.

    >>> page = DrivePage(Setup("centauro", "mujoco", "drive"))  # doctest: +SKIP

    Args:
        setup: what is driven.
        port: of the page; 0 takes a free one.

    Attributes:
        hands: who want what.
        snapshot: how it goes.
        error: why it has ended by itself; None while it runs.

    Raises:
        RollgaitError: the loop cannot be built, or the port cannot be had.
    """

    def __init__(self, setup: Setup, port: int = PORT) -> None:
        self.hands = Hands()
        self.error: RollgaitError | None = None
        self._written = ""
        self._ends = threading.Event()
        self._server = start_server(LOOPBACK, port, "rollgait drive")
        self._folder = TemporaryDirectory(prefix="rollgait-drive-")
        self._endpoint: Endpoint | None = None
        self._loop: LoopProcess | None = None
        self._thread: threading.Thread | None = None
        try:
            self.url = self._server.url
            self._loop = LoopProcess(setup)
            self._endpoint = Endpoint(self.hands, LOOPBACK, int(self._server.get_port()))
            self._build(setup, self._loop, self._endpoint)
            self._thread = threading.Thread(target=self._run, args=(self._loop,), name="drive", daemon=True)
            self._thread.start()
        except BaseException:
            self.close()
            raise

    def _build(self, setup: Setup, loop: LoopProcess, endpoint: Endpoint) -> None:
        self.snapshot = loop.exchange(Request(VelocityCommand(gait=setup.gait)))
        robot = find_robot(setup.robot)
        limits = CommandLimits()
        self.panel = Panel(self._server.gui, self.hands, endpoint.pad(), limits, setup.gait, robot.weight)
        self.panel.add_manoeuvres([one.name for one in setup.manoeuvres])
        add_lights(self._server.scene)
        cast_shadows(self._server.scene, False)
        self.scene = LiveScene(self._server.scene, robot, self.snapshot, setup.terrain)
        self.panel.add_switches(self.scene.layers, self.scene.switch)
        for handle in self.scene.grips:
            self.panel.add_grip(handle)
        self._aim(robot.height)

    def _aim(self, height: float) -> None:
        """From behind the robot, to its right: forward is away from who drives."""
        camera = Camera(height * np.array(BEHIND), np.array([0.0, 0.0, 0.8 * height]))
        aim(self._server, camera)
        fit(self._server, lambda: camera)

    def _run(self, loop: LoopProcess) -> None:
        """Asks and shows, frame by frame. The loop goes on at its own pace meanwhile."""
        told = 0.0
        while not self._ends.is_set():
            begin = time.monotonic()
            try:
                self.snapshot = snapshot = loop.exchange(self._request())
            except RollgaitError as error:
                if not self._ends.is_set():
                    self.error = error
                    self.panel.show_error(str(error))
                    self._ends.set()
                return
            if snapshot.written != self._written:
                self._written = snapshot.written
                self._send_recording(Path(snapshot.written))
            with self._server.atomic():
                self._show(snapshot)
                if begin - told >= STATUS_EVERY:
                    told = begin
                    self.panel.show(snapshot)
            self._ends.wait(max(0.0, begin + 1.0 / FRAME_RATE - time.monotonic()))

    def _request(self) -> Request:
        pushes, reset = self.panel.take(float(self.snapshot.state.euler[0]))
        number = self.panel.recording
        record = str(Path(self._folder.name) / f"{number}.npz") if number else ""
        manoeuvre, distance, halt = self.panel.take_manoeuvre()
        return Request(
            self.panel.command(),
            self.panel.pull,
            pushes,
            reset,
            self.panel.paused,
            record,
            manoeuvre,
            distance,
            halt,
            self.hands.stops,
        )

    def _send_recording(self, file: Path) -> None:
        """Sends a recording to the browser that asked for it, or to another one if that is gone."""
        name, browser = self.panel.end_recording()
        clients = self._server.get_clients()
        client = clients.get(browser, next(iter(clients.values()), None))
        if client is not None:
            client.send_file_download(name, file.read_bytes(), save_immediately=True)

    def _show(self, snapshot: Snapshot) -> None:
        self.scene.follows = bool(self.panel.follow.value)
        self.scene.show(snapshot)

    def wait(self, seconds: float | None = None) -> None:
        """Waits for some time, or until the drive has ended by itself, which it should not.

        Raises:
            RollgaitError: why it has ended.
        """
        self._ends.wait(seconds)
        if self.error is not None:
            raise self.error

    def close(self) -> None:
        """Ends the drive and the page."""
        self._ends.set()
        if self._thread is not None:
            self._thread.join()
        if self._loop is not None:
            self._loop.close()
        if self._endpoint is not None:
            self._endpoint.close()
        stop_server(self._server)
        self._folder.cleanup()
