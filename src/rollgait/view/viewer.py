"""The page: a motion, its certificate, and a place to design and plan the next one.

All state is the server's: every browser sees and moves the same.
"""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
import viser

from rollgait.diagnosis.report import Diagnosis
from rollgait.errors import RollgaitError
from rollgait.plan.plan import Plan
from rollgait.scenario import Scenario, find_scenario, scenario_names
from rollgait.terrain.mesh import window_around
from rollgait.tracking import JointTrajectory
from rollgait.view.camera import aim, camera_of, fit, look_at
from rollgait.view.clip import Clip, clip_of_plan
from rollgait.view.design.designer import Designer
from rollgait.view.design.files import file_name, scenario_file, scenario_from_page
from rollgait.view.design.runs import Run, Runs
from rollgait.view.exports import NEED_JOINTS, exported
from rollgait.view.gate.uploads import check_unpacked
from rollgait.view.layers.layer import GHOST
from rollgait.view.lights import add_lights, cast_shadows
from rollgait.view.opening import open_clip
from rollgait.view.panels.certificate import CertificatePanel
from rollgait.view.panels.files import FilesPanel
from rollgait.view.panels.keys import add_keys
from rollgait.view.panels.motion import Header, LayerPanel, PlotPanel, TimePanel
from rollgait.view.panels.runs import RunsPanel
from rollgait.view.scene import Scene
from rollgait.view.server import LOOPBACK, PORT, start_server, stop_server
from rollgait.view.solving import Outcome, Solving, SolvingProgress
from rollgait.view.standing_clip import KIND, clip_of_scenario, places_of
from rollgait.view.timeline import Timeline

UPLOAD_NAME = "uploaded"
PLANNED: Final = "planned"
SCENARIO_SUFFIXES: Final = (".yaml", ".yml", ".zip")
PLOT_EVERY = 3
"""Frames from one value to the next beside the plots while playing: nobody reads faster."""
ASIDE: Final = 2.0
"""Between a motion and its ghost side by side, in distances of the left from the right feet."""
FRAME_HEIGHT: Final = 600
"""Of the page in a notebook, pixels: room for its controls."""
KEYS: Final = {
    "space": "play, pause",
    "← →": "a frame back, ahead",
    "P": "plan",
    "Ctrl+Z, Ctrl+Y": "undo, redo",
    "Ctrl+K": "all commands by name",
    "mouse": "left: turn, right: shift, wheel: nearer",
}


