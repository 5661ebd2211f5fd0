"""The viewer: a page with a motion, its certificate, and a place to plan the next one.

All state is the server's: every browser sees and moves the same.
"""

from __future__ import annotations

import threading
from html import escape
from pathlib import Path
from typing import Any

import viser

from rollgait.diagnosis.report import Diagnosis
from rollgait.errors import RollgaitError
from rollgait.plan.plan import Plan
from rollgait.scenario import find_scenario, scenario_names
from rollgait.tracking import JointTrajectory
from rollgait.view.camera import aim, fit
from rollgait.view.clip import Clip, clip_of_plan
from rollgait.view.gate.uploads import check_unpacked
from rollgait.view.layers.layer import GHOST
from rollgait.view.lights import add_lights, cast_shadows
from rollgait.view.meshes import whole_body_of
from rollgait.view.opening import clip_of, open_clip
from rollgait.view.panels.certificate import CertificatePanel
from rollgait.view.panels.motion import Header, LayerPanel, PlotPanel, TimePanel
from rollgait.view.panels.planning import PlanningPanel
from rollgait.view.scene import Scene
from rollgait.view.server import LOOPBACK, PORT, start_server, stop_server
from rollgait.view.solving import Outcome, Solving, SolvingProgress
from rollgait.view.standing_clip import KIND, clip_of_scenario, scenario_from_page
from rollgait.view.timeline import Timeline

