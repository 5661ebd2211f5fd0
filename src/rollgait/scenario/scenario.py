"""What is asked of the robot: start, goal, time, gait, ground, weights and bounds. Frozen data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from rollgait.angles import turned
from rollgait.config import Config, NonNegative, Number, Positive, dump_yaml, load_yaml, set_key, validate
from rollgait.errors import InputError
from rollgait.presented import Shown
from rollgait.robot.library import find_robot
from rollgait.robot.loads import Loads, Wrench
from rollgait.robot.robot import LEG_NAMES, Robot, turn_lever
from rollgait.scenario.begun import check_moving_start
from rollgait.scenario.gait import GAIT_KINDS, GAITS, BaseGait, Discover, Drive, Gait
from rollgait.scenario.library_maps import heights_of_the_library
from rollgait.scenario.profile import (
    CLEARANCE,
    CLEARANCE_OF_HEIGHT,
    CLEARANCE_OVER,
    FORCE_OF_WEIGHT,
    PROFILES,
    WEIGHT_LIGHT,
    ProfileName,
)
from rollgait.scenario.schedule import ContactSchedule, put_on_mesh
from rollgait.scenario.start import Start
from rollgait.scenario.timing import with_price_in_gait
from rollgait.scenario.weights import Bounds, Weights
from rollgait.terrain.ground import Ground
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.terrain import Terrain

STANDING_ROOM: Final = 0.05
"""A foot that stands still may be so far outside its box at a goal, m: goals are missed by a little."""
LONGEST: Final = 120.0
"""s: the horizon of a gait that is to be found, where none is given; a longer motion is several."""


def _named_or_spelled_out(value: Any) -> str:
    return "name" if isinstance(value, str) else "data"


RobotChoice = Annotated[
    Annotated[str, Tag("name")] | Annotated[Robot, Tag("data")], Discriminator(_named_or_spelled_out)
]


class LaterGoal(Config):
    """A goal that takes over at a time."""

    at: NonNegative
    """From when on this is the goal, s."""
    x: Number
    """x of the CoM, m."""
    y: Number = 0.0
    """y of the CoM, m."""
    yaw_deg: Number = 0.0
    """Yaw of the base, degrees; not reduced: 360 is a full turn."""


class Goal(Config):
    """Where the robot is wanted."""

    x: Number
    """x of the CoM, m."""
    y: Number = 0.0
    """y of the CoM, m."""
    yaw_deg: Number = 0.0
    """Yaw of the base, degrees; not reduced: 360 is a full turn."""
    then: tuple[LaterGoal, ...] = ()
    """Goals that take over later, in the order of time."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        times = [later.at for later in self.then]
        if any(b <= a for a, b in pairwise(times)):
            raise ValueError(f"must have the times of its later goals in rising order, not {times}")
        return self


