"""The ground under a foot during an interval, as eight numbers, and where a round foot touches it.

    z = h0 + g · d + ½ dᵀ H d    with d = (x, y) − ref

is the surface of the lowest point of the rim (for a point foot: of its ball). On a slope the wheel touches
the ground beside that point: with n the normal there the contact is p + R (e_z − n).

All functions take the module that does the arithmetic, `xp`: casadi for expressions, numpy for numbers. A
vector is a list of its components, each an expression or an array over many intervals at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

Scalar = Any
"""A CasADi expression, a number, or a NumPy array."""
Vector = Any
"""Its components: a list of them, or an array whose first axis they are."""

MODEL_SIZE: Final = 8
"""Numbers of a local model: ref (2), h0, g (2), Hxx, Hxy, Hyy."""


@dataclass(frozen=True)
class FootGround:
    """The ground under one foot.

    Attributes:
        model: ref (2), h0, g (2), Hxx, Hxy, Hyy of the surface: m, –, 1/m.
        contact_slope: gradient of the surface where the foot touches it, 2; zeros where it does not.
        radius: R of the wheel or of the ball of the foot, m.
    """

    model: Vector
    contact_slope: Vector
    radius: Scalar

    def height(self, p: Vector) -> Scalar:
        """z of the surface over a place (x, y), m."""
        x, y = p[0] - self.model[0], p[1] - self.model[1]
        h0, gx, gy, xx, xy, yy = self.model[2:]
        return h0 + (gx + 0.5 * xx * x + xy * y) * x + (gy + 0.5 * yy * y) * y

    def slope(self, p: Vector) -> list[Scalar]:
        """Gradient of the surface at a place (x, y)."""
        x, y = p[0] - self.model[0], p[1] - self.model[1]
        _, gx, gy, xx, xy, yy = self.model[2:]
        return [gx + xx * x + xy * y, gy + xy * x + yy * y]

    def normal(self, xp: Any) -> list[Scalar]:
        """Unit normal at the contact, upwards, 3."""
        gx, gy = self.contact_slope
        length = xp.sqrt(1.0 + gx * gx + gy * gy)
        return [-gx / length, -gy / length, 1.0 / length]

    def contact_offset(self, xp: Any) -> list[Scalar]:
        """From the lowest point of the rim to the contact, R (e_z − n), 3, m."""
        n = self.normal(xp)
        return [-self.radius * n[0], -self.radius * n[1], self.radius * (1.0 - n[2])]

    def rolling_frame(self, xp: Any, heading: Scalar) -> list[list[Scalar]]:
        """Unit vectors along the surface in the direction of a heading, to its left, and n: rows of 3."""
        c, s = xp.cos(heading), xp.sin(heading)
        climb = self.contact_slope[0] * c + self.contact_slope[1] * s
        length = xp.sqrt(1.0 + climb * climb)
        along, n = [c / length, s / length, climb / length], self.normal(xp)
        left = [
            n[1] * along[2] - n[2] * along[1],
            n[2] * along[0] - n[0] * along[2],
            n[0] * along[1] - n[1] * along[0],
        ]
        return [along, left, n]

    def way_factor(self, xp: Any, heading: Scalar) -> Scalar:
        """Way along the surface over way in the plane, in the direction of a heading, √(1 + (g · e)²)."""
        climb = self.contact_slope[0] * xp.cos(heading) + self.contact_slope[1] * xp.sin(heading)
        return xp.sqrt(1.0 + climb * climb)
