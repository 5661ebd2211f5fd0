"""How far the feet reach and the wheels steer about the nominal stance, and the limb behind a wheel."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.robot import LEG_NAMES, Limb
from rollgait.robot.urdf_hip_legs import STRAIGHT, hip_legs
from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel
from rollgait.robot.urdf_stance import FRONT, LEFT, Stance, reach
from rollgait.robot.whole_body import Choices

Array = NDArray[np.float64]

BOX_SHAPE: Final = np.array([1.0, 1.0, 0.4])
"""Proportions of the reachable box: feet travel farther than they lift."""

GROWING: Final = (2, 0, 1)
"""Order in which the sides of the box are lengthened: lifting a foot is what the proportions spare most."""

PLANAR: Final = 2e-3
"""Half-size of the box along which a leg cannot move, m: what the body may sway when it rolls."""

CORNERS: Final = np.array([c for c in product((-1.0, 0.0, 1.0), repeat=3) if any(c)])
"""Corners, middles of edges and middles of faces of a box of half-size 1."""

BOX_FIRST: Final = 0.2
"""Half-length of the box that is tried first, as a share of the stance's height; from it the sides grow."""

BOX_LARGEST: Final = np.array([0.5, 0.5, 0.2])
"""Half-sizes of the largest box, as shares of the stance's height."""

BOX_STEP: Final = 0.01
"""Steps in which it shrinks, m."""

BOX_TRIES: Final = 30
"""Most steps in which it shrinks: they get longer for robots taller than CENTAURO."""

SIDES_LARGEST: Final = np.array([0.6, 0.3, 0.4])
"""Longest sides of a leg's own box from the nominal place, as shares of the stance's height."""

LIFTED_FIRST: Final = 0.06
"""How high a foot shall get before its box grows to the other sides, as a share of the stance's height."""

SIDE_STEPS: Final = 12
"""Steps in which they grow: 4 cm of CENTAURO's."""

STEP_SHARE: Final = 0.2
"""Where a whole step goes too far a half is tried, and a quarter; nothing below this share."""

FACE: Final = np.array(list(product((-1.0, 0.0, 1.0), repeat=2)))
"""Corners, middles of edges and middle of a face of half-size 1."""

REACHED: Final = 1e-6
"""Error with which a corner of the box counts as reached, m or rad."""

STEERING_GRID: Final = 9
"""Places along each side of the box at which the steering range is looked at."""

RESERVE_FOLDED, RESERVE_STRETCHED = 0.08, 0.14
"""Shares of a leg's length kept free: the base moves about the CoM while the legs step."""


class Workspace:
    """Whether feet reach places about a stance: in closed form where legs are hips and knees, else by IK."""

    def __init__(self, model: WholeBodyModel, stance: Stance) -> None:
        self._model = model
        self._stance = stance
        self._legs = hip_legs(model, stance)
        own = [list(chain.joints) for chain in model.legs]
        sideways = [np.abs(stance.state.J_foot[i][1, joints]).max() for i, joints in enumerate(own)]
        self.is_sideways = bool(min(sideways) > STRAIGHT)
        """Whether every leg has a joint that moves its foot sideways."""
        self.height = float(-stance.feet[:, 2].mean())
        """Of the CoM above the ground, m."""

    def holds(self, offsets: Array, *, together: bool = False) -> NDArray[np.bool_]:
        """Whether each foot gets to all places that are so far from its nominal one, (4,).

        Args:
            offsets: of the places, (n, 4, 3), m.
            together: whether it matters only if all feet do: then it looks no further once one does not.
        """
        held = np.ones(len(LEG_NAMES), dtype=bool)
        if self._legs is not None:
            places = self._stance.state.p_foot + offsets
            return np.array([leg.reaches(places[:, i]).all() for i, leg in enumerate(self._legs)])
        for offset in offsets:
            held &= _reached(self._model, self._stance, offset)[1] < REACHED
            if not (held.all() if together else held.any()):
                break
        return held

    def holds_box(self, half: Array) -> bool:
        """Whether all feet reach all of a box of these half-sizes, (3,), m."""
        offsets = np.repeat((CORNERS * half)[:, None], len(LEG_NAMES), axis=1)
        return bool(self.holds(offsets, together=True).all())


