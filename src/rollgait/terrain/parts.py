"""Parts of ground: each a small class that says of which planar pieces it is made, exactly.

A new part is one class like those here and its name in `Part`. A part stands at a place, turned by a yaw. Its
own frame has x along its axis and y to the left; heights count from the ground's `height`, so that parts that
follow one another (ramp, plateau, ramp) need no sums of what lies under them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Final, Literal

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, model_validator

from rollgait.config import Config, Number, Positive, Whole
from rollgait.terrain.facet import FAR, Facet, plane_through
from rollgait.terrain.polygons import Array, clip, rectangle

HEIGHT_MAX: Final = 100.0
"""Highest and deepest that a part goes, m: more is a wrong unit."""
ENDLESS: Final = 3.0 * FAR
"""How long what has no end is, m: from anywhere in the square of all planar ground out of it."""
SLOPE_MAX_DEG: Final = 60.0
"""Steepest ramp, degrees: no wheel rolls on it, and steeper is a wall."""


def _within_reach(value: float) -> float:
    if abs(value) > FAR:
        raise ValueError(f"must lie within {FAR:g} m of the origin")
    return value


def _of_ground(value: float) -> float:
    if abs(value) > HEIGHT_MAX:
        raise ValueError(f"must be at most {HEIGHT_MAX:g} m up or down")
    return value


def _not_level(value: float) -> float:
    if value == 0.0:
        raise ValueError("must not be 0")
    return value


Coordinate = Annotated[Number, AfterValidator(_within_reach)]
Height = Annotated[Number, AfterValidator(_of_ground)]
Rise = Annotated[Height, AfterValidator(_not_level)]
Length = Annotated[Positive, AfterValidator(_within_reach)]

Piece = tuple[float, float, float, float]
"""Where a piece begins on the axis and how long it is, its height there and its slope along the axis."""


class BasePart(Config):
    """What all parts share."""

    x: Coordinate
    """x of the middle of its near edge (of a block: of its centre), m."""
    y: Coordinate = 0.0
    """y of the middle of its near edge (of a block: of its centre), m."""
    yaw_deg: Number = 0.0
    """Direction in which it goes on from its near edge, degrees."""
    z: Height = 0.0
    """Height of its foot over the ground's `height`, m."""
    friction: Positive | None = None
    """μ of this part; if none, that of the ground."""

    @property
    def yaw(self) -> float:
        """rad."""
        return float(np.radians(self.yaw_deg))

    @property
    def across(self) -> float:
        """How wide it is, m."""
        width = getattr(self, "width", None)
        return 2.0 * ENDLESS if width is None else float(width)

    def pieces(self) -> Iterator[Piece]:
        """Its planar pieces along its axis, of its whole width."""
        raise NotImplementedError

    def facets(self, height: float, friction: float, source: int) -> Iterator[Facet]:
        """Its planar pieces in the world.

        Args:
            height: of the ground that it lies on, m.
            friction: μ of that ground.
            source: number of this part.
        """
        along = np.array([np.cos(self.yaw), np.sin(self.yaw)])
        near = np.array([self.x, self.y])
        mu = friction if self.friction is None else self.friction
        for begin, length, foot, slope in self.pieces():
            at = near + begin * along
            outline = _within_square(rectangle(at, self.yaw, length, 0.5 * self.across, 0.5 * self.across))
            if outline is None:
                continue
            gradient = slope * along
            level = plane_through(np.append(at, height + self.z + foot), gradient)
            yield Facet(outline, level, gradient, mu, source)


