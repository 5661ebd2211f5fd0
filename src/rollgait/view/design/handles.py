"""What of a draft can be dragged in the scene: its start, its goals, and the parts of its ground."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
import viser

from rollgait.plan.samples import Array
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario
from rollgait.terrain import Terrain
from rollgait.view.design.parts import PLACES, footprint, pose_of
from rollgait.view.layers.goal import outline_of
from rollgait.view.layers.layer import rgb, segments, single
from rollgait.view.on_ground import ABOVE, heights, laid_segments
from rollgait.view.rotations import turn_z, wxyz
from rollgait.view.style import GOAL_COLOUR, MARK_COLOUR, SECOND_COLOUR

ROOT: Final = "/draft"
GIZMO: Final = f"{ROOT}/handle"
SIZE: Final = 0.55
"""Of the handle, m."""
HIGH: Final = 0.01
"""Of it over the ground, m."""
COLOURS: Final = {"start": SECOND_COLOUR, "goal": GOAL_COLOUR, "part": MARK_COLOUR}
LINE: Final = 0.01
"""m"""

Kind = Literal["start", "goal", "part"]


@dataclass(frozen=True)
class Selection:
    """What has the handle: the start, a goal or a part, counted from 0."""

    kind: Kind = "goal"
    number: int = 0

    @property
    def stroke(self) -> str:
        """Its name as something that is changed."""
        return f"{self.kind} {self.number}"

    def values(self, pose: Mapping[str, float]) -> dict[str, float]:
        """A pose (m, degrees) by the dotted keys of a scenario."""
        prefix = {
            "start": "start",
            "goal": "goal" if self.number == 0 else f"goal.then.{self.number - 1}",
            "part": f"ground.parts.{self.number}",
        }[self.kind]
        return {f"{prefix}.{key}": value for key, value in pose.items()}

    def of(self, scenario: Scenario) -> Any:
        """What it is in a scenario; None where there is none of this number."""
        if self.kind == "start":
            return scenario.start
        things = (scenario.goal, *scenario.goal.then) if self.kind == "goal" else scenario.ground.parts
        return things[self.number] if self.number < len(things) else None


Moved = Callable[[Selection, dict[str, float], bool], None]
"""Takes what was moved, to where (x, y in m, yaw_deg), and whether the hand has let go."""


class Handles:
    """The outlines of goals, and one handle.

    Args:
        server: of the page.
        on_moved: is told where the handle is dragged, in the loop of the server.
    """

    def __init__(self, server: viser.ViserServer, on_moved: Moved) -> None:
        self._scene, self._on_moved = server.scene, on_moved
        self._scene.add_frame(ROOT, show_axes=False)
        self.gizmo: Any = self._scene.add_transform_controls(
            GIZMO,
            scale=SIZE,
            active_axes=(True, True, False),
            depth_test=False,
            line_width=3.0,
            opacity=0.7,
        )
        self.gizmo.on_update(self._dragged)
        self._selected, self._yaw = Selection(), 0.0
        self._drawn: list[Any] = []
        self._state: Any = None

    def show(self, scenario: Scenario, selected: Selection) -> None:
        """Draws the outlines of a draft, and puts the handle to what is selected."""
        thing = selected.of(scenario)
        if thing is None:
            selected, thing = Selection(), scenario.goal
        terrain = scenario.terrain
        place = pose_of(thing)
        self._selected, self._yaw = selected, place["yaw_deg"]
        height = float(heights(terrain, np.array([place["x"], place["y"]]))) + HIGH
        self.gizmo.position = (place["x"], place["y"], height)
        self.gizmo.wxyz = wxyz(turn_z(np.radians(place["yaw_deg"])))
        asked = scenario.to_dict()
        state = (asked["goal"], asked["ground"], scenario.body.name, selected)
        if state == self._state:
            return
        self._state = state
        for handle in self._drawn:
            handle.remove()
        own = footprint(thing) if selected.kind == "part" else outline_of(scenario.body)
        flat = np.column_stack([own, np.zeros(len(own))])
        self._drawn = [self._lines(f"{GIZMO}/outline", segments(flat), selected.kind)]
        for number, goal in enumerate((scenario.goal, *scenario.goal.then)):
            if selected != Selection("goal", number):
                self._drawn.append(self._goal(scenario.body, terrain, number, pose_of(goal)))

    def _goal(self, robot: Robot, terrain: Terrain, number: int, pose: Mapping[str, float]) -> Any:
        """The outline of a goal that has no handle."""
        turned = outline_of(robot) @ turn_z(np.radians(pose["yaw_deg"]))[:2, :2].T + [pose["x"], pose["y"]]
        return self._lines(f"{ROOT}/goal{number}", laid_segments(terrain, turned, 3 * ABOVE), "goal")

    def _lines(self, name: str, lines: Array, kind: Kind) -> Any:
        return self._scene.add_line_segments(name, single(lines), rgb(COLOURS[kind], 0.3), thickness=LINE)

    async def _dragged(self, event: Any) -> None:
        x, y, _ = event.target.position
        w, _, _, z = event.target.wxyz
        yaw = float(np.degrees(2.0 * np.arctan2(z, w)))
        yaw += 360.0 * round((self._yaw - yaw) / 360.0)  # a full turn stays one
        self._yaw = yaw
        pose = {"x": round(float(x), PLACES), "y": round(float(y), PLACES), "yaw_deg": round(yaw, 1)}
        self._on_moved(self._selected, pose, event.phase == "end")