class Viewer:
    """A page at `url` until `close`.

    Args:
        clip: what is shown.
        ghost: what stands behind it to compare, None if nothing.
        host: address to listen on.
        port: 0 takes a free one.

    Raises:
        InputError: the port or the host cannot be had.
    """

    def __init__(self, clip: Clip, ghost: Clip | None = None, host: str = LOOPBACK, port: int = PORT) -> None:
        self.server = start_server(host, port, "rollgait")
        self.url = self.server.url
        self._lock = threading.RLock()
        self._opening = threading.Lock()
        self._count, self._again = 0, False
        self._folder = TemporaryDirectory(prefix="rollgait-page-")
        self._asked: Scenario | None = None
        self._export: tuple[viser.ClientHandle, str] | None = None
        self._beside = False
        self.scene: Scene | None = None
        self.ghost: Scene | None = None
        self.runs = Runs()
        self.timeline = Timeline(clip.horizon, self._follow)
        self.planning = Solving(self._progressed, self._planned)
        self.tracking = Solving(lambda _: None, self._tracked)
        try:
            self._build_page(clip)
            self.show(clip, ghost)
            aim(self.server, camera_of(clip))
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        return f"<Viewer: {self.clip.name} at {self.url}>"

    def _repr_html_(self) -> str:
        said = f"<b>{escape(self.clip.name)}</b>: {escape(self.clip.verdict)}"
        url, title = escape(self.url, quote=True), escape(self.clip.name, quote=True)
        link = f'<p>{said}; <a href="{url}" target="_blank">open the viewer</a></p>'
        if not self.server.frame():
            return link
        style = f"width:100%;height:{FRAME_HEIGHT}px;border:0"
        return f'<iframe title="{title}" src="{url}" style="{style}"></iframe>{link}'

    # -- what is shown --

    def show(self, clip: Clip, ghost: Clip | None = None) -> None:
        """Shows a clip, and another one as its ghost; the design goes on with the scenario of the clip."""
        with self._lock, self.server.atomic():
            for each in (ghost, clip):
                if each is not None and each.kind != KIND and self.runs.of(each) is None:
                    self.runs.add(each, each.scenario)
            self._show(clip, ghost)
            if clip.scenario is not None:
                self.designer.put(clip.scenario, clip.name)
            else:
                self.designer.show()

    def _show(self, clip: Clip, ghost: Clip | None) -> None:
        """Shows a clip, and leaves the design as it is."""
        with self._lock, self.server.atomic():
            switches = self._switches()
            for scene in (self.scene, self.ghost):
                if scene is not None:
                    scene.remove()
            self._count += 1
            api = self.server.scene
            # the goals of a design are drawn with their handles
            seen = replace(clip, goals=()) if clip.kind == KIND else clip
            self.scene = Scene(api, f"/motion{self._count}", seen)
            self.ghost = None if ghost is None else Scene(api, f"/ghost{self._count}", ghost, GHOST)
            self._clip = clip
            for title, shown in switches.items():
                self.scene.switch(title, shown)
            self._put_aside()
            self._header.show(clip, ghost)
            self.time.build(clip)
            self._layers.build({t: layer.root.visible for t, layer in self.scene.layers.items()})
            self._plots.build(clip)
            self._certificate.build(clip)
            self._files.build(clip, ghost)
            self._runs.build(clip, ghost)
            horizon = max(clip.horizon, 0.0 if ghost is None else ghost.horizon)
            if clip.kind == KIND:
                self.timeline.pause()
            self.timeline.restart(min(horizon, clip.horizon))

    def _show_run(self, run: Run, other: Run | None) -> None:
        self._show(run.clip, None if other is None else other.clip)

    def _design_run(self, run: Run) -> None:
        if run.asked is not None:
            self.designer.put(run.asked, self.designer.draft.name)

    def _stand_beside(self, beside: bool) -> None:
        with self._lock, self.server.atomic():
            self._beside = beside
            self._put_aside()

    def _put_aside(self) -> None:
        """The ghost stands in the motion, or beside it."""
        if self.ghost is not None:
            width = float(self.ghost.clip.robot.stance[:, 1].max() - self.ghost.clip.robot.stance[:, 1].min())
            self.ghost.stand(ASIDE * width if self._beside else 0.0)

    @property
    def clip(self) -> Clip:
        """What is shown."""
        if self.scene is None:
            raise RuntimeError("nothing is shown yet")
        return self._clip

    def close(self) -> None:
        """Ends the page and all that runs behind it."""
        self.timeline.close()
        self.planning.close()
        self.tracking.close()
        stop_server(self.server)
        self._folder.cleanup()

    def _switches(self) -> dict[str, bool]:
        """The state of the switches, to be kept for the next clip."""
        if self.scene is None:
            return {}
        keep = ("robot", "whole body")  # which of the two depends on the clip
        return {t: layer.root.visible for t, layer in self.scene.layers.items() if t not in keep}

    def _switch(self, title: str, shown: bool) -> None:
        with self._lock, self.server.atomic():
            for scene in (self.scene, self.ghost):
                if scene is not None:
                    scene.switch(title, shown)

    def _follow(self) -> None:
        """Shows the time at which the timeline stands."""
        with self._lock:
            if self.scene is None:
                return
            with self.server.atomic():
                self.scene.show(self.timeline.time)
                if self.ghost is not None:
                    self.ghost.show(self.timeline.time)
                self.time.follow()
                if not self.timeline.playing or self.scene.index % PLOT_EVERY == 0:
                    self._plots.follow(self.scene.index)

    def _go(self, time: float) -> None:
        self.timeline.pause()
        self.timeline.go(time)

    # -- the page --

    def _build_page(self, clip: Clip) -> None:
        gui = self.server.gui
        self._header = Header(gui)
        self.time = TimePanel(gui, self.timeline)
        tabs = gui.add_tab_group(order=3.0)
        seen = (self._build_plots, self._build_layers, self._build_certificate)
        first, then = ((self._build_design,), seen) if clip.kind == KIND else (seen, (self._build_design,))
        for build in (*first, *then, self._build_runs, self._build_files):
            build(gui, tabs)
        add_keys(gui, KEYS)
        add_lights(self.server.scene)
        cast_shadows(self.server.scene, False)
        fit(self.server, lambda: camera_of(self.clip))

    def _build_plots(self, gui: viser.GuiApi, tabs: Any) -> None:
        with tabs.add_tab("Plots") as tab:
            self._plots = PlotPanel(gui, tab)

    def _build_layers(self, gui: viser.GuiApi, tabs: Any) -> None:
        with tabs.add_tab("Layers"):
            shadows = gui.add_checkbox("shadows", False, hint="Without a graphics card they halve the speed")
            self._layers = LayerPanel(gui, self._switch)
        shadows.on_update(lambda event: cast_shadows(self.server.scene, event.target.value))

    def _build_certificate(self, gui: viser.GuiApi, tabs: Any) -> None:
        with tabs.add_tab("Certificate") as tab:
            self._certificate = CertificatePanel(gui, tab, self._go)

    def _build_design(self, gui: viser.GuiApi, tabs: Any) -> None:
        first = scenario_names()[0]
        with tabs.add_tab("Design"):
            self.designer = Designer(
                self.server,
                self._lock,
                Path(self._folder.name),
                find_scenario(first),
                first,
                self.plan,
                self.planning.cancel,
                self._designed,
            )

    def _build_runs(self, gui: viser.GuiApi, tabs: Any) -> None:
        with tabs.add_tab("Runs"):
            self._runs = RunsPanel(gui, self.runs, self._show_run, self._design_run, self._stand_beside)

    def _build_files(self, gui: viser.GuiApi, tabs: Any) -> None:
        with tabs.add_tab("Files"):
            self._files = FilesPanel(
                gui,
                self.server.beside(self._uploaded),
                self._track,
                lambda: self._show(self.clip, None),
                self._save_plan,
                self._save_scenario,
                self.server.beside(self._send_export),
            )

    # -- design --

    def _designed(self) -> None:
        """Where robot, start or ground of the draft are others than those shown, it is shown."""
        draft = self.designer.draft
        self._files.show_python(self.designer.python())
        if self.scene is None or self.clip is None:
            return
        shown = self.clip.scenario
        far = self.clip.kind == KIND and _window(shown) != _window(draft.scenario)
        if shown is None or (_stage(shown) == _stage(draft.scenario) and not far):
            return
        before = self.clip
        self._show(clip_of_scenario(draft.scenario, draft.name), None)
        if before.name != self.clip.name:
            for client in self.server.get_clients().values():
                look_at(client, self.clip)

    # -- files --

    def _uploaded(self, file: Any, ghost: bool) -> None:
        if not self._opening.acquire(blocking=False):
            self._files.note("another file is being opened")
            return
        try:
            self._open(file, ghost)
        finally:
            self._opening.release()

    def _open(self, file: Any, ghost: bool) -> None:
        path = self.planning.new_file()
        stem = Path(file.name).stem or UPLOAD_NAME
        try:
            check_unpacked(file.name, file.content)
            if Path(file.name).suffix in SCENARIO_SUFFIXES:
                scenario = scenario_from_page(file.content, file.name, Path(self._folder.name))
                clip = clip_of_scenario(scenario, stem)
            else:
                path.write_bytes(file.content)
                clip = replace(open_clip(path), name=stem)
        except RollgaitError as error:
            self._files.note(str(error).replace(repr(str(path)), repr(file.name)))
            return
        finally:
            path.unlink(missing_ok=True)
        self._files.note("")
        if ghost:
            with self._lock:
                self.runs.add(clip, clip.scenario)
                self._show(self.clip, clip)
        else:
            self.show(clip)
            for client in self.server.get_clients().values():
                look_at(client, clip)

    def _save_plan(self, client: viser.ClientHandle) -> None:
        plan = self.clip.plan
        if plan is not None:
            path = plan.save(self.planning.new_file())
            client.send_file_download(
                f"{file_name(self.clip.name)}.npz", path.read_bytes(), save_immediately=True
            )
            path.unlink()

    def _save_scenario(self, client: viser.ClientHandle) -> None:
        draft = self.designer.draft
        name, content = scenario_file(draft.scenario, draft.name, Path(self._folder.name))
        client.send_file_download(name, content, save_immediately=True)

    def _send_export(self, client: viser.ClientHandle, format: str) -> None:
        clip = self.clip
        if format in NEED_JOINTS and clip.trajectory is None and clip.plan is not None:
            self._export = (client, format)  # as soon as the joints are found
            self._track()
            return
        if not self._opening.acquire(blocking=False):
            self._files.note("another file is being opened or written")
            return
        try:
            self._files.note(f"writing {format} …")
            name, content = exported(clip, format, file_name(clip.name))
        except RollgaitError as error:
            self._files.note(str(error))
            return
        finally:
            self._opening.release()
        client.send_file_download(name, content, save_immediately=True)
        self._files.note("")

    # -- planning --

    def plan(self) -> None:
        """Plans the draft, in the background."""
        with self._lock:
            draft, panel = self.designer.draft, self.designer.panel
            if draft.fault:
                panel.done(draft.fault, good=False)
            elif self.planning.plan(draft.scenario):
                self._asked = draft.scenario
                panel.busy()
            else:
                self._again = True  # as soon as the task before is done

    def _progressed(self, progress: SolvingProgress) -> None:
        with self._lock:
            self.designer.panel.progress(progress)

    def _planned(self, outcome: Outcome) -> None:
        again, self._again = self._again, False
        if again:  # the goal was moved on while it was planned
            self.plan()
        elif outcome.file is None:
            with self._lock:
                self.designer.panel.done(outcome.message, good=False, diagnosis=outcome.diagnosis)
        else:
            self._show_planned(Plan.load(outcome.file), outcome.diagnosis)

    def _show_planned(self, plan: Plan, diagnosis: Diagnosis | None) -> None:
        clip = clip_of_plan(plan, f"{self.designer.draft.name}, {PLANNED}")
        with self._lock, self.server.atomic():
            before = self.clip if self.designer.panel.keep.value and self.clip.kind != KIND else None
            self.runs.add(clip, self._asked)
            self._show(clip, before)
        seconds = plan.statistics.solve_time
        said = f"solved in {seconds:.2g} s, {clip.verdict}"
        if plan.statistics.discovery:
            steps = sum(1 for _ in plan.schedule.swings())
            said = f"{steps} steps found; {said}" if steps else f"no steps needed; {said}"
        with self._lock:
            self.designer.panel.done(said, clip.passed, diagnosis)
        self.timeline.play()

    def _track(self) -> None:
        plan = self.clip.plan
        if plan is not None and self.tracking.track(plan.save(self.tracking.new_file())):
            self._files.whole_body.disabled = True
            self._files.note("finding the joints …")

    def _tracked(self, outcome: Outcome) -> None:
        export, self._export = self._export, None
        self._files.whole_body.disabled = False
        self._files.note(outcome.message)
        if outcome.file is None:
            return
        with self._lock, self.server.atomic():
            clip = self.clip.with_joints(JointTrajectory.load(outcome.file))
            self.runs.replace(self.clip, clip)
            self._show(clip, None if self.ghost is None else self.ghost.clip)
        if export is not None:
            self._send_export(*export)


def _window(scenario: Scenario | None) -> list[float]:
    """How much ground a design needs, m."""
    return [] if scenario is None else np.concatenate(window_around(places_of(scenario))).tolist()


def _stage(scenario: Scenario) -> str:
    """What of a scenario stands in the scene before anything moves, but its goals."""
    data, heights = scenario.to_dict(), scenario.ground.heights
    ground = {**data["ground"], "map": None if heights is None else heights.digest}
    robot = scenario.body.with_feet("point")  # how the gait uses its feet is not seen
    pulls = data["loads"]["wrench"]
    return json.dumps([robot.model_dump(mode="json"), data["start"], ground, pulls])
