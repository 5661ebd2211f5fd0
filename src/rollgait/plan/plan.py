"""A plan: what was asked, what was found, and how. Frozen; samples, judges, saves and loads itself."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.archive import ArchiveFormat
from rollgait.config import validate
from rollgait.errors import InputError
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import Trajectory
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

if TYPE_CHECKING:
    from rollgait.plan.certificate import Certificate

FORMAT_VERSION = 1
"""Version of the file format; a file with another one is refused."""

MAX_SAMPLES = 1_000_000
"""More samples than this at once are a slip of the pen: they would fill the memory."""

_FILE = ArchiveFormat("rollgait-plan", FORMAT_VERSION, "plan", "is not a plan that rollgait saved")
_PREFIX = "trajectory/"


@dataclass(frozen=True)
class StartResult:
    """What came of one initial guess: whether it was solved, at which cost, after how long (s)."""

    name: str
    solved: bool
    cost: float
    iterations: int
    solve_time: float


@dataclass(frozen=True)
class Statistics:
    """How a plan was found.

    Attributes:
        transcription: name of the transcription.
        solver: name of the solver.
        solved: whether the solver converged. Only then may the plan be called a success.
        status: the solver's own word.
        iterations: its iterations.
        build_time: from the scenario to a solver that is ready, s.
        solve_time: in the solver, s.
        cost: total cost J.
        costs: J term by term, by the name of the term.
        variables: number of variables of the NLP.
        constraints: number of its constraints.
        violation: largest violation of a constraint, in the scaling of the solver.
        worst: which constraint that is, where and when, as one line ("" if none is violated).
        start: name of the initial guess from which this was found.
        starts: what came of each initial guess that was tried.
    """

    transcription: str
    solver: str
    solved: bool
    status: str
    iterations: int
    build_time: float
    solve_time: float
    cost: float
    costs: dict[str, float] = field(default_factory=dict)
    variables: int = 0
    constraints: int = 0
    violation: float = 0.0
    worst: str = ""
    start: str = ""
    starts: tuple[StartResult, ...] = ()

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Statistics:
        """The inverse of `dataclasses.asdict`."""
        known = {f.name: data[f.name] for f in fields(cls) if f.name in data}
        known["starts"] = tuple(StartResult(**start) for start in known.get("starts", ()))
        return cls(**known)


@dataclass(frozen=True)
class Plan:
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
        times = np.atleast_1d(np.asarray(time, dtype=float))
        if times.ndim != 1:
            raise InputError("time", times.shape, "must be a number or an array of shape (n,)")
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
        if not (np.isfinite(rate) and rate > 0.0):
            raise InputError("rate", rate, "must be a positive number of samples per second (Hz)")
        if rate * self.horizon > MAX_SAMPLES:
            most = MAX_SAMPLES / self.horizon
            raise InputError(
                "rate", rate, f"must be at most {most:.6g} Hz in a horizon of {self.horizon:.6g} s"
            )
        inside = np.arange(math.ceil((self.horizon - 1e-9) * rate)) / rate
        return self.sample(np.append(inside, self.horizon))

    def certificate(self) -> Certificate:
        """Judges the plan by code that shares nothing with the optimiser (computed once)."""
        return self._certificate

    @cached_property
    def _certificate(self) -> Certificate:
        from rollgait.plan.certificate import certify

        return certify(self)

    # -- files --

    def save(self, path: str | Path) -> Path:
        """Writes the plan as one .npz file (the suffix is added if it is missing); returns its path."""
        header = {
            "kind": self.trajectory.kind,
            "robot": self.robot.model_dump(mode="json"),
            "scenario": self.scenario.to_dict(),
            "statistics": asdict(self.statistics),
        }
        arrays: dict[str, Any] = {
            "contact": self.schedule.contact,
            "interval": np.array(self.schedule.interval),
            **{_PREFIX + name: array for name, array in self.trajectory.arrays().items()},
        }
        return _FILE.write(path, header, arrays)

    @classmethod
    def load(cls, path: str | Path) -> Plan:
        """Reads a plan; runs no code from the file and needs no solver.

        Raises:
            FileError: the file is missing, is no plan, or has a version that is not known here.
        """
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            return cls._from_parts(header, arrays)

    @classmethod
    def _from_parts(cls, header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Plan:
        """The plan in the parts of a file. Raises KeyError, TypeError or ValueError if they do not fit."""
        trajectory = Trajectory.registry[header["kind"]].from_arrays(
            {key.removeprefix(_PREFIX): a for key, a in arrays.items() if key.startswith(_PREFIX)}
        )
        contact, interval = arrays["contact"], float(arrays["interval"])
        if contact.dtype != np.bool_ or contact.ndim != 2 or contact.shape[0] != len(LEG_NAMES):
            raise InputError(
                "contact", contact.shape, "must be truth values for four legs and every interval"
            )
        schedule = ContactSchedule(contact, interval)
        if not (interval > 0.0 and np.isclose(schedule.horizon, trajectory.horizon)):
            raise InputError(
                "interval", interval, f"must cut {trajectory.horizon:.6g} s, as the solution does"
            )
        return cls(
            robot=validate(Robot, header["robot"], "robot"),
            scenario=validate(Scenario, header["scenario"], "scenario"),
            schedule=schedule,
            trajectory=trajectory,
            statistics=Statistics.from_dict(header["statistics"]),
        )
