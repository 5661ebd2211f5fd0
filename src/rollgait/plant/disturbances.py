"""What disturbs a simulation: plain data, and the short texts in which the command line takes them."""

from __future__ import annotations

import math
import re
from typing import Annotated, Final

from pydantic import Field

from rollgait.config import Config, NonNegative, Number, Positive, Vector3, validate
from rollgait.errors import InputError

DIRECTIONS: Final = {"+x": 0.0, "x": 0.0, "+y": 90.0, "y": 90.0, "-x": 180.0, "-y": -90.0}
"""Names of directions, as angles from the x axis of the world, degrees."""

PUSH_DURATION: Final = 0.2
"""How long a push lasts if nothing else is said, s."""

RadiusError = Annotated[Number, Field(ge=-0.5, le=0.5)]
Latency = Annotated[NonNegative, Field(le=0.1)]
Slope = Annotated[Number, Field(ge=-45.0, le=45.0)]

_NUMBER: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_PUSH: Final = re.compile(
    rf"(?P<force>{_NUMBER})N(?::(?P<direction>{_NUMBER}deg|[+-]?[xy]))?"
    rf"@(?P<start>{_NUMBER})s?(?::(?P<duration>{_NUMBER})s?)?"
)
_PAYLOAD: Final = re.compile(rf"(?P<mass>{_NUMBER})kg(?:@(?P<place>{_NUMBER}(?:,{_NUMBER}){{2}}))?")


class Push(Config):
    """A horizontal force on the base link for a while."""

    force: Positive
    """N."""
    direction_deg: Number = 90.0
    """Angle from the x axis of the world, degrees; 90 pushes to the left of the start."""
    start: NonNegative
    """When it begins, s."""
    duration: Positive = PUSH_DURATION
    """How long it lasts, s."""

    @property
    def vector(self) -> tuple[float, float, float]:
        """The force in the world, N."""
        angle = math.radians(self.direction_deg)
        return (self.force * math.cos(angle), self.force * math.sin(angle), 0.0)

    @classmethod
    def parse(cls, text: str) -> Push:
        """`50N@3s`, with direction and duration `50N:-y@3s:0.2s` or `50N:45deg@3s:0.2s`.

        Raises:
            InputError: the text has another form, or a value breaks a rule.
        """
        found = _PUSH.fullmatch(text.strip())
        if found is None:
            rule = (
                "must be FORCE@START, e.g. 50N@3s, or with direction and duration, e.g. 50N:-y@3s:0.2s; "
                "directions: x, -x, y, -y or an angle such as 45deg"
            )
            raise InputError("push", text, rule)
        direction = found["direction"] or "y"
        angle = DIRECTIONS.get(direction)
        values = {
            "force": float(found["force"]),
            "direction_deg": float(direction.removesuffix("deg")) if angle is None else angle,
            "start": float(found["start"]),
            "duration": float(found["duration"] or PUSH_DURATION),
        }
        return validate(cls, values, "push")

    def __str__(self) -> str:
        return f"{self.force!r}N:{self.direction_deg!r}deg@{self.start!r}s:{self.duration!r}s"


def check_begins(start: float, end: float, text: str) -> None:
    """Refuses a push that begins when a run is over: nobody would feel it.

    Args:
        start: of the push, s.
        end: of the run, s.
        text: the push, as a message shows it.

    Raises:
        InputError: it does not begin before the end.
    """
    if start >= end:
        raise InputError("push", text, f"must begin within [0, {end:g}) s: then the run ends")


class Payload(Config):
    """A point mass on the base link that the plan does not know of."""

    mass: Positive
    """kg."""
    place: Vector3 = (0.0, 0.0, 0.0)
    """Where, in the frame of the base link, m."""

    @classmethod
    def parse(cls, text: str) -> Payload:
        """`5kg`, or with its place on the base link in metres `5kg@0.1,0.1,0.2`. Raises `InputError`."""
        found = _PAYLOAD.fullmatch(text.strip())
        if found is None:
            rule = (
                "must be MASS or MASS@X,Y,Z with the place on the base link in metres, e.g. 5kg@0.1,0.1,0.2"
            )
            raise InputError("payload", text, rule)
        x, y, z = (float(part) for part in (found["place"] or "0,0,0").split(","))
        return cls(mass=float(found["mass"]), place=(x, y, z))

    def __str__(self) -> str:
        x, y, z = self.place
        return f"{self.mass!r}kg@{x!r},{y!r},{z!r}"


class Disturbances(Config):
    """All that is not as the plan takes it. By default nothing is."""

    pushes: tuple[Push, ...] = ()
    """Forces on the base link."""
    payload: Payload | None = None
    """A mass on the base link."""
    friction: Positive = 0.8
    """μ between feet and ground."""
    radius_error: RadiusError = 0.0
    """By how much the true wheels are larger than the known ones, as a share: 0.01 is 1 %."""
    latency: Latency = 0.0
    """Age of what the controller knows of the joints and the base, and of what it sends, s. The drives'
    own damping is not delayed."""
    slope_deg: Slope = 0.0
    """By how much the ground rises along x, degrees. The world frame lies in the ground."""

    def check_begins(self, end: float) -> None:
        """Raises `InputError` for a push that begins after a run has ended, at `end`, s."""
        for push in self.pushes:
            check_begins(push.start, end, str(push))


_UNITS: Final = {
    "latency": {"ms": 1e-3, "s": 1.0, "": 1.0},
    "radius-error": {"%": 1e-2, "": 1.0},
    "slope": {"deg": 1.0, "": 1.0},
    "friction": {"": 1.0},
}
_EXAMPLES: Final = {"latency": "3ms", "radius-error": "1%", "slope": "2deg", "friction": "0.6"}


def parse_quantity(field: str, text: str) -> float:
    """A number with an optional unit: `3ms`, `1%`, `2deg`. In SI units, slopes in degrees.

    Raises:
        InputError: it is no number, or has another unit.
    """
    found = re.fullmatch(rf"({_NUMBER})\s*([a-z%]*)", text.strip())
    units = _UNITS[field]
    if found is None or found[2] not in units:
        rule = (
            f"must be a number{' with an optional unit' if len(units) > 1 else ''}, e.g. {_EXAMPLES[field]}"
        )
        raise InputError(field, text, rule, [unit for unit in units if unit])
    return float(found[1]) * units[found[2]]
