"""The motions of a data set at a fixed rate: plans as they are, or joints and bodies after tracking them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.counted import counted
from rollgait.dataset.columns import CERTIFIED
from rollgait.errors import InputError, MissingExtraError, RollgaitError
from rollgait.parallel import one_thread, results
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples

if TYPE_CHECKING:
    from rollgait.dataset.dataset import Dataset
    from rollgait.tracking import JointTrajectory
    from rollgait.tracking.bodies import Bodies

Array = NDArray[np.float64]

TRACKING_RATE: Final = 200.0
"""Least rate at which plans are tracked, Hz; frames are every so many of its samples."""
ON_TIME: Final = 1e-6
"""By how much a sample may be beside the time of its frame, s."""


@dataclass(frozen=True)
class Frames:
    """A motion, frame k at k / rate s.

    Attributes:
        row: of the data set.
        plan: the plan.
        index: samples of `joints` that are the frames, (n,).
        samples: the plan at the frames.
        joints: of the whole body, at a multiple of the rate; None for a plan alone.
        bodies: at the frames; None if nobody asked for them.
    """

    row: int
    plan: Plan
    index: NDArray[np.intp]
    samples: Samples
    joints: JointTrajectory | None = None
    bodies: Bodies | None = None

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self.samples.time)


@dataclass
class Written:
    """What an export wrote: motions and frames, and rows that were left out with the reason."""

    motions: int = 0
    frames: int = 0
    left_out: list[tuple[int, str]] = field(default_factory=list)


@dataclass(frozen=True)
class Motions:
    """The motions of a data set, in the order of its files.

    Attributes:
        dataset: the data set.
        rate: frames per second, Hz.
        tracked: whether with joints.
        rows: which; None: all that are certified.
        workers: how many are tracked at once.
        bodies: whether with the poses of all bodies.
    """

    dataset: Dataset
    rate: float
    tracked: bool
    rows: Sequence[int] | None
    workers: int
    bodies: bool = False

    def require_whole_rate(self, format: str) -> int:
        """The rate. Raises `InputError` unless it is a whole number, as the format has it."""
        if self.rate != round(self.rate):
            raise InputError("rate", self.rate, f"must be a whole number of frames per second for {format}")
        return round(self.rate)

    def each(self, written: Written) -> Iterator[Frames]:
        """The motions; what cannot be tracked is noted in `written`."""
        status = self.dataset.table(["status"])["status"].to_pylist() if self.rows is None else None
        total = len(self.rows or ()) if status is None else status.count(CERTIFIED)
        make = partial(_made, rate=self.rate, tracked=self.tracked, with_bodies=self.bodies)
        plans = enumerate(self.dataset.plans(self.rows))
        jobs = ((number, row, plan) for number, (row, plan) in plans)
        come = (make(job) for job in jobs) if not self.tracked else results(make, jobs, self.workers, _died)
        waiting: dict[int, Frames | tuple[int, str]] = {}
        due = 0
        with counted(total, 0, False, text="exporting") as advance:
            for number, made in come:
                waiting[number] = made
                while due in waiting:
                    found = waiting.pop(due)
                    due += 1
                    advance()
                    if isinstance(found, tuple):
                        written.left_out.append(found)
                        continue
                    written.motions += 1
                    written.frames += found.count
                    yield found


Job = tuple[int, int, Plan]


def _made(job: Job, *, rate: float, tracked: bool, with_bodies: bool) -> tuple[int, Frames | tuple[int, str]]:
    """A motion, in a worker; or the row and why there is none."""
    number, row, plan = job
    try:
        if not tracked:
            return number, of_plan(row, plan, rate)
        with one_thread():
            return number, of_joints(row, plan, rate, with_bodies)
    except MissingExtraError:
        raise
    except RollgaitError as error:
        return number, (row, str(error))


def _died(job: Job) -> tuple[int, Frames | tuple[int, str]]:
    return job[0], (job[1], "the process that tracked it died")


def of_plan(row: int, plan: Plan, rate: float) -> Frames:
    """A plan at a rate (Hz), from 0 on; its end only if that is a frame."""
    time = np.arange(math.floor((plan.horizon + ON_TIME) * rate) + 1) / rate
    samples = plan.sample(np.minimum(time, plan.horizon))
    return Frames(row, plan, np.arange(len(time)), samples)


def of_joints(row: int, plan: Plan, rate: float, with_bodies: bool) -> Frames:
    """A plan, tracked at a multiple of a rate (Hz), at that rate.

    Raises:
        NotCertifiedError: its certificate fails.
        InputError: there is no whole-body model of its robot.
        MissingExtraError: the extra `whole-body` is not installed.
    """
    from rollgait.tracking import track
    from rollgait.tracking.bodies import bodies_of

    multiple = math.ceil(TRACKING_RATE / rate)
    joints = track(plan, multiple * rate)
    count = math.floor((plan.horizon + ON_TIME) * rate) + 1
    index = np.arange(count) * multiple
    samples = joints.reference.at(index)
    bodies = bodies_of(joints, index) if with_bodies else None
    return Frames(row, plan, index, samples, joints, bodies)