def reachable_box(model: WholeBodyModel, stance: Stance) -> Array | None:
    """Half-sizes of a large box, (3,), m, whose corners, edges and faces every foot reaches upright.

    Begins with the largest one of the usual proportions and lengthens one side after the other, as what stops
    one direction need not stop the others. None if not even the smallest is reachable.
    """
    space = Workspace(model, stance)
    sideways, height = space.is_sideways, space.height
    shape = BOX_SHAPE if sideways else BOX_SHAPE * [1.0, 0.0, 1.0]
    first, largest = BOX_FIRST * height, BOX_LARGEST * height
    step = min(max(BOX_STEP, first / BOX_TRIES), first)
    for half in np.arange(np.floor(first / step), 0.0, -1.0) * step:
        size = half * shape
        if space.holds_box(size):
            break
    else:
        least = np.full(3, PLANAR)  # feet that stand at the end of their reach on one side
        return least if space.holds_box(least * (shape > 0.0)) else None
    for axis in GROWING if sideways else GROWING[:2]:
        while size[axis] + step <= largest[axis]:
            longer = size.copy()
            longer[axis] += step
            if not space.holds_box(longer):
                break
            size = longer
    return np.asarray(np.maximum(np.round(size, 3), PLANAR))


def foot_boxes(model: WholeBodyModel, stance: Stance) -> Array:
    """A box of its own for each foot, (4, 2, 3), m: smallest and largest offset from the nominal place.

    Lifts the foot and then lets each side grow as long as the legs of an axle reach the face that it moves:
    what stops a foot behind need not stop it ahead. Left and right mirror each other.
    """
    space = Workspace(model, stance)
    largest = SIDES_LARGEST * space.height
    step = SIDES_LARGEST * space.height / SIDE_STEPS
    axes = (0, 1, 2) if space.is_sideways else (0, 2)
    sides = np.zeros((len(FRONT), 2, 3))  # of each axle: behind, inside, below; ahead, outside, above
    for lift in np.linspace(0.0, LIFTED_FIRST * space.height, SIDE_STEPS):
        higher = sides.copy()
        higher[:, 1, 2] = lift
        held = _face_is_held(space, higher, 1, 2)
        sides[held] = higher[held]
    steps = np.zeros_like(sides)
    steps[..., list(axes)] = step[list(axes)]
    while steps.any():
        for axis, end in product(axes, range(2)):
            longer = sides.copy()
            longer[:, end, axis] += steps[:, end, axis]
            growing = steps[:, end, axis] > 0.0
            held = _face_is_held(space, longer, end, axis) if growing.any() else growing
            grown = growing & held & (longer[:, end, axis] <= largest[axis])
            sides[grown] = longer[grown]
            steps[growing & ~grown, end, axis] /= 2.0
            steps[steps < STEP_SHARE * step] = 0.0
    boxes = np.empty((len(LEG_NAMES), 2, 3))
    for axle, legs in enumerate(FRONT):
        for leg in legs:
            low, high = -sides[axle, 0], sides[axle, 1].copy()
            if LEFT[leg] < 0.0:
                low[1], high[1] = -high[1], -low[1]
            boxes[leg] = low, high
    boxes = np.trunc(1e3 * boxes) / 1e3
    return np.stack([np.minimum(boxes[:, 0], -PLANAR), np.maximum(boxes[:, 1], PLANAR)], axis=1)


