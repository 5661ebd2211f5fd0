"""Gaits: which foot is on the ground when. A new gait is one class like those here and its name in `Gait`.

A gait says in continuous time when each foot lifts off and touches down; `schedule.py` puts that on the mesh.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Final, Literal

from pydantic import AfterValidator, Discriminator, Field

from rollgait.config import Config, NonNegative, Number, Positive, Whole
from rollgait.robot.robot import LEG_NAMES, LegName
from rollgait.scenario.patterns import PATTERNS, Wheels
from rollgait.scenario.timing import Timing
from rollgait.scenario.weights import Share, SupportMargin

Swing = tuple[Number, Number]
"""(lift-off, touch-down), s."""
Swings = dict[LegName, tuple[Swing, ...]]
StepCount = Annotated[Whole, Field(ge=1, le=1000)]
SwingFraction = Annotated[Number, Field(gt=0.0, le=1.0)]

PAIR_STEPS: Final = 16
"""Steps of pairs: half a second each in the usual horizon of 10 s."""
PAIR_SWING: Final = 0.6
"""Part of their slots in the air: two feet cannot hold the robot for long."""


def _has_legs(value: tuple[LegName, ...]) -> tuple[LegName, ...]:
    if not value:
        raise ValueError("must name at least one leg")
    if twice := [leg for leg in LEG_NAMES if value.count(leg) > 1]:
        # the order is repeated: a leg in it twice would step more often than others, or twice in a row
        valid = ", ".join(LEG_NAMES)
        raise ValueError(f"must name no leg more than once, and names {twice[0]} twice; valid: {valid}")
    return value


Order = Annotated[tuple[LegName, ...], AfterValidator(_has_legs)]


class BaseGait(Config):
    """What all gaits share."""

    wheels: Wheels = "rolling"
    """`locked`: the feet stand still on the ground, as point feet do (the paper's legged mode)."""
    clearance: Positive | None = None
    """z_fly: height of the foot above the ground in mid-swing, m. Default: 0.08, less for small robots."""
    clearance_over: Positive | None = None
    """The same above an edge, a gap or a bump that it goes over, m. Default: as `clearance`, 0.05 at most."""
    timing: Timing | None = None
    """Whether the times of this gait may change, its order kept (page "Timing"). Default: they are given."""

    def swings(self, horizon: float) -> Swings:
        """Lift-off and touch-down times of each leg within `horizon` (s); ValueError if it does not fit."""
        raise NotImplementedError


class Drive(BaseGait):
    """All feet stay on the ground."""

    kind: Literal["drive"] = "drive"
    """Kind of the gait."""

    def swings(self, horizon: float) -> Swings:
        return dict.fromkeys(LEG_NAMES, ())


class SteppingGait(BaseGait):
    """What gaits of equal steps share: each step has a slot of time, of which the middle part is swing."""

    pause_start: NonNegative = 1.0
    """Time at the beginning with all feet on the ground, s."""
    pause_end: NonNegative = 1.0
    """Time at the end with all feet on the ground, s."""
    steps: StepCount = 8
    """Number of steps in all."""
    swing_fraction: SwingFraction = 0.8
    """Part of a slot in which feet are in the air, in its middle."""

    @property
    def groups(self) -> tuple[tuple[LegName, ...], ...]:
        """The feet of each step, in the order of the steps, repeated as often as needed."""
        raise NotImplementedError

    def swings(self, horizon: float) -> Swings:
        slot = (horizon - self.pause_start - self.pause_end) / self.steps
        if slot <= 0.0:
            raise ValueError(
                f"needs a horizon longer than its two pauses ({self.pause_start} s + {self.pause_end} s), "
                f"not {horizon} s"
            )
        rest = 0.5 * slot * (1.0 - self.swing_fraction)
        result: dict[LegName, tuple[Swing, ...]] = dict.fromkeys(LEG_NAMES, ())
        for step in range(self.steps):
            begin = self.pause_start + step * slot
            for leg in self.groups[step % len(self.groups)]:
                result[leg] = (*result[leg], (begin + rest, begin + slot - rest))
        return result


class Crawl(SteppingGait):
    """One foot at a time."""

    kind: Literal["crawl"] = "crawl"
    """Kind of the gait."""
    order: Order = PATTERNS["crawl"].order
    """Order in which the feet step, repeated as often as needed."""

    @property
    def groups(self) -> tuple[tuple[LegName, ...], ...]:
        return tuple((leg,) for leg in self.order)


class Walk(SteppingGait):
    """One foot at a time, the wheels locked: the paper's legged mode."""

    kind: Literal["walk"] = "walk"
    """Kind of the gait."""
    wheels: Wheels = PATTERNS["walk"].wheels
    """`locked`: the feet stand still on the ground, as point feet do; `rolling` would be a crawl."""
    order: Order = PATTERNS["walk"].order
    """Order in which the feet step, repeated as often as needed."""

    @property
    def groups(self) -> tuple[tuple[LegName, ...], ...]:
        return tuple((leg,) for leg in self.order)


class Trot(SteppingGait):
    """Diagonal pairs in turn: FL and HR, then FR and HL."""

    kind: Literal["trot"] = "trot"
    """Kind of the gait."""
    steps: StepCount = PAIR_STEPS
    """Number of steps of both pairs together."""
    swing_fraction: SwingFraction = PAIR_SWING
    """Part of a slot in which a pair is in the air, in its middle."""

    @property
    def groups(self) -> tuple[tuple[LegName, ...], ...]:
        return PATTERNS["trot"].groups


class Pace(SteppingGait):
    """Pairs of one side in turn: FL and HL, then FR and HR."""

    kind: Literal["pace"] = "pace"
    """Kind of the gait."""
    steps: StepCount = PAIR_STEPS
    """Number of steps of both pairs together."""
    swing_fraction: SwingFraction = PAIR_SWING
    """Part of a slot in which a pair is in the air, in its middle."""

    @property
    def groups(self) -> tuple[tuple[LegName, ...], ...]:
        return PATTERNS["pace"].groups


def _checked_swings(value: tuple[Swing, ...]) -> tuple[Swing, ...]:
    for begin, end in value:
        if not begin < end:
            raise ValueError(f"must lift off before it touches down, not [{begin}, {end}]")
        if end <= 0.0:
            raise ValueError(f"must touch down after t = 0, not [{begin}, {end}]")
    for (_, end), (begin, _) in pairwise(value):
        if begin < end:
            raise ValueError(
                f"must name swings in order and apart: one ends at {end} s, the next begins at {begin} s"
            )
    return value


def _checked_nodes(value: tuple[float, ...]) -> tuple[float, ...]:
    if len(value) < 2 or value[0] != 0.0 or any(b <= a for a, b in pairwise(value)):
        raise ValueError("must name at least two times, rising from 0")
    return value


class Schedule(BaseGait):
    """Any contact schedule, spelled out: for each leg the lift-off and touch-down times."""

    kind: Literal["schedule"] = "schedule"
    """Kind of the gait."""
    FL: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the front left foot, [[lift-off, touch-down], …], s; lift-off < 0: it has begun."""
    FR: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the front right foot, s."""
    HL: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the hind left foot, s."""
    HR: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the hind right foot, s."""
    nodes: Annotated[tuple[NonNegative, ...], AfterValidator(_checked_nodes)] | None = None
    """Times of the nodes, from 0 to the horizon, s, in place of equal intervals. Default: equal ones."""

    def swings(self, horizon: float) -> Swings:
        return {"FL": self.FL, "FR": self.FR, "HL": self.HL, "HR": self.HR}


class Search(Config):
    """How much work discovering a gait may take."""

    candidates: StepCount = 12
    """How many gaits are planned at most: so much work, the same plan for the same input."""
    seconds: Positive = 10.0
    """After which no further gait is tried, s of wall time; the message says so."""


class Reserves(Config):
    """What is kept back for a robot that does not do exactly what was planned: bounds of what is discovered.

    A bound that the scenario itself gives counts instead.
    """

    friction_share: Share = 0.8
    """Part of the ground's μ that is planned with."""
    reach: NonNegative = 0.01
    """By how much legs stay shorter than their longest and longer than their shortest, m."""
    com_margin: SupportMargin = 0.01
    """How far inside the feet that stand the CoM stays while one of four swings, m."""
    capture_margin: SupportMargin = -0.03
    """The same for the capture point, m."""


class Discover(BaseGait):
    """The gait is found from ground, start and goal; `horizon` is the longest allowed."""

    kind: Literal["discover"] = "discover"
    """Kind of the gait."""
    search: Search = Search()
    """How much work it may take."""
    reserves: Reserves = Reserves()
    """What is kept back."""

    def swings(self, horizon: float) -> Swings:
        """None: those that are found are those of another gait."""
        return dict.fromkeys(LEG_NAMES, ())


Gait = Annotated[Drive | Crawl | Walk | Trot | Pace | Schedule | Discover, Discriminator("kind")]
"""One of the gaits, told apart by `kind`."""

GAITS: Final = (Drive, Crawl, Walk, Trot, Pace, Schedule, Discover)
GAIT_KINDS: Final = tuple(str(gait.model_fields["kind"].default) for gait in GAITS)
