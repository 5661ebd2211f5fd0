"""Quadrupeds of primitives, with the features of robots that people own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

SIDES = {"FL": (1, 1), "FR": (1, -1), "HL": (-1, 1), "HR": (-1, -1)}
"""Ahead or behind, left or right, of each leg."""

FOREIGN = {"FL": "bein_vl", "FR": "bein_vr", "HL": "bein_hl", "HR": "bein_hr"}


@dataclass(frozen=True)
class Lookalike:
    """What distinguishes a robot.

    Attributes:
        name: of the robot.
        foot: steerable, fixed or point.
        hip_roll: whether a joint swings each leg to the side.
        scale: size against a robot of 0.3 m thighs.
        at_joint: the wheel's frame is at its joint and its cylinder beside it, or the foot is a ball in the
            shank, whose frame is at the knee.
        meshes: visuals are meshes of which there are no files.
        foreign: joints and links have names that say nothing.
        knee_limited: the knees bend one way only.
        hip_pitch: limits of the hips' pitch joints, rad.
        arm: an arm of three joints on the back.
        drives_known: whether the joints have limits of speed and torque.
    """

    name: str
    foot: Literal["steerable", "fixed", "point"]
    hip_roll: bool = True
    scale: float = 1.0
    at_joint: bool = False
    meshes: bool = False
    foreign: bool = False
    knee_limited: bool = False
    hip_pitch: tuple[float, float] = (-2.2, 2.2)
    arm: bool = False
    drives_known: bool = True

    @property
    def radius(self) -> float:
        """Of the wheel or the ball, m."""
        return self.scale * (0.03 if self.foot == "point" else 0.1)

    @property
    def offset(self) -> float:
        """From the wheel's joint to the middle of the wheel, m."""
        return 0.06 * self.scale if self.at_joint and self.foot != "point" else 0.0

    @property
    def half_track(self) -> float:
        """From the middle of the robot to the middle of a wheel or ball below its hip, m."""
        return 0.22 * self.scale + self.offset

    @property
    def mass(self) -> float:
        """Of all links, kg."""
        legs = 1.2 * self.hip_roll + 2.0 + 0.8
        if self.foot != "point":
            legs += 1.0
        if self.foot == "steerable":
            legs += 0.5
        return self.scale**3 * (20.0 + 4.0 * legs + (1.5 if self.arm else 0.0))

    def urdf(self) -> str:
        """The robot as URDF."""
        s = self.scale
        parts = [self._link("trunk", 20.0, (0.6, 0.24, 0.2), box=(0.7, 0.3, 0.2)), '<link name="camera"/>']
        parts.append('<joint name="glue" type="fixed"><parent link="trunk"/><child link="camera"/></joint>')
        for leg in SIDES:
            parts += self._leg(leg)
        if self.arm:
            above = "trunk"
            for k, axis in enumerate(("0 0 1", "0 1 0", "0 1 0")):
                place = (0.2 * s, 0.0, 0.12 * s) if k == 0 else (0.15 * s, 0.0, 0.0)
                parts.append(self._joint(f"arm_{k}", above, f"arm_link_{k}", place, axis, (-1.5, 1.5)))
                parts.append(self._link(f"arm_link_{k}", 0.5, (0.15, 0.05, 0.05)))
                above = f"arm_link_{k}"
        return f'<robot name="{self.name}">\n' + "\n".join(parts) + "\n</robot>\n"

    def _leg(self, leg: str) -> list[str]:
        ahead, left = SIDES[leg]
        s = self.scale
        prefix = FOREIGN[leg] if self.foreign else leg
        link = {part: f"{prefix}_{part}" for part in ("hip", "thigh", "shank", "ankle", "wheel", "foot")}
        parts, above, place = [], "trunk", (0.3 * ahead * s, 0.12 * left * s, 0.0)
        if self.hip_roll:
            parts.append(self._joint(f"{prefix}_j1", above, link["hip"], place, "1 0 0", (-0.7, 0.7)))
            parts.append(self._link(link["hip"], 1.2, (0.1, 0.1, 0.1)))
            above, place = link["hip"], (0.0, 0.1 * left * s, 0.0)
        else:
            place = (place[0], 0.22 * left * s, 0.0)
        parts.append(self._joint(f"{prefix}_j2", above, link["thigh"], place, "0 1 0", self.hip_pitch))
        parts.append(self._link(link["thigh"], 2.0, (0.05, 0.05, 0.3), down=0.15))
        knee = (-2.6, -0.3) if self.knee_limited else (-2.6, 2.6)
        down = (0.0, 0.0, -0.3 * s)
        parts.append(self._joint(f"{prefix}_j3", link["thigh"], link["shank"], down, "0 1 0", knee))
        ball = f'<collision><origin xyz="0 0 {-0.3 * s}"/>{self._sphere()}</collision>'
        own_ball = ball if self.foot == "point" and self.at_joint else ""
        parts.append(self._link(link["shank"], 0.8, (0.04, 0.04, 0.3), down=0.15, more=own_ball))
        if self.foot == "point":
            if not self.at_joint:
                parts.append(f'<link name="{link["foot"]}"><collision>{self._sphere()}</collision></link>')
                parts.append(
                    f'<joint name="{prefix}_end" type="fixed"><parent link="{link["shank"]}"/>'
                    f'<child link="{link["foot"]}"/><origin xyz="0 0 {-0.3 * s}"/></joint>'
                )
            return parts
        above = link["shank"]
        if self.foot == "steerable":
            parts.append(self._joint(f"{prefix}_j4", above, link["ankle"], down, "0 1 0", (-2.0, 2.0)))
            parts.append(self._link(link["ankle"], 0.25, (0.05, 0.05, 0.05)))
            yaw = (0.0, 0.0, -0.05 * s)
            parts.append(
                self._joint(f"{prefix}_j5", link["ankle"], f"{prefix}_fork", yaw, "0 0 1", (-2.5, 2.5))
            )
            parts.append(self._link(f"{prefix}_fork", 0.25, (0.05, 0.05, 0.05)))
            above, down = f"{prefix}_fork", (0.0, 0.0, -0.1 * s)
        parts.append(self._joint(f"{prefix}_j6", above, link["wheel"], down, "0 1 0", None))
        tyre = (
            f'<collision><origin xyz="0 {left * self.offset} 0" rpy="{math.pi / 2} 0 0"/>'
            f'<geometry><cylinder radius="{self.radius}" length="{0.05 * s}"/></geometry></collision>'
        )
        parts.append(self._link(link["wheel"], 1.0, (0.14, 0.05, 0.14), more=tyre))
        return parts

    def _sphere(self) -> str:
        return f'<geometry><sphere radius="{self.radius}"/></geometry>'

    def _link(
        self,
        name: str,
        mass: float,
        size: tuple[float, float, float],
        *,
        down: float = 0.0,
        box: tuple[float, float, float] | None = None,
        more: str = "",
    ) -> str:
        """A link with the inertia of a box of this size (m) and mass (kg), both before scaling."""
        m = mass * self.scale**3
        xx, yy, zz = ((a * self.scale) ** 2 for a in size)
        inertia = " ".join(
            f'{key}="{value:.9g}"'
            for key, value in {
                "ixx": m * (yy + zz) / 12.0,
                "iyy": m * (xx + zz) / 12.0,
                "izz": m * (xx + yy) / 12.0,
                "ixy": 0.0,
                "ixz": 0.0,
                "iyz": 0.0,
            }.items()
        )
        shape = ""
        if self.meshes:
            shape = f'<visual><geometry><mesh filename="package://none/{name}.dae"/></geometry></visual>'
        if box is not None:
            sides = " ".join(str(a * self.scale) for a in box)
            shape += f'<collision><geometry><box size="{sides}"/></geometry></collision>'
        return (
            f'<link name="{name}"><inertial><origin xyz="0 0 {-down * self.scale}"/><mass value="{m:.9g}"/>'
            f"<inertia {inertia}/></inertial>{shape}{more}</link>"
        )

    def _joint(
        self,
        name: str,
        parent: str,
        child: str,
        place: tuple[float, float, float],
        axis: str,
        limits: tuple[float, float] | None,
    ) -> str:
        """A turning joint; one without limits turns all around."""
        kind = "continuous" if limits is None else "revolute"
        effort, speed = (80.0 * self.scale**4, 20.0) if self.drives_known else (0.0, 0.0)
        ends = "" if limits is None else f'lower="{limits[0]}" upper="{limits[1]}" '
        where = " ".join(f"{value:.9g}" for value in place)
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{where}"/><axis xyz="{axis}"/>'
            f'<limit {ends}effort="{effort:.4g}" velocity="{speed:g}"/></joint>'
        )


LOOKALIKES = {
    look.name: look
    for look in (
        Lookalike("fixed-plain", "fixed"),
        Lookalike("fixed-at-joint", "fixed", at_joint=True, scale=0.7, knee_limited=True),
        Lookalike("fixed-foreign", "fixed", foreign=True, meshes=True, arm=True),
        Lookalike("fixed-planar", "fixed", hip_roll=False),
        Lookalike("fixed-one-way", "fixed", hip_pitch=(-2.2, 0.8), knee_limited=True),
        Lookalike("steerable-plain", "steerable"),
        Lookalike("steerable-at-joint", "steerable", at_joint=True, scale=1.3, foreign=True),
        Lookalike("point-small", "point", scale=0.5, meshes=True, drives_known=False),
        Lookalike("point-at-joint", "point", at_joint=True, foreign=True, knee_limited=True, arm=True),
    )
}
