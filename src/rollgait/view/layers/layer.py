"""What every layer is: something of a clip, drawn once and moved from frame to frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike, NDArray
from viser import BatchedMeshHandle, SceneApi

from rollgait.plan.samples import Array
from rollgait.view.clip import Clip
from rollgait.view.shapes import Shape
from rollgait.view.style import LEG_COLOURS

Colour = tuple[int, int, int]

NOWHERE = 1e-6
"""Scale of what is not to be seen: 0 has no inverse."""


@dataclass(frozen=True)
class Look:
    """How a clip is drawn.

    Attributes:
        opacity: of bodies; None is opaque.
        colour: instead of the colours by leg; None keeps them.
    """

    opacity: float | None = None
    colour: str | None = None

    @property
    def ghost(self) -> bool:
        """Whether the clip stands behind another one."""
        return self.colour is not None

    def of(self, colour: str) -> Colour:
        """A colour as this look has it."""
        return rgb(self.colour or colour)

    def leg(self, leg: int) -> Colour:
        """The colour of a leg."""
        return self.of(LEG_COLOURS[leg])

    def legs(self, light: float = 0.0) -> NDArray[np.uint8]:
        """The colours of the legs, some way to white, as a batch wants them, (4, 3)."""
        return linear([rgb(self.colour or colour, light) for colour in LEG_COLOURS])


SOLID = Look()
GHOST = Look(opacity=0.35, colour="#5B7FA6")


class Layer(ABC):
    """One switch on the page.

    Attributes:
        title: what the switch says.
        shown: whether it is on at first.
        for_ghost: whether a ghost has it.
    """

    title: ClassVar[str]
    shown: ClassVar[bool] = True
    for_ghost: ClassVar[bool] = False

    def __init__(self, scene: SceneApi, path: str, clip: Clip, look: Look) -> None:
        self.scene, self.clip, self.look = scene, clip, look
        self.path = f"{path}/{self.title.replace(' ', '-')}"
        self.root = scene.add_frame(self.path, show_axes=False, visible=self.shown)
        self.draw()

    @classmethod
    def suits(cls, clip: Clip) -> bool:
        """Whether there is anything to draw."""
        return True

    @abstractmethod
    def draw(self) -> None:
        """Adds everything to the scene, once."""

    def show(self, index: int) -> None:  # noqa: B027  # a layer that stands still
        """Moves everything to where it is in a frame."""

    def at(self, name: str) -> str:
        """The name of a part in the scene."""
        return f"{self.path}/{name}"


class Moving:
    """One shape that moves, as a batch of one: all that moves in a scene is in batches.

    Viser's page draws the pose of a node at once, but the arrays of a batch one picture later. Beside batches
    a node would run ahead of them, the farther the fewer pictures a second there are.

    Args:
        scene: where it is.
        name: of the node.
        shape: vertices in m, and faces.
        colour: as it is seen.
        position: (3,), m.
        turn: (w, x, y, z).
        options: further ones of viser's batched meshes.
    """

    def __init__(
        self,
        scene: SceneApi,
        name: str,
        shape: Shape,
        colour: Colour,
        position: ArrayLike = (0.0, 0.0, 0.0),
        turn: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        **options: Any,
    ) -> None:
        self.handle: BatchedMeshHandle = scene.add_batched_meshes_simple(
            name,
            *shape,
            batched_wxyzs=_row(turn),
            batched_positions=_row(position),
            batched_colors=linear([colour]),
            lod="off",
            **options,
        )

    def move(self, position: ArrayLike, turn: ArrayLike | None = None) -> None:
        """To another place, and turned otherwise if that is given."""
        self.handle.batched_positions = _row(position)
        if turn is not None:
            self.handle.batched_wxyzs = _row(turn)


def _row(values: ArrayLike) -> NDArray[np.float32]:
    return np.asarray(values, dtype=np.float32)[None]


def rgb(colour: str, light: float = 0.0) -> Colour:
    """A colour as three bytes, some way to white."""
    r, g, b = (round(255 * (part + (1.0 - part) * light)) for part in to_rgb(colour))
    return r, g, b


def linear(colours: Sequence[Colour] | NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Colours (…, 3) without the gamma of sRGB: viser takes those of batches and of line vertices so."""
    part = np.asarray(colours, dtype=float) / 255.0
    bright = np.where(part > 0.04045, ((part + 0.055) / 1.055) ** 2.4, part / 12.92)  # IEC 61966-2-1
    return np.round(255.0 * bright).astype(np.uint8)


def segments(points: Array) -> Array:
    """The line through points (n, 3), as segments (n − 1, 2, 3)."""
    return np.stack([points[:-1], points[1:]], axis=1)


def single(values: Sequence[float] | Array) -> NDArray[np.float32]:
    """The numbers in the precision of a picture."""
    return np.asarray(values, dtype=np.float32)
