"""The viewer in a headless browser: frames per second while playing, and memory while scrubbing.

Prints a table. Scrubs as often as an hour of steady scrubbing would (one move every second), only faster.
Usage: python benchmarks/viewer.py [PLAN]
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

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
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("error: chromium is not installed: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    plan = rollgait.Plan.load(sys.argv[1]) if len(sys.argv) > 1 else rollgait.plan("hybrid-forward")
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
