"""The scene of a clip: its layers. A new layer is one class and one line here."""

from __future__ import annotations

from typing import Final

from viser import SceneApi

from rollgait.view.clip import Clip
from rollgait.view.layers.contact import Cones, Forces, Headings, Support
from rollgait.view.layers.discovery import FootholdRegions, GaitsInVain
from rollgait.view.layers.goal import StartAndGoal
from rollgait.view.layers.ground import Ground
from rollgait.view.layers.layer import SOLID, Layer, Look
from rollgait.view.layers.loads import Loads
from rollgait.view.layers.paths import Com, Footholds, Paths
from rollgait.view.layers.robot import Robot
from rollgait.view.layers.whole_body import WholeBody

LAYERS: Final[tuple[type[Layer], ...]] = (
    Robot,
    WholeBody,
    Loads,
    Ground,
    StartAndGoal,
    Paths,
    Footholds,
    Com,
    Forces,
    Cones,
    Support,
    Headings,
    FootholdRegions,
    GaitsInVain,
)
"""Every layer, in the order of the switches."""


class Scene:
    """A clip in three dimensions.

    Attributes:
        clip: what is shown.
        layers: by their titles.
    """

    def __init__(self, api: SceneApi, path: str, clip: Clip, look: Look = SOLID) -> None:
        self.clip, self.look, self._api, self._path = clip, look, api, path
        self.root = api.add_frame(path, show_axes=False)
        kinds = [kind for kind in LAYERS if kind.suits(clip) and (kind.for_ghost or not look.ghost)]
        self.layers: dict[str, Layer] = {kind.title: kind(api, path, clip, look) for kind in kinds}
        if WholeBody.title in self.layers:
            self.switch(Robot.title, False)
        self.index = -1
        self.show(0.0)

    def show(self, time: float) -> None:
        """Moves everything to a time (s); a clip that is over stands still."""
        index = self.clip.frame(time)
        if index == self.index:
            return
        self.index = index
        for layer in self.layers.values():
            if layer.root.visible:
                layer.show(index)

    def switch(self, title: str, visible: bool) -> None:
        """Switches a layer on or off."""
        layer = self.layers.get(title)
        if layer is None:
            return
        if visible and self.index_known:
            layer.show(self.index)
        if layer.root.visible != visible:
            layer.root.visible = visible

    @property
    def index_known(self) -> bool:
        """Whether a frame has been shown."""
        return getattr(self, "index", -1) >= 0

    def stand(self, aside: float) -> None:
        """Puts the whole scene to the side of where it is, m."""
        self.root.position = (0.0, aside, 0.0)

    def remove(self) -> None:
        """Takes everything out of the scene."""
        self.root.remove()