def _face_is_held(space: Workspace, sides: Array, end: int, axis: int) -> NDArray[np.bool_]:
    """Whether the legs of each axle reach a face of their boxes."""
    corners = np.insert(FACE, axis, 2.0 * end - 1.0, axis=1)
    offsets = np.where(corners[:, None] > 0.0, sides[:, 1], sides[:, 0]) * corners[:, None]
    offsets = np.repeat(offsets, len(LEG_NAMES) // len(FRONT), axis=1)
    offsets[..., 1] *= LEFT
    held = space.holds(offsets)
    return np.array([held[list(legs)].all() for legs in FRONT])


def _reached(model: WholeBodyModel, stance: Stance, offset: Array) -> tuple[BodyState, Array]:
    """All feet moved by an offset from the stance, and what each lacks."""
    places = stance.state.p_foot + offset
    return reach(model, stance.q, lambda _: places)


def steering_ranges(model: WholeBodyModel, stance: Stance, box: Array) -> list[tuple[float, float] | None]:
    """For each leg the range of σ − θz that its steering joint allows at every place of the box, rad.

    None for a leg that does not steer. Places that the leg does not reach do not count.
    """
    if not any(chain.steering for chain in model.legs):
        return [None] * len(LEG_NAMES)
    low, high = np.full(len(LEG_NAMES), -np.inf), np.full(len(LEG_NAMES), np.inf)
    side = np.linspace(-1.0, 1.0, STEERING_GRID)
    for x, y in product(side, side):
        state, errors = _reached(model, stance, np.array([x, y, 0.0]) * box)
        for i, chain in enumerate(model.legs):
            if chain.steering is None or errors[i] > REACHED:
                continue
            place = chain.steering - BASE_V
            angle = state.q[chain.steering + 1]
            sign = np.sign(state.J_heading[i, chain.steering])
            limits = sign * (np.array([model.position_lower[place], model.position_upper[place]]) - angle)
            low[i], high[i] = max(low[i], min(limits)), min(high[i], max(limits))
    return [
        None if chain.steering is None else (float(low[i]), float(high[i]))
        for i, chain in enumerate(model.legs)
    ]


@dataclass(frozen=True)
class LimbFound:
    """The limb of a leg, or why it has none that the planner knows."""

    limb: Limb | None
    reason: str = ""


def find_limb(model: WholeBodyModel, stance: Stance, leg: int, choices: Choices) -> LimbFound:
    """The figures of a leg whose joints are yaw, pitch, pitch, pitch, yaw, as CENTAURO's.

    Angles are turned into the convention of `Limb`: hip_yaw = −α, steering = −(σ − θz) − hip_yaw.
    """
    chain = model.legs[leg]
    if chain.steering is None or len(chain.joints) != 5:
        return LimbFound(None, f"{len(chain.joints)} joints, not 5 with a steering one")
    axes, origins = model.joint_axes(stance.q, chain)
    hip, *pitches, steering = axes
    vertical = all(np.hypot(a[0], a[1]) < STRAIGHT for a in (hip, steering))
    parallel = all(np.linalg.norm(np.cross(a, pitches[0])) < STRAIGHT for a in pitches)
    if not vertical or not parallel or abs(pitches[0][2]) > STRAIGHT:
        return LimbFound(None, "its joints are not yaw, pitch, pitch, pitch, yaw")
    yaw_at, hip_at, knee_at, ankle_at = origins[:4]
    contact, com = stance.state.p_foot[leg], stance.state.p_com
    left = pitches[0] * np.sign(pitches[0][1])  # normal of the leg's plane
    forward = np.array([left[1], -left[0], 0.0])
    origin = np.array([yaw_at[0], yaw_at[1], hip_at[2]])
    out = contact - origin
    alpha = np.arctan2(forward[1], forward[0])
    yaw_range = _converted(model, chain.joints[0], stance.q, float(hip[2]), -float(alpha))
    own = -float(stance.state.heading[leg]) + float(alpha)
    steering_range = _converted(model, chain.joints[4], stance.q, float(steering[2]), own)
    upper, lower = np.linalg.norm(knee_at - hip_at), np.linalg.norm(ankle_at - knee_at)
    return LimbFound(
        Limb(
            hip=_rounded(origin - com, 5),
            plane_offset=round(float(out @ left), 5),
            direction=1 if out @ forward > 0.0 else -1,
            ankle_height=round(float(ankle_at[2] - contact[2]), 5),
            extension=choices.extension or _extension(model, chain.joints[2], float(upper), float(lower)),
            radius_min=choices.radius_min or round(max(1.75 * abs(float(out @ left)), 0.1 * float(upper)), 3),
            hip_yaw=yaw_range,
            steering_joint=steering_range,
        )
    )


def _converted(model: WholeBodyModel, v: int, q: Array, up: float, value: float) -> tuple[float, float]:
    """Limits of a joint about a vertical axis, as an angle that falls as the link turns left, `value` now."""
    place = v - BASE_V
    limits = np.array([model.position_lower[place], model.position_upper[place]])
    low, high = sorted(value - np.sign(up) * (limits - q[v + 1]))
    return round(float(low), 4), round(float(high), 4)


def _extension(model: WholeBodyModel, knee: int, upper: float, lower: float) -> tuple[float, float]:
    """From folded, where the knee meets its limit, to stretched, less reserves, m."""
    place = knee - BASE_V
    farthest = min(max(abs(model.position_lower[place]), abs(model.position_upper[place])), np.pi)
    folded = np.sqrt(upper**2 + lower**2 + 2.0 * upper * lower * np.cos(farthest))
    length = upper + lower
    return round(float(folded) + RESERVE_FOLDED * length, 2), round((1.0 - RESERVE_STRETCHED) * length, 2)


def _rounded(vector: Array, digits: int) -> tuple[float, float, float]:
    x, y, z = (round(float(v), digits) for v in vector)
    return x, y, z
