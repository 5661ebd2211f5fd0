"""Legs of a hip that rolls and pitches and of a knee, as most quadrupeds have them: in closed form.

With the roll φ the leg's plane stands at the distance d beside the hip roll axis; n = (0, cos φ, sin φ) is
its normal and m = (0, sin φ, −cos φ) points down in it. A place (X, Y, Z) from that axis is in the plane
where (Y, Z) = d n + h m, so h² = Y² + Z² − d². In the plane thigh and shank are two sides of a triangle. A
wheel's rim is lowest straight below its centre in the plane, a ball straight below its centre in the world.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.robot.urdf_stance import Stance

Array = NDArray[np.float64]

STRAIGHT: Final = 1e-3
"""Sine of the angle by which axes may differ and still count as parallel or level."""

SLACK: Final = 1e-9
"""What counts as 0, m or rad."""


@dataclass(frozen=True)
class HipLeg:
    """Such a leg; the base stands at the origin of the world, and angles count from those of a stance.

    Attributes:
        rolls: whether it has a hip roll joint; else the plane is upright and stays where it is.
        axis: y and z of the hip roll axis, m.
        sideways: d, signed distance of the plane from that axis, positive to the left, m.
        hip: x of the hip pitch axis, and how far below the roll axis it is in the plane, m.
        upper, lower: lengths of thigh and shank, m.
        radius: of the wheel or ball, m.
        wheel: whether it is a wheel.
        bend: 1 or -1, to which side the knee is bent.
        zero: roll, direction of the thigh, and bend of the knee where the joints' angles are `angles`, rad.
        signs: of the joints' axes against those of the three, (3,).
        angles: of the joints, (2 or 3,), rad.
        low, high: their limits, (2 or 3,), rad.
    """

    rolls: bool
    axis: Array
    sideways: float
    hip: Array
    upper: float
    lower: float
    radius: float
    wheel: bool
    bend: float
    zero: Array
    signs: Array
    angles: Array
    low: Array
    high: Array

    def joint_angles(self, places: Array) -> Array:
        """The joints' angles that put the contact point there, (n, 2 or 3), rad; NaN where none do.

        Args:
            places: of the contact point, (n, 3), m.
        """
        lift = 0.0 if self.wheel else self.radius
        y, z = places[:, 1] - self.axis[0], places[:, 2] - self.axis[1] + lift
        if self.rolls:
            square = y**2 + z**2 - self.sideways**2
            down = np.sqrt(np.where(square > 0.0, square, np.nan))
            roll = np.arctan2(z, y) - np.arctan2(-down, self.sideways)
        else:
            down = np.where(np.abs(y - self.sideways) < SLACK, -z, np.nan)
            roll = np.zeros(len(places))
        if self.wheel:
            down = down - self.radius
        across, up = places[:, 0] - self.hip[0], self.hip[1] - down
        reach = np.hypot(across, up)
        knee = self.bend * _angle(
            (reach**2 - self.upper**2 - self.lower**2) / (2.0 * self.upper * self.lower)
        )
        inner = (self.upper**2 + reach**2 - self.lower**2) / (2.0 * self.upper * np.maximum(reach, SLACK))
        thigh = np.arctan2(across, up) - self.bend * _angle(inner)
        turned = np.column_stack([roll, thigh, knee]) - self.zero
        turned = np.arctan2(np.sin(turned), np.cos(turned)) * self.signs
        return np.asarray(self.angles + turned[:, 0 if self.rolls else 1 :])

    def reaches(self, places: Array) -> NDArray[np.bool_]:
        """Whether the contact point gets there within the joints' limits, (n,); places as above."""
        angles = self.joint_angles(places)
        return np.asarray(((angles >= self.low - SLACK) & (angles <= self.high + SLACK)).all(axis=1))


def hip_legs(model: WholeBodyModel, stance: Stance) -> tuple[HipLeg, ...] | None:
    """The four legs at their stance; None if one is of another kind."""
    legs = [_hip_leg(model, stance, leg) for leg in range(len(model.legs))]
    known = tuple(leg for leg in legs if leg is not None)
    return known if len(known) == len(legs) else None


def _hip_leg(model: WholeBodyModel, stance: Stance, leg: int) -> HipLeg | None:
    chain = model.legs[leg]
    if chain.steering is not None or len(chain.joints) not in (2, 3):
        return None
    axes, origins = model.joint_axes(stance.q, chain)
    rolls = len(chain.joints) == 3
    pitch, knee = axes[-2:]
    left = pitch * np.sign(pitch[1])
    if abs(left[0]) > STRAIGHT or np.linalg.norm(np.cross(pitch, knee)) > STRAIGHT:
        return None
    if np.hypot(*axes[0][1:]) > STRAIGHT if rolls else abs(left[2]) > STRAIGHT:
        return None
    down = np.array([0.0, left[2], -left[1]])
    wheel = chain.wheel is not None
    contact = stance.state.p_foot[leg]
    centre = contact - chain.radius * (down if wheel else np.array([0.0, 0.0, -1.0]))
    hip, shank = origins[-2], origins[-1]
    axis = origins[0] if rolls else hip
    thigh_way, shank_way = _in_plane(shank - hip, down), _in_plane(centre - shank, down)
    if down @ (centre - axis) <= 0.0:
        return None
    thigh = float(np.arctan2(*thigh_way))
    bend = float(np.arctan2(*shank_way)) - thigh
    bend = float(np.arctan2(np.sin(bend), np.cos(bend)))
    places = np.array(chain.joints) - BASE_V
    signs = np.sign([axes[0][0] if rolls else 1.0, pitch @ left, knee @ left])
    return HipLeg(
        rolls=rolls,
        axis=np.array(axis[1:]),
        sideways=float(left @ (centre - axis)),
        hip=np.array([hip[0], down @ (hip - axis)]),
        upper=float(np.hypot(*thigh_way)),
        lower=float(np.hypot(*shank_way)),
        radius=chain.radius,
        wheel=wheel,
        bend=1.0 if bend >= 0.0 else -1.0,
        zero=np.array([np.arctan2(left[2], left[1]), thigh, bend]),
        signs=signs,
        angles=np.array(stance.q[np.array(chain.joints) + 1]),
        low=np.array(model.position_lower[places]),
        high=np.array(model.position_upper[places]),
    )


def _in_plane(way: Array, down: Array) -> tuple[float, float]:
    """Ahead, and upwards in the leg's plane."""
    return float(way[0]), float(-down @ way)


def _angle(cosine: Array) -> Array:
    """Its angle, rad; NaN where it is the cosine of none."""
    return np.asarray(np.arccos(np.where(np.abs(cosine) <= 1.0, cosine, np.nan)))
