"""The four legs of a URDF that no one has described: found by chains, symmetry and axes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rollgait.errors import MISSING, InputError, shown
from rollgait.robot.robot import LEG_NAMES, LegName
from rollgait.robot.urdf_build import build_model
from rollgait.robot.urdf_files import Joint, Urdf

Array = NDArray[np.float64]

ALONG: Final = 0.9
"""Cosine above which two directions count as the same."""

UPRIGHT: Final = 0.7
"""Cosine above which the joint above a wheel points to the joint above it, and so steers."""

RANGE_MIN: Final = 4.0 * np.pi
"""Range of a joint from which on it can be that of a wheel, rad."""

BALANCED: Final = 0.2
"""Largest distance of a wheel's centre of mass from its axle, as a share of the length of the link above."""

CANDIDATES_MAX: Final = 16
"""Ends of chains of which four are chosen; of more, those that hang lowest."""

SYMMETRIC: Final = 0.1
"""By how much a leg may miss the mirror image of the other, as a share of the distance between the legs."""


@dataclass(frozen=True)
class LegFound:
    """A leg as the URDF has it.

    Attributes:
        chain: its turning joints from the base down.
        frame: of its wheel or foot.
        wheel_joint: the last of the chain; None for a point foot.
        steering_joint: the one above it, if it steers.
    """

    chain: tuple[Joint, ...]
    frame: str
    wheel_joint: str | None
    steering_joint: str | None

    def described(self) -> dict[str, str]:
        """As the file of the legs has it."""
        if self.wheel_joint is None:
            return {"foot": self.frame}
        steering = {} if self.steering_joint is None else {"steering_joint": self.steering_joint}
        return {"wheel": self.frame, "wheel_joint": self.wheel_joint, **steering}


def find_legs(urdf: Urdf) -> dict[LegName, LegFound]:
    """The four legs of a robot whose base has x forward, y left and z up.

    Raises:
        InputError: there are no four chains of turning joints that mirror each other left and right.
    """
    tree = _Tree(urdf)
    ends = [joint for joint in urdf.joints.values() if tree.is_end(joint)]
    candidates = [chain for joint in ends if (chain := tree.leg_chain(joint)) is not None]
    candidates = sorted(candidates, key=lambda chain: tree.lowest(chain))[:CANDIDATES_MAX]
    best: tuple[float, tuple[tuple[Joint, ...], ...]] | None = None
    for four in combinations(candidates, len(LEG_NAMES)):
        ordered = tree.in_order(four)
        if ordered is None:
            continue
        cost = tree.lowest_of(ordered)
        if best is None or cost < best[0] - 1e-9:
            best = (cost, ordered)
    if best is None:
        ends_named = ", ".join(shown(joint.child) for joint in ends[:8]) or "none"
        rule = "must be named in a file (option --legs): there are no four chains of turning joints that"
        chains = f"mirror each other left and right among those that end in {ends_named}"
        raise InputError("legs", MISSING, f"{rule} {chains}")
    tree.check_forward(best[1])
    wheeled = all(tree.is_wheel(chain) for chain in best[1])
    return {name: tree.leg(chain, wheeled) for name, chain in zip(LEG_NAMES, best[1], strict=True)}