UPLOAD_NAME = "uploaded"
SCENARIO_SUFFIXES = (".yaml", ".yml")
PLOT_EVERY = 3
"""Frames from one value to the next beside the plots while playing: nobody reads faster."""


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
        self.scene: Scene | None = None
        self.ghost: Scene | None = None
        self.timeline = Timeline(clip.horizon, self._follow)
        self.planning = Solving(self._progressed, self._planned)
        self.tracking = Solving(lambda _: None, self._tracked)
        try:
            self._build_page()
            self.show(clip, ghost)
            aim(self.server, clip)
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        return f"<Viewer: {self.clip.name} at {self.url}>"

    def _repr_html_(self) -> str:
        said = f"<b>{escape(self.clip.name)}</b>: {escape(self.clip.verdict)}"
        return f'<p>{said}; <a href="{escape(self.url, quote=True)}" target="_blank">open the viewer</a></p>'

    # -- what is shown --

    def show(self, clip: Clip, ghost: Clip | None = None) -> None:
        """Shows a clip, and another one as its ghost."""
        with self._lock, self.server.atomic():
            switches = self._switches()
            for scene in (self.scene, self.ghost):
                if scene is not None:
                    scene.remove()
            self._count += 1
            api = self.server.scene
            self.scene = Scene(api, f"/motion{self._count}", clip)
            self.ghost = None if ghost is None else Scene(api, f"/ghost{self._count}", ghost, GHOST)
            for title, shown in switches.items():
                self.scene.switch(title, shown)
            self._header.show(clip, ghost)
            self.time.build(clip)
            self._layers.build({t: layer.root.visible for t, layer in self.scene.layers.items()})
            self._plots.build(clip)
            self._certificate.build(clip)
            self.panel.build(clip)
            self._whole_body.visible = (
                clip.plan is not None and clip.joints is None and whole_body_of(clip.robot) is not None
            )
            self._no_ghost.visible = ghost is not None
            horizon = max(clip.horizon, 0.0 if ghost is None else ghost.horizon)
            self.timeline.restart(min(horizon, clip.horizon))

    @property
    def clip(self) -> Clip:
        """What is shown."""
        if self.scene is None:
            raise RuntimeError("nothing is shown yet")
        return self.scene.clip

    def close(self) -> None:
        """Ends the page and all that runs behind it."""
        self.timeline.close()
        self.planning.close()
        self.tracking.close()
        stop_server(self.server)

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

    def _build_page(self) -> None:
        gui = self.server.gui
        self._header = Header(gui)
        self.time = TimePanel(gui, self.timeline)
        tabs = gui.add_tab_group(order=3.0)
        with tabs.add_tab("Plots") as tab:
            self._plots = PlotPanel(gui, tab)
        with tabs.add_tab("Layers"):
            shadows = gui.add_checkbox("shadows", False, hint="Without a graphics card they halve the speed")
            self._layers = LayerPanel(gui, self._switch)
        shadows.on_update(lambda event: cast_shadows(self.server.scene, event.target.value))
        add_lights(self.server.scene)
        cast_shadows(self.server.scene, False)
        with tabs.add_tab("Certificate") as tab:
            self._certificate = CertificatePanel(gui, tab, self._go)
        with tabs.add_tab("Plan"):
            self.panel = PlanningPanel(self.server, self.plan, self.planning.cancel, self._save_plan)
        self.panel.picker.on_update(self._picked)
        self.server.on_client_connect(lambda client: fit(client, self.clip))
        with tabs.add_tab("Files"):
            self._build_files(gui)

    def _build_files(self, gui: viser.GuiApi) -> None:
        opened = gui.add_upload_button(
            "Open a plan, joints, a log or a scenario",
            icon=viser.Icon.FOLDER_OPEN,
            mime_type=".npz,.yaml,.yml",
            color="gray",
        )
        compared = gui.add_upload_button(
            "Compare with", icon=viser.Icon.GHOST, mime_type=".npz", color="gray"
        )
        self._no_ghost = gui.add_button("Take the ghost away", icon=viser.Icon.GHOST_OFF, color="gray")
        self._whole_body = gui.add_button(
            "Find the whole body", icon=viser.Icon.ROBOT, color="gray", hint="Joints that follow the plan"
        )
        self._note = gui.add_markdown("")
        opened.on_upload(lambda event: self._uploaded(event.target.value, ghost=False))
        compared.on_upload(lambda event: self._uploaded(event.target.value, ghost=True))
        self._no_ghost.on_click(lambda _: self.show(self.clip))
        self._whole_body.on_click(lambda _: self._track())

    def _picked(self, event: Any) -> None:
        """Where nothing is planned yet, the ground of the scenario that is picked is shown at once."""
        name = event.target.value
        if event.client is not None and self.clip.kind == KIND and name in scenario_names():
            self.show(clip_of_scenario(find_scenario(name), name))

    # -- files --

    def _uploaded(self, file: Any, ghost: bool) -> None:
        if not self._opening.acquire(blocking=False):
            self._note.content = "another file is being opened"
            return
        try:
            self._open(file, ghost)
        finally:
            self._opening.release()

    def _open(self, file: Any, ghost: bool) -> None:
        path = self.planning.new_file()
        try:
            if Path(file.name).suffix in SCENARIO_SUFFIXES:
                clip = clip_of_scenario(scenario_from_page(file.content, file.name), file.name)
            else:
                check_unpacked(file.name, file.content)
                path.write_bytes(file.content)
                clip = open_clip(path)
        except RollgaitError as error:
            self._note.content = _plain(str(error).replace(repr(str(path)), repr(file.name)))
            return
        finally:
            path.unlink(missing_ok=True)
        clip = _renamed(clip, Path(file.name).stem or UPLOAD_NAME)
        self._note.content = ""
        if ghost:
            self.show(self.clip, clip)
        else:
            self.show(clip)

    def _save_plan(self, client: viser.ClientHandle) -> None:
        plan = self.clip.plan
        if plan is not None:
            path = plan.save(self.planning.new_file())
            client.send_file_download(f"{self.clip.name}.npz", path.read_bytes(), save_immediately=True)
            path.unlink()

    # -- planning --

    def plan(self) -> None:
        """Plans what the controls ask for, in the background."""
        try:
            scenario = self.panel.scenario()
        except RollgaitError as error:
            self.panel.done(str(error), good=False)
            return
        if self.planning.plan(scenario):
            self.panel.busy(scenario)
        else:
            self._again = True  # as soon as the task before is done

    def _progressed(self, progress: SolvingProgress) -> None:
        self.panel.progress(progress)

    def _planned(self, outcome: Outcome) -> None:
        again, self._again = self._again, False
        if again:  # the goal was moved on while it was planned
            self.plan()
        elif outcome.file is None:
            self.panel.done(outcome.message, good=False, diagnosis=outcome.diagnosis)
        else:
            self._show_planned(Plan.load(outcome.file), outcome.diagnosis)

    def _show_planned(self, plan: Plan, diagnosis: Diagnosis | None) -> None:
        clip = clip_of_plan(plan, "planned here")
        before = self.clip if self.panel.keep.value else None
        self.show(clip, before)
        seconds = plan.statistics.solve_time
        said = f"solved in {seconds:.2g} s, {clip.verdict}"
        if plan.statistics.discovery:
            steps = sum(1 for _ in plan.schedule.swings())
            said = f"{steps} steps found; {said}" if steps else f"no steps needed; {said}"
        self.panel.done(said, clip.passed, diagnosis)
        self.timeline.play()

    def _track(self) -> None:
        plan = self.clip.plan
        if plan is not None and self.tracking.track(plan.save(self.tracking.new_file())):
            self._whole_body.disabled = True
            self._note.content = "finding the joints …"

    def _tracked(self, outcome: Outcome) -> None:
        self._whole_body.disabled = False
        self._note.content = _plain(outcome.message)
        if outcome.file is None:
            return
        clip = self.clip.with_joints(JointTrajectory.load(outcome.file))
        self.show(clip, None if self.ghost is None else self.ghost.clip)


def view(motion: Any, compare: Any = None, *, host: str = LOOPBACK, port: int = PORT) -> Viewer:
    """Opens the viewer of a motion and returns at once; it lives until `close` or the end of the program.

    Args:
        motion: a plan, joints, a simulation, a run of the controller, a scenario, or the file of one.
        compare: another one to show as a ghost.
        host: address to listen on.
        port: 0 takes a free one.

    Raises:
        InputError: a file is not what it should be, or the port cannot be had.
    """
    return Viewer(clip_of(motion), None if compare is None else clip_of(compare), host, port)


def _renamed(clip: Clip, name: str) -> Clip:
    from dataclasses import replace

    return replace(clip, name=name)


def _plain(text: str) -> str:
    """Text as Markdown that means nothing but itself."""
    return "".join(f"\\{letter}" if letter in "\\`*_{}[]<>()#+-.!|&" else letter for letter in text)
