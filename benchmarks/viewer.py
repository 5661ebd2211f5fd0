"""The viewer: what a frame costs the server, frames per second in a headless browser, memory while scrubbing.

Prints a table. The server is measured with the whole body and a client that draws nothing.
Scrubs as often as an hour of steady scrubbing would (one move every second), only faster.
Usage: python benchmarks/viewer.py [PLAN] [--server-only]
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

import rollgait
from rollgait.view.clip import FRAME_RATE, clip_of_plan
from rollgait.view.viewer import Viewer

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"]
FLAGS += ["--disable-background-networking", "--disable-component-update", "--enable-precise-memory-info"]
MOVES = 3600
"""Of the slider: one a second for an hour."""
PLAYED = 20.0
"""s"""
MEGABYTE = 1e6
TWICE: Final = 60.0
"""As often as the server sends at most, per second."""
BACKLOG: Final = 5.0
"""After so long a client has all that is in the scene, s."""
HEADER: Final = 16
"""Bytes before the packed messages: their sizes, unpacked and packed, 8 each."""

WATCH_SCENE = """() => {
    window.drawn = 0;
    const clear = WebGL2RenderingContext.prototype.clear;  // once in every picture of the scene
    let fresh = false;
    WebGL2RenderingContext.prototype.clear = function (...all) {
        fresh = true;
        return clear.apply(this, all);
    };
    const step = () => {
        if (fresh) { window.drawn += 1; fresh = false; }
        requestAnimationFrame(step);
    };
    step();
}"""
COUNT_PICTURES = """seconds => new Promise(done => {
    const before = window.drawn, begin = performance.now();
    setTimeout(() => done(1000 * (window.drawn - before) / (performance.now() - begin)), 1000 * seconds);
})"""
COUNT_UPDATES = """seconds => new Promise(done => {
    const box = document.querySelector('input[inputmode=decimal]');
    let changes = 0, last = box.value; const begin = performance.now();
    const step = now => {
        if (box.value !== last) { changes += 1; last = box.value; }
        now - begin < 1000 * seconds ? setTimeout(() => step(performance.now()), 2)
                                     : done(1000 * changes / (now - begin));
    };
    step(performance.now());
})"""


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(description="What the viewer costs.")
    parser.add_argument("plan", nargs="?", help="file of a plan; hybrid-forward if not given")
    parser.add_argument("--server-only", action="store_true", help="without a browser")
    options = parser.parse_args()
    plan = rollgait.Plan.load(options.plan) if options.plan else rollgait.plan("hybrid-forward")
    print(f"load at the beginning           {os.getloadavg()[0]:8.1f}")
    _serve(plan)
    if not options.server_only:
        _browse(plan)


def _serve(plan: rollgait.Plan) -> None:
    """What a frame of the whole body costs the server, with one client that draws nothing."""
    viewer = Viewer(clip_of_plan(plan, "benchmark").with_joints(rollgait.track(plan)), port=0)
    spawn = multiprocessing.get_context("spawn")
    for name, rate in (("playing", None), ("60 asked", TWICE)):
        ours, theirs = spawn.Pipe()
        client = spawn.Process(
            target=_listen, args=(theirs, viewer.url, viewer.time.slider._impl.uuid), daemon=True
        )
        client.start()
        ours.recv()  # it is connected, and has what is in the scene
        made, spent, begin = 0, time.process_time(), time.perf_counter()
        if rate is not None:
            while (now := time.perf_counter() - begin) < PLAYED:
                viewer.timeline.go(now % viewer.clip.horizon)
                made += 1
                time.sleep(max(0.0, made / rate - (time.perf_counter() - begin)))
        else:
            viewer.timeline.play()
            time.sleep(PLAYED)
            viewer.timeline.pause()
        spent, seconds = time.process_time() - spent, time.perf_counter() - begin
        ours.send("enough")
        received, size = ours.recv()
        client.join()
        frames = made or received
        print(f"{name}: frames at a client            {received / seconds:8.1f} per second")
        print(f"{name}: size of a frame               {size / max(received, 1) / 1000.0:8.1f} kB")
        print(f"{name}: processor time of a frame     {1000.0 * spent / frames:8.1f} ms, made and sent")
    viewer.close()


def _listen(pipe: Any, url: str, slider: str) -> None:
    """A client: says when it has the scene, and at the end how many frames came then, and how many bytes."""
    import msgspec
    import viser
    import zstandard
    from websockets.sync.client import connect

    with connect(
        url.replace("http", "ws", 1),
        origin=url.rstrip("/"),
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    ) as socket:
        end = time.monotonic() + BACKLOG
        while time.monotonic() < end:
            _received(socket, 0.2)
        pipe.send("ready")
        windows = []
        while not pipe.poll():
            window = _received(socket, 0.5)
            windows += [] if window is None else [window]
    times = set()
    for number, window in enumerate(windows):
        size = HEADER + int.from_bytes(window[8:HEADER], "little")
        data = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(window[HEADER:size]))
        times |= {number for each in data["messages"] if each.get("uuid") == slider}
    pipe.send((len(times), sum(map(len, windows))))


def _received(socket: Any, seconds: float) -> bytes | None:
    try:
        return bytes(socket.recv(timeout=seconds))
    except TimeoutError:
        return None


def _browse(plan: rollgait.Plan) -> None:
    """Pictures per second, and memory, in a browser."""
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("error: chromium is not installed: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    viewer = Viewer(clip_of_plan(plan, "benchmark"), port=0)
    with tempfile.TemporaryDirectory() as profile, sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            profile,
            executable_path=chromium,
            args=FLAGS,
            headless=True,
            viewport={"width": 1100, "height": 700},
        )
        page = context.pages[0]
        page.goto(viewer.url)
        page.get_by_text("benchmark").wait_for()
        page.wait_for_timeout(5000)
        _play(viewer, page)
        _scrub(viewer, page)
        context.close()
    viewer.close()


def _play(viewer: Viewer, page: Any) -> None:
    page.evaluate(WATCH_SCENE)
    viewer.timeline.play()
    drawn = page.evaluate(COUNT_PICTURES, PLAYED)
    changed = page.evaluate(COUNT_UPDATES, PLAYED)
    begin = time.perf_counter()
    before = viewer.timeline.time
    page.wait_for_timeout(1000)
    ratio = ((viewer.timeline.time - before) % viewer.clip.horizon) / (time.perf_counter() - begin)
    viewer.timeline.pause()
    print(f"frames sent per second          {FRAME_RATE:8.1f}")
    print(f"positions of the slider seen    {changed:8.1f} per second")
    print(f"pictures drawn by the browser   {drawn:8.1f} per second (software rendering)")
    print(f"time of the motion              {ratio:8.2f} of real time")


def _scrub(viewer: Viewer, page: Any) -> None:
    horizon = viewer.clip.horizon
    for move in range(100):  # what is made once does not count
        viewer.timeline.go(horizon * (move % 100) / 100.0)
    page.wait_for_timeout(3000)
    before, server = _heap(page), _resident()
    for move in range(MOVES):
        viewer.timeline.go(horizon * ((37 * move) % 1000) / 1000.0)
        if move % 4 == 0:
            page.wait_for_timeout(4)
    page.wait_for_timeout(5000)
    print(f"memory added to the page        {_heap(page) - before:8.1f} MB after {MOVES} moves")
    print(f"memory added to the server      {_resident() - server:8.1f} MB")


def _heap(page: Any) -> float:
    """Heap of the page after a collection, MB."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    used = session.send("Runtime.getHeapUsage")["usedSize"]
    session.detach()
    return float(used) / MEGABYTE


def _resident() -> float:
    """Memory of this process, MB."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1000.0
    return 0.0


if __name__ == "__main__":
    main()