class _Tree:
    """The robot with all joints at 0, base at the origin."""

    def __init__(self, urdf: Urdf) -> None:
        self.urdf = urdf
        self.model: Any = build_model(urdf)
        self.data: Any = self.model.createData()
        q = pin.neutral(self.model)
        pin.framesForwardKinematics(self.model, self.data, q)
        pin.computeJointJacobians(self.model, self.data, q)

    def is_end(self, joint: Joint) -> bool:
        """Whether a joint turns and nothing below it moves."""
        waiting = [joint.child]
        while waiting:
            for below in self.urdf.children_of(waiting.pop()):
                if below.kind != "fixed":
                    return False
                waiting.append(below.child)
        return joint.kind == "revolute"

    def leg_chain(self, end: Joint) -> tuple[Joint, ...] | None:
        """The joints of a chain that could be a leg: two or more, all turning by themselves."""
        chain = [joint for joint in self.urdf.chain(end.child) if joint.kind != "fixed"]
        alone = all(joint.kind == "revolute" and joint.mimics is None for joint in chain)
        return tuple(chain) if alone and len(chain) >= 2 else None

    def origin(self, joint: Joint) -> Array:
        return np.array(self.data.oMi[self.model.getJointId(joint.name)].translation)

    def axis(self, joint: Joint) -> Array:
        return np.array(self.data.J[3:, self.model.joints[self.model.getJointId(joint.name)].idx_v])

    def place(self, link: str) -> Array:
        return np.array(self.data.oMf[self.model.getBodyId(link)].translation)

    def lowest(self, chain: tuple[Joint, ...]) -> float:
        """Height of the lowest joint or frame of a chain, m."""
        ends = [self.place(link)[2] for link in self.end_links(chain)]
        return float(min([*(self.origin(joint)[2] for joint in chain), *ends]))

    def lowest_of(self, chains: tuple[tuple[Joint, ...], ...]) -> float:
        return float(np.mean([self.lowest(chain) for chain in chains]))

    def end_links(self, chain: tuple[Joint, ...]) -> list[str]:
        """The last link of a chain and what is welded to it below."""
        links = [chain[-1].child]
        for link in links:
            links += [joint.child for joint in self.urdf.children_of(link)]
        return links

    def in_order(self, four: tuple[tuple[Joint, ...], ...]) -> tuple[tuple[Joint, ...], ...] | None:
        """Four chains as FL, FR, HL, HR; None if they share joints or do not mirror each other."""
        names = [joint.name for chain in four for joint in chain]
        if len(set(names)) < len(names) or len({len(chain) for chain in four}) > 1:
            return None
        hips = np.array([np.mean([self.origin(joint) for joint in chain], axis=0) for chain in four])
        order = sorted(range(len(four)), key=lambda i: -hips[i, 0])
        front, hind = (sorted(pair, key=lambda i: -hips[i, 1]) for pair in (order[:2], order[2:]))
        size = float(np.ptp(hips[:, :2], axis=0).max())
        if hips[front, 0].min() - hips[hind, 0].max() < SYMMETRIC * size:
            return None
        for left, right in (front, hind):
            mirrored = hips[right] * [1.0, -1.0, 1.0]
            if hips[left, 1] <= 0.0 or np.abs(hips[left] - mirrored).max() > SYMMETRIC * size:
                return None
        first, *rest = [np.abs([self.axis(joint) for joint in four[i]]) for i in (*front, *hind)]
        if any(np.abs(first - other).max() > SYMMETRIC for other in rest):
            return None
        return tuple(four[i] for i in (*front, *hind))

    def check_forward(self, chains: tuple[tuple[Joint, ...], ...]) -> None:
        """Raises `InputError` if the legs swing to the side: the base then has its y axis forward."""
        axes = np.abs([self.axis(joint) for chain in chains for joint in chain]).mean(axis=0)
        if axes[0] > axes[1]:
            rule = "must be a link with x forward, y left and z up: its legs swing about its x axis"
            raise InputError("base", self.urdf.root_link, rule)

    def is_wheel(self, chain: tuple[Joint, ...]) -> bool:
        """Whether the last joint of a chain turns all around, about an axis to the side, what is balanced."""
        limit = self.urdf.joint_elements[chain[-1].name].find("limit")
        low, high = (0.0, 0.0) if limit is None else (float(limit.get(k, "0")) for k in ("lower", "upper"))
        free = high - low >= RANGE_MIN or low == high == 0.0
        if not free or len(chain) < 3 or abs(float(self.axis(chain[-1])[1])) < ALONG:
            return False
        joint = self.model.getJointId(chain[-1].name)
        lever = self.data.oMi[joint].rotation @ self.model.inertias[joint].lever
        off_axle = np.linalg.norm(np.cross(lever, self.axis(chain[-1])))
        return bool(off_axle < BALANCED * np.linalg.norm(self.origin(chain[-1]) - self.origin(chain[-2])))

    def leg(self, chain: tuple[Joint, ...], wheeled: bool) -> LegFound:
        if not wheeled:
            return LegFound(chain, self._foot(chain), None, None)
        wheel, above = chain[-1], chain[-2]
        steers = False
        if len(chain) >= 4:
            way = self.origin(chain[-3]) - self.origin(wheel)
            along = abs(float(self.axis(above) @ way)) / max(float(np.linalg.norm(way)), 1e-9)
            steers = abs(float(self.axis(above) @ self.axis(wheel))) < 1.0 - ALONG and (
                along > UPRIGHT or abs(float(self.axis(above)[2])) > ALONG
            )
        return LegFound(chain, wheel.child, wheel.name, above.name if steers else None)

    def _foot(self, chain: tuple[Joint, ...]) -> str:
        """The link at the end of a leg that is farthest from its last joint."""
        knee = self.origin(chain[-1])
        links = self.end_links(chain)
        return max(links, key=lambda link: round(float(np.linalg.norm(self.place(link) - knee)), 4))