class Scenario(Shown, Config):
    """A motion to be planned. Build it in Python, from a mapping, a YAML file, or the library by name."""

    description: str = ""
    """One line for people."""
    robot: RobotChoice
    """Name of a robot in the library, path of a robot's YAML file, or the robot itself."""
    start: Start = Start()
    """Where the robot stands at t = 0."""
    goal: Goal
    """Where it is wanted; may switch over time."""
    horizon: Positive = 10.0
    """T, s. `{max: 20, price: 10}`: what is best, if a second costs that much (page "Timing"). With the gait
    `discover` the longest allowed; default there: 120."""
    interval: Positive = 0.1
    """h, s; the horizon is cut into round(T / h) equal intervals."""
    profile: ProfileName = "executable"
    """Table of default weights and bounds: `paper` or `executable`."""
    gait: Gait = Field(default_factory=Drive)
    """Which foot is on the ground when."""
    ground: Ground = Ground()
    """What the robot stands on: a plane, parts, a map (page "Terrain"); in Python also a `Terrain`."""
    loads: Loads = Loads()
    """What the robot carries and what pulls at it (page "Loads")."""
    weights: Weights = Weights()
    """Weights of the costs."""
    bounds: Bounds = Bounds()
    """Bounds of the constraints."""

    # -- construction --

    @classmethod
    def from_dict(
        cls, data: Mapping[str, Any], folder: Path | None = None, heights: HeightMap | None = None
    ) -> Scenario:
        """The scenario in a mapping (as a YAML file holds it).

        Args:
            data: the mapping.
            folder: where the file of a map lies; None if there can be none. A map of the library, by its
                digest, need not lie there.
            heights: of the map, in place of its file.

        Raises:
            InputError: the scenario breaks a rule, or names a map and has no folder.
        """
        scenario = validate(cls, data)
        keys = scenario.ground.map
        if heights is None and keys is not None and keys.digest is not None and not keys.lies_in(folder):
            heights = heights_of_the_library(keys.digest)
        ground = scenario.ground
        return scenario._on(ground.read(folder) if heights is None else ground.with_heights(heights))

    @classmethod
    def from_yaml(cls, path: str | Path) -> Scenario:
        """The scenario in a YAML file. Raises `FileError` or `InputError`."""
        return cls.from_dict(load_yaml(Path(path)), Path(path).parent)

    def with_terrain(self, terrain: Terrain) -> Scenario:
        """A copy on another ground. Raises `InputError` if the robot cannot stand there."""
        return self.with_values({"ground": terrain})

    def _on(self, ground: Ground) -> Scenario:
        """A copy on another ground, checked."""
        scenario = self.model_copy(update={"ground": ground})
        scenario.check()
        return scenario

    @model_validator(mode="before")
    @classmethod
    def _horizon_at_a_price(cls, data: Any) -> Any:
        return with_price_in_gait(data) if isinstance(data, Mapping) else data

    @field_validator("ground", mode="before")
    @classmethod
    def _ground_of_terrain(cls, value: Any) -> Any:
        return Ground.of(value) if isinstance(value, Terrain) else value

    @model_validator(mode="before")
    @classmethod
    def _free_horizon(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and "horizon" not in data and _discovers(data.get("gait")):
            return {**data, "horizon": LONGEST}
        return data

    @field_validator("gait", mode="before")
    @classmethod
    def _gait_by_name(cls, value: Any) -> Any:
        if isinstance(value, Mapping) and "kind" not in value:
            raise ValueError(f"must say its kind; valid: {', '.join(GAIT_KINDS)}")
        return {"kind": value} if isinstance(value, str) else value

    def with_values(self, values: Mapping[str, Any]) -> Scenario:
        """A copy with dotted keys set, e.g. `{"goal.x": 1.5, "robot.mass": 90.0}`. Raises `InputError`."""
        scenario = self.edited(values)
        scenario.check()
        return scenario

    def edited(self, values: Mapping[str, Any]) -> Scenario:
        """`with_values` without the rules that need the robot and its ground, see `check`: a draft.

        Raises `InputError` for a key that there is not, or a value out of its range.
        """
        data = self.to_dict()
        is_free = _discovers(self.gait) and self.horizon == LONGEST
        if is_free or "horizon" not in self.model_fields_set:
            del data["horizon"]  # what nobody said follows from the gait
        for key, value in values.items():
            if key in ("gait", "gait.kind") and isinstance(value, str):
                data["gait"] = {"kind": value, **(_asked_of_any(data["gait"]) if "." in key else {})}
                continue
            if key.startswith("robot.") and isinstance(data["robot"], str):
                data["robot"] = find_robot(data["robot"]).model_dump(mode="json")
            set_key(data, key, value)
        scenario = validate(type(self), data)
        return scenario.model_copy(update={"ground": scenario.ground.read_like(self.ground)})

    # -- what follows from it --

    @cached_property
    def body(self) -> Robot:
        """The robot's data with what it carries; with point feet where the gait locks the wheels."""
        robot = find_robot(self.robot) if isinstance(self.robot, str) else self.robot
        robot = robot.with_loads(self.loads)
        return robot.with_feet("point") if self.gait.wheels == "locked" else robot

    @cached_property
    def schedule(self) -> ContactSchedule:
        """The contact schedule on the mesh."""
        return put_on_mesh(self.gait, self.horizon, self.interval)

    @cached_property
    def wrenches(self) -> tuple[Wrench, ...]:
        """What pulls at the base, from node to node of the mesh, as contacts do."""
        nodes = self.schedule.node_times

        def nearest(time: float | None) -> float | None:
            if time is None or time > self.horizon:
                return time
            return float(nodes[np.argmin(np.abs(nodes - time))])

        return tuple(
            wrench.model_copy(update={"start": nearest(wrench.start), "end": nearest(wrench.end)})
            for wrench in self.loads.wrench
        )

    @cached_property
    def terrain(self) -> Terrain:
        """The ground, of a map also what the robot hides where it stands at the start.

        Raises `InputError` if the file of its map was not read: see `from_yaml`.
        """
        terrain = self.ground.terrain()
        if terrain.map is None:
            return terrain
        return terrain.filled_around(self.start.feet(self.body.stance))

    def goal_at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Goal at times (s, shape (n,)): x, y, z of the CoM (m), yaw, pitch, roll (rad); shape (n, 6)."""
        goals: list[tuple[float, Goal | LaterGoal]] = [
            (-np.inf, self.goal),
            *((later.at, later) for later in self.goal.then),
        ]
        begins = np.array([begin for begin, _ in goals])
        poses = np.array([[g.x, g.y, self.height, np.radians(g.yaw_deg), 0.0, 0.0] for _, g in goals])
        return np.asarray(poses[np.searchsorted(begins, times, side="right") - 1])

    @property
    def height(self) -> float:
        """Nominal height of the CoM in the world, m."""
        return self.ground.height + self.body.height

    @property
    def clearance(self) -> float:
        """z_fly of the gait: its own, else CENTAURO's, or what fits a smaller robot, m."""
        fitting = min(CLEARANCE, CLEARANCE_OF_HEIGHT * self.body.height)
        return fitting if self.gait.clearance is None else self.gait.clearance

    @property
    def clearance_over(self) -> float:
        """z_fly above what a foot goes over, m: the gait's own, else less than above the ground."""
        own = self.gait.clearance_over
        return min(self.clearance, CLEARANCE_OVER) if own is None else own

    def value_of(self, group: str, name: str) -> Any:
        """A weight or bound: the scenario's own value, else the profile's default, else None.

        The default of `force_min` is less for a light robot than for CENTAURO, and that of the cost of
        changing forces more (executable): both are about forces as parts of the weight.
        """
        own = getattr(getattr(self, group), name)
        if own is not None:
            return own
        default = PROFILES[self.profile][group].get(name)
        if name == "force_min" and default is not None:
            return min(default, FORCE_OF_WEIGHT * self.body.weight)
        if (group, name, self.profile) == ("weights", "force", "executable") and default is not None:
            return default * max(1.0, WEIGHT_LIGHT / self.body.weight) ** 2
        return default

    def resolved(self) -> Scenario:
        """The same scenario with every default of its profile spelled out."""
        data = self.to_dict()
        data["ground"] = self.ground  # with the heights of its map
        data["gait"]["clearance"] = self.clearance
        data["gait"]["clearance_over"] = self.clearance_over
        for group in ("weights", "bounds"):
            data[group] = {
                name: self.value_of(group, name) for name in type(getattr(self, group)).model_fields
            }
        return type(self).model_validate(data)

    def self_contained(self) -> Scenario:
        """`resolved`, the robot in place of its name, and the map held: stays true when files change."""
        robot = find_robot(self.robot) if isinstance(self.robot, str) else self.robot
        return self.resolved().model_copy(update={"robot": robot, "ground": self.ground.self_contained()})

    def to_dict(self) -> dict[str, Any]:
        """The scenario as plain data."""
        return self.model_dump(mode="json")

    def to_yaml(self, brief: bool = False) -> str:
        """The scenario as YAML text; `brief` leaves out what is a default anyway."""
        return dump_yaml(without_none(self.to_brief_dict() if brief else self.to_dict()))

    def to_brief_dict(self) -> dict[str, Any]:
        """The scenario as plain data without its defaults, a robot of the library by its name."""
        full = self.to_dict()
        brief: dict[str, Any] = {"description": self.description} if self.description else {}
        brief["robot"] = full["robot"]
        if isinstance(self.robot, Robot) and self.robot == _in_library(self.robot.name):
            brief["robot"] = self.robot.name
        if self.start != Start():
            brief["start"] = self.start.model_dump(mode="json", exclude_defaults=True)
        brief["goal"] = self.goal.model_dump(mode="json", exclude_defaults=True)
        brief |= {"horizon": self.horizon, "interval": self.interval, "profile": self.profile}
        usual = self.model_copy(
            update={
                "weights": Weights(),
                "bounds": Bounds(),
                "gait": self.gait.model_copy(update={"clearance": None, "clearance_over": None}),
            }
        )
        gait = self.gait.model_dump(mode="json", exclude_defaults=True)
        for name in ("clearance", "clearance_over"):
            if gait.get(name) == getattr(usual, name):
                del gait[name]
        brief["gait"] = {"kind": self.gait.kind, **gait}
        if self.ground != Ground():
            brief["ground"] = full["ground"]
        if self.loads != Loads():
            brief["loads"] = self.loads.model_dump(mode="json", exclude_defaults=True)
        for group in ("weights", "bounds"):
            own = {
                name: value
                for name, value in full[group].items()
                if value is not None and getattr(getattr(self, group), name) != usual.value_of(group, name)
            }
            brief |= {group: own} if own else {}
        return brief

    # -- rules that need the robot --

    def check(self) -> None:
        """Raises `InputError` where the scenario contradicts itself or the robot."""
        _ = self.schedule
        self._check_loads()
        if self.start.motion is None:
            self._check_steering()
        level = self.ground.height if self.ground.kind == "flat" else None
        check_moving_start(self.start.motion, self.gait, self.gait.kind, self.schedule, level)
        self._check_goal_distance()
        if self.ground.kind != "flat":
            self._check_body_clearance()
            self._check_standing()

    def speed_max(self, leg: int) -> float:
        """Limit of |v| of a foot in stance: the smaller of the scenario's and the robot's, m/s."""
        return _smallest(self.value_of("bounds", "speed_max"), self.body.leg_list[leg].speed_max)

    def slip_max(self, leg: int) -> float:
        """How fast a foot may slip sideways, m/s: 0 but for fixed wheels with `slip_max` on flat ground."""
        own = self.body.leg_list[leg]
        return own.slip_max or 0.0 if own.foot == "fixed" and self.ground.kind == "flat" else 0.0

    def steering_rate_max(self, leg: int) -> float:
        """Limit of |σ̇| of a foot: the smaller of the scenario's and the robot's, rad/s."""
        return _smallest(
            self.value_of("bounds", "steering_rate_max"), self.body.leg_list[leg].steering_rate_max
        )

    def steering_range(self, leg: int) -> tuple[float, float]:
        """Range of σ − θz of a foot, rad."""
        own = self.bounds.steering_deg
        low, high = np.radians(own) if own is not None else self.body.leg_list[leg].steering
        return float(low), float(high)

    def start_headings(self) -> NDArray[np.float64]:
        """σ − θz at the start, shape (4,), rad (a fixed wheel has its own)."""
        asked = np.radians(list(self.start.heading_deg.model_dump().values()))
        if self.start.motion is not None:
            asked = np.array(self.start.motion.heading) - self.start.motion.euler[0]
        return np.array(
            [
                leg.heading if leg.foot == "fixed" else a
                for leg, a in zip(self.body.leg_list, asked, strict=True)
            ]
        )

    def _check_steering(self) -> None:
        for leg, name in enumerate(LEG_NAMES):
            if self.body.leg_list[leg].foot != "steerable":
                continue
            low, high = np.degrees(self.steering_range(leg))
            angle = getattr(self.start.heading_deg, name)
            if not low - 1e-9 <= angle <= high + 1e-9:
                raise InputError(
                    f"start.heading_deg.{name}",
                    angle,
                    f"must lie in the steering range [{low:.4g}, {high:.4g}] deg",
                )

    def _check_loads(self) -> None:
        """The robot can stand with what it carries, and what pulls at it does so at times that there are."""
        _ = self.body
        for k, wrench in enumerate(self.loads.wrench):
            times = {"start": wrench.start, "end": wrench.end}
            given = next((name for name, time in times.items() if time), None)
            timing = getattr(self.gait, "timing", None)
            if given and (_discovers(self.gait) or (timing is not None and timing.optimize)):
                rule = "must not be given where the gait or its times are yet to be found"
                raise InputError(f"loads.wrench.{k}.{given}", times[given], rule)
            if wrench.start >= self.horizon:
                rule = f"must lie within the horizon of {self.horizon:g} s"
                raise InputError(f"loads.wrench.{k}.start", wrench.start, rule)
            put = self.wrenches[k]
            if put.end is not None and put.end <= put.start:
                raise InputError(f"loads.wrench.{k}.end", wrench.end, "must be an interval of the mesh later")

    def _check_body_clearance(self) -> None:
        """The trunk has that much room below it where the robot stands on even ground."""
        asked, belly = self.bounds.body_clearance, self.body.underside.belly
        if asked is None or not belly:
            return
        room = self.body.height + min(box.z for box in belly)
        if asked >= room:
            rule = f"must be less than {room:.3g} m: so high is the trunk in the nominal stance"
            raise InputError("bounds.body_clearance", asked, rule)

    def _check_standing(self) -> None:
        """The feet can stand at the start and, which may be missed by a little, at the last goal."""
        from rollgait.scenario.standing import require_stance  # here: it needs SciPy

        later = self.goal.then
        last = later[-1] if later else self.goal
        name = f"goal.then.{len(later) - 1}" if later else "goal"
        start = (self.start.x, self.start.y, self.start.yaw_deg)
        if self.start.motion is None:
            require_stance(self.terrain, self.body, start, "start", with_margin=True)
        require_stance(self.terrain, self.body, (last.x, last.y, last.yaw_deg), name, with_margin=False)

    def _check_goal_distance(self) -> None:
        """The CoM gets no further than feet roll at full speed, boxes lean and it turns about a foot."""
        low, high = self.body.foot_boxes(self.bounds.box).swapaxes(0, 1)
        lean = float(np.linalg.norm((high - low)[:, :2], axis=1).max())
        if self.start.motion is not None:  # its feet may be ahead of it
            place = np.array([self.start.x, self.start.y])
            nominal = turned(self.body.stance, math.radians(self.start.yaw_deg))[:, :2] + place
            ahead = np.linalg.norm(self.start.feet(self.body.stance) - nominal, axis=1)
            lean += float(ahead.max())
        names = ["goal", *(f"goal.then.{k}" for k in range(len(self.goal.then)))]
        goals: list[Goal | LaterGoal] = [self.goal, *self.goal.then]
        begins = [0.0, *(later.at for later in self.goal.then)]
        for name, begin in zip(names, begins, strict=True):
            if begin >= self.horizon:
                rule = f"must lie within the horizon of {self.horizon} s"
                raise InputError(f"{name}.at", begin, rule)
        x, y, yaw = self.start.x, self.start.y, self.start.yaw_deg
        lever = turn_lever(self.body.stance)
        for name, goal, begin, end in zip(names, goals, begins, [*begins[1:], self.horizon], strict=True):
            distance = math.hypot(goal.x - x, goal.y - y)
            turn = math.radians(min(abs(goal.yaw_deg - yaw), 180.0))
            reach = self._farthest(begin, end) + lean + 2.0 * lever * math.sin(0.5 * turn)
            if distance > reach:
                why = f"which the speed limits allow in {end - begin:.4g} s"
                if self._stands_throughout():
                    why = f"as a foot that does not roll takes no step in the gait {self.gait.kind!r}"
                rule = f"must be within {reach:.3g} m, {why}; it is {distance:.3g} m away"
                raise InputError(name, [goal.x, goal.y], rule)
            self._check_standing_feet(name, goal, end)
            x, y, yaw = goal.x, goal.y, goal.yaw_deg

    def _check_standing_feet(self, name: str, goal: Goal | LaterGoal, end: float) -> None:
        """A foot that neither rolls nor has stepped is where it was; a goal must leave it in its box."""
        if self.gait.kind == "discover" or "box" in self.bounds.without:
            return
        contact, begins = self.schedule.contact, self.schedule.node_times[:-1]
        at_start = self.start.feet(self.body.stance)
        yaw = math.radians(goal.yaw_deg)
        c, s = math.cos(yaw), math.sin(yaw)
        offset = (at_start - _feet(goal, self.body.stance)) @ np.array([[c, -s], [s, c]])
        boxes = self.body.foot_boxes(self.bounds.box)[..., :2]
        for leg, data in enumerate(self.body.leg_list):
            if data.foot != "point" or not contact[leg, begins < end].all():
                continue
            low, high = boxes[leg]
            outside = float(np.maximum(low - offset[leg], offset[leg] - high).max())
            if outside > STANDING_ROOM:
                rule = (
                    f"must leave {LEG_NAMES[leg]} in its box, as it does not roll and takes no step before "
                    f"in the gait {self.gait.kind!r}; it would be {outside:.2f} m outside"
                )
                raise InputError(name, [goal.x, goal.y, goal.yaw_deg], rule)

    def _stands_throughout(self) -> bool:
        """Whether some point foot never leaves the ground, though the gait is given."""
        never: NDArray[np.bool_] = np.all(self.schedule.contact, axis=1)
        points = np.array([data.foot == "point" for data in self.body.leg_list])
        return self.gait.kind != "discover" and bool(np.any(never & points))

    def _farthest(self, begin: float, end: float) -> float:
        """How far the slowest foot that must come along can get, m."""
        nodes = self.schedule.node_times
        durations = np.clip(np.minimum(nodes[1:], end) - np.maximum(nodes[:-1], begin), 0.0, None)
        swing_speed = float(self.value_of("bounds", "swing_speed_max"))
        distances = []
        for leg, data in enumerate(self.body.leg_list):
            in_stance = self.schedule.contact[leg]
            rolling = 0.0 if data.foot == "point" else self.speed_max(leg)
            if data.foot == "point" and self.gait.kind == "discover":  # its steps are not known yet
                rolling = swing_speed
            speeds = np.where(in_stance, rolling, swing_speed)
            with np.errstate(over="ignore"):  # a limit may be as good as none
                distances.append(float(durations @ speeds))
        return min(distances)


def _feet(pose: Goal | LaterGoal, stance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nominal places of the feet in the plane at a pose, (4, 2), m."""
    return np.array([pose.x, pose.y]) + turned(stance[:, :2], math.radians(pose.yaw_deg))


def _discovers(gait: Any) -> bool:
    """Whether data of a gait are those of `discover`."""
    kind = gait.get("kind") if isinstance(gait, Mapping) else getattr(gait, "kind", gait)
    return bool(kind == Discover.model_fields["kind"].default)


def _in_library(name: str) -> Robot | None:
    try:
        return None if Path(name).suffix else find_robot(name)
    except InputError:
        return None


def _smallest(*values: float | None) -> float:
    return min(value for value in values if value is not None)


def _asked_of_any(gait: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a gait that every kind has, where they are not the defaults of its own kind."""
    own = next(kind for kind in GAITS if kind.model_fields["kind"].default == gait["kind"])
    return {
        name: gait[name] for name in BaseGait.model_fields if gait[name] != own.model_fields[name].default
    }


def without_none(data: Any) -> Any:
    """Plain data without the keys that say nothing."""
    if isinstance(data, dict):
        return {key: without_none(value) for key, value in data.items() if value is not None}
    if isinstance(data, list):
        return [without_none(value) for value in data]
    return data