class Ramp(BasePart):
    """An inclined plane."""

    kind: Literal["ramp"] = "ramp"
    """Kind of the part."""
    length: Length
    """From its near to its far edge, horizontally, m."""
    width: Length | None = None
    """Across, m; without end if none."""
    rise: Rise | None = None
    """By how much its far edge is higher than its near one, m; negative goes down. Or say `slope_deg`."""
    slope_deg: Annotated[Number, Field(ge=-SLOPE_MAX_DEG, le=SLOPE_MAX_DEG)] | None = None
    """Its slope, degrees; negative goes down. Or say `rise`."""

    @model_validator(mode="after")
    def _says_how_steep(self) -> Ramp:
        if (self.rise is None) == (self.slope_deg is None):
            raise ValueError("must say either its rise or its slope_deg, one of the two")
        if abs(np.degrees(np.arctan(self.slope))) > SLOPE_MAX_DEG + 1e-9:
            raise ValueError(f"must be no steeper than {SLOPE_MAX_DEG:g} degrees")
        _of_ground(self.slope * self.length)
        return self

    @property
    def slope(self) -> float:
        """Rise over length."""
        if self.rise is not None:
            return self.rise / self.length
        return float(np.tan(np.radians(self.slope_deg or 0.0)))

    def pieces(self) -> Iterator[Piece]:
        yield 0.0, self.length, 0.0, self.slope


class Step(BasePart):
    """From its near edge on the ground is higher, or lower: a kerb, a platform."""

    kind: Literal["step"] = "step"
    """Kind of the part."""
    height: Rise
    """By how much the ground is higher from its near edge on, m; negative goes down."""
    length: Length | None = None
    """From its near to its far edge, m; without end if none."""
    width: Length | None = None
    """Across, m; without end if none."""

    def pieces(self) -> Iterator[Piece]:
        yield 0.0, ENDLESS if self.length is None else self.length, self.height, 0.0


class Stairs(BasePart):
    """Steps of equal rise and depth."""

    kind: Literal["stairs"] = "stairs"
    """Kind of the part."""
    steps: Annotated[Whole, Field(ge=1, le=100)]
    """Number of steps."""
    rise: Rise
    """Of each step, m; negative goes down."""
    tread: Length
    """Depth of each step, m."""
    landing: Length | None = None
    """Depth of the last step in place of `tread`, m; without end if none."""
    width: Length | None = None
    """Across, m; without end if none."""

    @model_validator(mode="after")
    def _is_not_too_high(self) -> Stairs:
        _of_ground(self.steps * self.rise)
        return self

    def pieces(self) -> Iterator[Piece]:
        for k in range(self.steps - 1):
            yield k * self.tread, self.tread, (k + 1) * self.rise, 0.0
        last = ENDLESS if self.landing is None else self.landing
        yield (self.steps - 1) * self.tread, last, self.steps * self.rise, 0.0


class Gap(BasePart):
    """A ditch across the way."""

    kind: Literal["gap"] = "gap"
    """Kind of the part."""
    length: Length
    """From its near to its far edge, m."""
    depth: Annotated[Positive, AfterValidator(_of_ground)] = 1.0
    """Of its floor under its foot, m."""
    width: Length | None = None
    """Across, m; without end if none."""

    def pieces(self) -> Iterator[Piece]:
        yield 0.0, self.length, -self.depth, 0.0


class Block(BasePart):
    """A box on the ground, about its centre; one of negative height is a pothole."""

    kind: Literal["block"] = "block"
    """Kind of the part."""
    length: Length
    """Along its axis, m."""
    width: Length
    """Across, m."""
    height: Rise
    """Of its top over its foot, m; negative is the depth of a pothole."""

    def pieces(self) -> Iterator[Piece]:
        yield -0.5 * self.length, self.length, self.height, 0.0


Part = Annotated[Ramp | Step | Stairs | Gap | Block, Discriminator("kind")]
"""One of the parts, told apart by `kind`."""

PART_KINDS: Final = ("ramp", "step", "stairs", "gap", "block")


def _within_square(polygon: Array) -> Array | None:
    """The part of a polygon inside the square that holds all planar ground."""
    result: Array | None = polygon
    for normal in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        if result is None:
            return None
        inwards = np.array(normal)
        result = clip(result, -FAR * inwards, inwards)
    return result
