"""A plan: what was asked, what was found, and how. Frozen; samples, certifies, saves and loads itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, model_validator

from rollgait.archive import ArchiveFormat
from rollgait.config import Line, validate
from rollgait.errors import InputError, UnknownNameError
from rollgait.npz import Layout
from rollgait.plan.condensed import CondensedTrajectory  # noqa: F401  (so that its files are known)
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import Trajectory
from rollgait.presented import Shown, Tabular
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.series import check_numbers
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.terrain import MapHeader

if TYPE_CHECKING:
    from rollgait.plan.certificate import Certificate
    from rollgait.plan.rest import Rest
    from rollgait.plant.moving import MotionState
    from rollgait.plant.state import RobotState

FORMAT_VERSION = 2
"""Version of the file format; a file with another one is refused."""

MAX_SAMPLES = 1_000_000
"""More samples than this at once are a slip of the pen: they would fill the memory."""

_PREFIX = "trajectory/"
_HEIGHTS = "ground/heights"


@dataclass(frozen=True)
class StartResult:
    """What came of one initial guess: whether it was solved, at which cost, after how long (s)."""

    name: Line
    solved: bool
    cost: float
    iterations: int
    solve_time: float


@dataclass(frozen=True)
class CandidateResult:
    """What came of a gait that was tried where it was to be found.

    Attributes:
        name: what is particular about it.
        score: by which it was put in order, s.
        horizon: its time, s.
        steps: swings that it has.
        outcome: `certified`, or why not.
        iterations: of the solver.
        way: of the base as it was meant, (x, y) from pose to pose, m.
        footholds: where feet would land, (x, y), m; none if no motion was found.
    """

    name: Line
    score: float
    horizon: float
    steps: int
    outcome: Line
    iterations: int = 0
    way: tuple[tuple[float, float], ...] = ()
    footholds: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Statistics:
    """How a plan was found.

    Attributes:
        transcription: name of the transcription.
        solver: name of the solver.
        solved: whether the solver converged. Only then may the plan be called a success.
        status: the solver's own word.
        iterations: its iterations, of all rounds.
        ground_rounds: how often the problem was solved with the ground looked up around the last motion; 1
            where the ground is made of planes.
        seconds: wall time by what it went into, s: `load` (files), `build` (numbers and solver), `guess`
            (starts and easier problems that lead to one), `solve` (the solver), `certify` (looks of the
            judge that led to repairs), `other`. They sum to the whole.
        cost: total cost J.
        costs: J term by term, by the name of the term.
        variables: number of variables of the NLP.
        constraints: number of its constraints.
        violation: largest violation of a constraint, in the scaling of the solver.
        worst: which constraint that is, where and when, as one line ("" if none is violated).
        start: name of the initial guess from which this was found.
        starts: what came of each initial guess that was tried.
        discovery: what came of each gait that was tried, in their order, where the gait was to be found; the
            last one is this plan's.
        start_changes: what of a measured state was changed to make it the start, and which feet it has nearer
            to edges than they may be, in words.
        linear_algebra: what factorised the solver's matrices, e.g. BLASFEO with a product compiled here.
    """

    transcription: Line
    solver: Line
    solved: bool
    status: Line
    iterations: int
    cost: float
    costs: dict[str, float] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    variables: int = 0
    constraints: int = 0
    violation: float = 0.0
    worst: Line = ""
    start: Line = ""
    starts: tuple[StartResult, ...] = ()
    linear_algebra: str = ""
    ground_rounds: int = 1
    discovery: tuple[CandidateResult, ...] = ()
    start_changes: tuple[Line, ...] = ()

    @property
    def wall_time(self) -> float:
        """From the call to the plan, s: what the user waited for."""
        return sum(self.seconds.values())

    @property
    def solve_time(self) -> float:
        """In the solver, s."""
        return self.seconds.get("solve", 0.0)

    @property
    def build_time(self) -> float:
        """From the scenario to a solver that is ready, s."""
        return self.seconds.get("build", 0.0)


@dataclass(frozen=True)
class Plan(Shown, Tabular):
    """A planned motion.

    Attributes:
        robot: the robot it is for.
        scenario: what was asked, with every default spelled out.
        schedule: which foot is on the ground when.
        trajectory: the motion as a function of time.
        statistics: how it was found.
    """

    robot: Robot
    scenario: Scenario
    schedule: ContactSchedule
    trajectory: Trajectory
    statistics: Statistics

    def __repr__(self) -> str:
        steps = sum(1 for _ in self.schedule.swings())
        result = f"solved, cost {self.statistics.cost:.4g}" if self.solved else "not solved"
        return f"<Plan: {self.robot.name}, {self.horizon:g} s, {steps} steps, {result}>"

    def with_statistics(self, statistics: Statistics) -> Plan:
        """The same plan with other statistics; what was judged of it stays."""
        other = replace(self, statistics=statistics)
        if "_certificate" in self.__dict__:
            other.__dict__["_certificate"] = self._certificate
        return other

    @property
    def solved(self) -> bool:
        """Whether the solver converged."""
        return self.statistics.solved

    @property
    def horizon(self) -> float:
        """T, s."""
        return self.schedule.horizon

    def sample(self, time: ArrayLike) -> Samples:
        """The motion at one or more times, exact to the solution's polynomials.

        Args:
            time: s, a number or an array of shape (n,), within [0, T].

        Raises:
            InputError: a time lies outside the horizon or is not finite.
        """
        rule = "must be a number or an array of shape (n,), s"
        try:
            times = np.atleast_1d(np.asarray(time, dtype=float))
        except (TypeError, ValueError):
            raise InputError("time", time, rule) from None
        if times.ndim != 1:
            raise InputError("time", times.shape, rule)
        outside = times[~((times >= -1e-9) & (times <= self.horizon + 1e-9))]
        if outside.size:
            raise InputError(
                "time", float(outside[0]), f"must lie within the horizon [0, {self.horizon:.6g}] s"
            )
        samples = self.trajectory.sample(np.clip(times, 0.0, self.horizon), self.robot)
        return samples.at(0) if np.ndim(time) == 0 else samples

    def sample_every(self, rate: float) -> Samples:
        """The motion at a fixed rate, both ends included.

        Args:
            rate: samples per second, Hz.

        Raises:
            InputError: the rate is not positive, or asks for more than `MAX_SAMPLES`.
        """
        given: Any = rate
        if not (isinstance(given, Real) and 0.0 < float(given) < math.inf):
            raise InputError("rate", rate, "must be a positive number of samples per second (Hz)")
        if rate * self.horizon > MAX_SAMPLES:
            most = MAX_SAMPLES / self.horizon
            raise InputError(
                "rate", rate, f"must be at most {most:.6g} Hz in a horizon of {self.horizon:.6g} s"
            )
        inside = np.arange(math.ceil((self.horizon - 1e-9) * rate)) / rate
        return self.sample(np.append(inside, self.horizon))

    def state_at(self, time: float) -> MotionState:
        """The robot as it is planned at a time, s: what another plan may begin with.

        Raises `InputError` if the time lies outside the horizon.
        """
        from rollgait.plan.rest import state_at

        return state_at(self, time)

    def rest(self, time: float, state: RobotState | None = None, delay: float = 0.0) -> Rest:
        """What is left of the plan from a time on, for another plan: `rollgait.plan(plan.rest(time))`.

        Args:
            time: s of the plan.
            state: where the robot is then; as planned, if not given. Feet that have landed early stand.
            delay: by how much later the rest goes on, s; all feet stand meanwhile.

        Raises:
            InputError: nothing of the plan is left, or the state is too far from one with which the rest can
                begin.
        """
        from rollgait.plan.rest import rest_of

        return rest_of(self, time, state, delay)

    def require_numbers(self) -> None:
        """Raises `InputError` if numbers of the motion are none: nobody can draw or export those.

        The last iterate of a solver that failed may have such; it is saved and judged as it is.
        """
        arrays = {f"trajectory.{name}": array for name, array in self.trajectory.arrays().items()}
        check_numbers(arrays, arrays)

    def certificate(self) -> Certificate:
        """What is measured of the plan by code that shares nothing with the optimiser (computed once)."""
        return self._certificate

    @cached_property
    def _certificate(self) -> Certificate:
        from rollgait.plan.certificate import certify

        return certify(self)

    # -- files --

    def save(self, path: str | Path) -> Path:
        """Writes the plan as one .npz file (the suffix is added to a name without one); returns its path.

        The map of its ground goes with it: whoever reads the plan needs no other file.
        """
        return _FILE.write(path, *self.parts())

    def parts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """What it is made of: a header as plain data, and arrays, as `from_parts` takes them."""
        scenario = self.scenario.model_copy(update={"ground": self.scenario.ground.self_contained()})
        heights = scenario.ground.heights
        header = {
            "kind": self.trajectory.kind,
            "robot": self.robot.model_dump(mode="json"),
            "scenario": scenario.to_dict(),
            "statistics": asdict(self.statistics),
        }
        arrays: dict[str, Any] = {
            "contact": self.schedule.contact,
            "lengths": self.schedule.lengths,
            **{_PREFIX + name: array for name, array in self.trajectory.arrays().items()},
        }
        if heights is not None:
            header["map"] = heights.place()
            arrays[_HEIGHTS] = heights.values
        return header, arrays

    @classmethod
    def load(cls, path: str | Path) -> Plan:
        """Reads a plan; runs no code from the file and needs no solver.

        Raises:
            FileError: the file is missing, is no plan, or has a version that is not known here.
        """
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            return cls._from_header(header, arrays)

    @classmethod
    def from_parts(cls, header: Mapping[str, Any], arrays: dict[str, NDArray[Any]]) -> Plan:
        """The inverse of `parts`. Raises `InputError` if they do not fit together."""
        return cls._from_header(validate(_Header, header), arrays)

    @classmethod
    def _from_header(cls, header: _Header, arrays: dict[str, NDArray[Any]]) -> Plan:
        """The plan in the parts of a file. Raises `InputError` if they do not fit together."""
        trajectory = Trajectory.registry[header.kind].from_arrays(
            {key.removeprefix(_PREFIX): a for key, a in arrays.items() if key.startswith(_PREFIX)}
        )
        contact = arrays["contact"]
        schedule = ContactSchedule(contact, Mesh(arrays["lengths"]), header.scenario.schedule.begun)
        if schedule.mesh != trajectory.mesh:
            raise InputError("lengths", schedule.intervals, "intervals must be those of the solution")
        scenario = header.scenario
        if header.map is not None:
            heights = HeightMap(arrays[_HEIGHTS], **header.map.model_dump())
            scenario = scenario.model_copy(update={"ground": scenario.ground.with_heights(heights)})
        return cls(
            robot=header.robot,
            scenario=scenario,
            schedule=schedule,
            trajectory=trajectory,
            statistics=header.statistics,
        )


class _Header(BaseModel):
    """What the header of a plan file holds."""

    kind: str
    robot: Robot
    scenario: Scenario
    statistics: Statistics
    map: MapHeader | None = None

    @model_validator(mode="after")
    def _has_its_map(self) -> Self:
        if (self.map is None) != (self.scenario.ground.map is None):
            raise ValueError("must have a map where its scenario says so, and only there")
        return self


def _layout(header: _Header) -> Layout:
    """The arrays of a plan file, by the kind of its trajectory; N intervals."""
    if header.kind not in Trajectory.registry:
        raise UnknownNameError("kind", header.kind, Trajectory.registry)
    kind = Trajectory.registry[header.kind]
    trajectory = kind.layout("N")
    if header.scenario.loads.wrench:
        trajectory |= kind.layout_of_wrenches("N")
    return {
        "contact": ("b", (len(LEG_NAMES), "N")),
        "lengths": ("f", ("N",)),
        **{_PREFIX + name: described for name, described in trajectory.items()},
        **({} if header.map is None else {_HEIGHTS: ("f", ("nx", "ny"))}),
    }


_FILE = ArchiveFormat(
    "rollgait-plan", FORMAT_VERSION, "plan", "is not a plan that rollgait saved", _Header, _layout
)
