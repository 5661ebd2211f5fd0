"""Start and goals: the outline of the robot where it begins and where it is wanted."""

from __future__ import annotations

import numpy as np

from rollgait.plan.samples import Array
from rollgait.robot.robot import Robot
from rollgait.view import shapes
from rollgait.view.layers.layer import Layer, single
from rollgait.view.on_ground import ABOVE, frames, laid_segments, on_ground
from rollgait.view.rotations import turn_z
from rollgait.view.style import GOAL_COLOUR, SECOND_COLOUR


def outline_of(robot: Robot) -> Array:
    """Closed outline of a robot on the ground with its nose, about the CoM, (n, 2), m."""
    stance = robot.stance[:, :2]
    fl, fr, hl, hr = stance
    front = 0.5 * (fl + fr) + [0.18, 0.0]
    return np.array([fr, front, fl, hl, hr, fr])


class StartAndGoal(Layer):
    """Where the robot begins, and where it is wanted."""

    title = "start and goal"

    def draw(self) -> None:
        s = self.clip.samples
        self._outline("start", s.com_position[0], s.euler[0, 0], SECOND_COLOUR)
        self.goals = []
        for number, goal in enumerate(self.clip.goals):
            handle = self._outline(f"goal{number}", goal.pose[:3], goal.pose[3], GOAL_COLOUR)
            self.goals.append((goal.begin, handle))

    def _outline(self, name: str, place: Array, yaw: float, colour: str):  # type: ignore[no-untyped-def]
        terrain = self.clip.terrain
        turned = outline_of(self.clip.robot) @ turn_z(np.array(yaw))[:2, :2].T + place[:2]
        outline = laid_segments(terrain, turned, 3 * ABOVE)
        frame = self.scene.add_frame(self.at(name), show_axes=False)
        self.scene.add_line_segments(
            self.at(f"{name}/outline"), single(outline), self.look.of(colour), thickness=0.018
        )
        arrow, faces = shapes.flat_arrow(0.3, 0.16)
        arrow = arrow @ frames(terrain, place[:2], np.array(yaw)).T + on_ground(terrain, place[:2], 3 * ABOVE)
        self.scene.add_mesh_simple(
            self.at(f"{name}/arrow"),
            single(arrow),
            faces,
            color=self.look.of(colour),
            side="double",
            cast_shadow=False,
        )
        return frame

    def show(self, index: int) -> None:
        """Of several goals the one that holds now, and those to come."""
        now = self.clip.time[index]
        for number, (_, handle) in enumerate(self.goals):
            end = self.goals[number + 1][0] if number + 1 < len(self.goals) else np.inf
            if handle.visible != (wanted := bool(now < end)):
                handle.visible = wanted
