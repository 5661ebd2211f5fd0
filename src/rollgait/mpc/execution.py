"""Plans carried out by the controller: the run, and how near it came to what was planned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import rotations
from rollgait.errors import InputError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.log import LogWriter, MpcLog, MpcReport
from rollgait.mpc.loop import ClosedLoop, Watch, no_collections
from rollgait.mpc.plans.clock import PlanClock
from rollgait.mpc.script import TimedPush
from rollgait.mpc.setup import make_loop
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.robot.loads import Loads, Wrench
from rollgait.robot.robot import LEG_NAMES

if TYPE_CHECKING:
    from rollgait.mpc.plans.replanner import Replacement, Replanner
    from rollgait.plant.unplanned import UnplannedContact

Array = NDArray[np.float64]

SETTLING: Final = 1.5
"""How long the robot stands after the last plan, s: where it comes to rest counts."""
EXTRA_TIME: Final = 30.0
"""So much longer than planned a run may take, s; then it is ended."""
AT_LIMIT: Final = 0.999
"""Share of its torque limit from which on a joint is at it."""


@dataclass(frozen=True)
class Foothold:
    """Where a foot landed.

    Attributes:
        plan: number of the plan, from 0.
        leg: 0 … 3.
        time: s.
        distance: from the planned place, in the ground plane, m.
    """

    plan: int
    leg: int
    time: float
    distance: float


@dataclass(frozen=True)
class ExecutionReport:
    """What came of plans that the controller carried out.

    Attributes:
        passed: whether the robot carried them out to their ends, on its feet and under control.
        done: whether the last plan was carried out to its end.
        fallen_at: s; None if it did not fall.
        end: time of the last sample, s.
        planned: length of all plans, s.
        shift: by how much later than planned the last plan ended, s.
        holds: how often the robot had to wait because it was pushed off.
        final_distance: of the base from its planned place in the ground plane at the end, m; of the base link
            where there is a whole body, else of the CoM.
        final_height: by how much it is higher there, m.
        final_angle: of the base from its planned orientation there, rad.
        final_yaw: the yaw in that, rad.
        footholds: places of landing.
        foothold_worst, foothold_rms: distance from the planned ones, m; 0 where no foot swings.
        com_rms, com_worst: distance of the CoM from its plan at the time of the plan, m.
        tilt: largest angle of the base's z axis from the vertical, rad.
        tilt_error: largest angle of it from its plan, rad.
        force_rms: root mean square of measured less planned contact force of each leg, (4,), N; empty where
            nothing is measured.
        torque_share: largest share of its torque limit that a joint used; 0 without joints.
        at_limit: for how long a joint was at its torque limit, s.
        unplanned: what else than a foot touched the ground.
        controller: what the controller's own log says.
        replacements: of plans that no longer fitted, also those that came to nothing.
    """

    passed: bool
    done: bool
    fallen_at: float | None
    end: float
    planned: float
    shift: float
    holds: int
    final_distance: float
    final_height: float
    final_angle: float
    final_yaw: float
    footholds: tuple[Foothold, ...]
    foothold_worst: float
    foothold_rms: float
    com_rms: float
    com_worst: float
    tilt: float
    tilt_error: float
    force_rms: tuple[float, ...]
    torque_share: float
    at_limit: float
    unplanned: tuple[UnplannedContact, ...]
    controller: MpcReport
    replacements: tuple[Replacement, ...] = ()

    @property
    def verdict(self) -> str:
        """One sentence: what became of the robot."""
        if not self.controller.passed:
            return self.controller.verdict
        if not self.done:
            return "the robot does not carry out the plan to its end"
        place, angle = 1e3 * self.final_distance, np.degrees(abs(self.final_angle))
        return f"the robot stays on its feet and ends {place:.3g} mm and {angle:.3g} degrees from the plan"

    def to_dict(self) -> dict[str, Any]:
        """Plain data, e.g. for JSON; angles in rad."""
        data = {name: getattr(self, name) for name in self.__dataclass_fields__}
        data["footholds"] = [asdict(one) | {"leg": LEG_NAMES[one.leg]} for one in self.footholds]
        data["force_rms"] = dict(zip(LEG_NAMES, self.force_rms, strict=False))
        data["unplanned"] = [contact.model_dump() for contact in self.unplanned]
        data["controller"] = self.controller.to_dict()
        data["replacements"] = [asdict(one) for one in self.replacements]
        return data


@dataclass(frozen=True, eq=False)
class Execution:
    """Plans carried out.

    Attributes:
        log: of the controller.
        report: how near it came to what was planned.
    """

    log: MpcLog
    report: ExecutionReport


def loop_for(plan: Plan, plant: str = "mujoco", *then: Plan, **options: Any) -> ClosedLoop:
    """A controller and a plant that stands as a plan begins, on its ground, under its loads.

    Args:
        plan: the first that is to be carried out.
        plant: `rigid` or `mujoco`.
        then: the plans that follow it, for what pulls at the base then.
        options: of `make_loop`.
    """
    from rollgait.mpc.plans.path import PlanPath

    path = PlanPath(plan)
    options = {"loads": Loads(wrench=_one_after_the_other([plan, *then]))} | options
    return make_loop(plan.robot, plant, start=path.state(0.0), terrain=path.terrain, **options)


def _one_after_the_other(plans: Sequence[Plan]) -> tuple[Wrench, ...]:
    """What pulls at the base while plans are carried out in turn, in the time of all of them."""
    wrenches, begin = [], 0.0
    for number, plan in enumerate(plans, start=1):
        over = None if number == len(plans) else plan.horizon
        for wrench in plan.scenario.wrenches:
            end = over if wrench.end is None else wrench.end
            times = {"start": begin + wrench.start, "end": None if end is None else begin + end}
            wrenches.append(wrench.model_copy(update=times))
        begin += plan.horizon
    return tuple(wrenches)


def run_length(plans: Sequence[Plan]) -> float:
    """How long a run of plans lasts, the stand at its end included, if none is late, s."""
    return sum(plan.horizon for plan in plans) + SETTLING


def execute(
    plans: Sequence[Plan],
    loop: ClosedLoop,
    watch: Watch | None = None,
    pushes: Sequence[TimedPush] = (),
    replan: bool = False,
) -> Execution:
    """Lets a closed loop carry out plans, one after the other, and stand at the end.

    Args:
        plans: each begins where the one before ends, the first where the robot is.
        loop: controller and plant, on the plans' ground.
        watch: called after each step with the time, s; ends the run if it returns True.
        pushes: of the base, in any order; they begin before the end of the run.
        replan: whether plans that no longer fit are replaced, planned by a process in the background.

    Raises:
        InputError: there is no plan, one is of another robot, or begins elsewhere; or a push begins after the
            end.
    """
    if not plans:
        raise InputError("plans", [], "must be at least one plan")
    for push in pushes:
        push.check_begins(run_length(plans))
    loop.mpc.follow(*plans)
    run = _Run(plans, loop, watch, pushes)
    if not replan:
        return run.execution()
    return run.replanning()


class _Run:
    """One run, row by row."""

    def __init__(
        self, plans: Sequence[Plan], loop: ClosedLoop, watch: Watch | None, pushes: Sequence[TimedPush]
    ) -> None:
        self._plans, self._loop, self._watch = list(plans), loop, watch
        self._replanner: Replanner | None = None
        self._pushes = sorted(pushes, key=lambda push: push.at)
        self._writer = LogWriter(loop.mpc.robot, loop.plant, loop.mpc.settings.period)
        self._rows: list[tuple[int, float, Array, Array, float]] = []
        self._footholds: list[Foothold] = []
        self._stood: NDArray[np.bool_] = np.ones(len(LEG_NAMES), dtype=bool)

    def replanning(self) -> Execution:
        """Runs to the end with plans replaced that no longer fit."""
        from rollgait.mpc.plans.replanner import Replanner

        self._replanner = Replanner(self._loop.mpc, self._plans)
        try:
            return self.execution()
        finally:
            self._replanner.close()

    def execution(self) -> Execution:
        """Runs to the end."""
        loop, plant = self._loop, self._loop.plant
        begin, planned = loop.time, sum(plan.horizon for plan in self._plans)
        done_at, fallen_at = None, None
        with no_collections():
            while (time := loop.time - begin) < planned + EXTRA_TIME:
                while self._pushes and self._pushes[0].at <= time + 1e-9:
                    push = self._pushes.pop(0)
                    plant.push(np.array(push.force), push.duration)
                before, pose = plant.state, getattr(plant, "pose", None)
                control, prediction = loop.step(VelocityCommand())
                self._writer.add(before, control, prediction, loop.mpc.wanted, pose)
                self._note(control.contact)
                if self._replanner is not None:
                    self._replanner.update(plant.state)
                progress = loop.mpc.progress
                if plant.fallen:
                    fallen_at = loop.time
                    break
                if self._watch is not None and self._watch(time):
                    break
                if progress is None or progress.phase == "given up":
                    break
                if progress.phase == "done":
                    done_at = time if done_at is None else done_at
                    if time - done_at >= SETTLING - 1e-9:
                        break
        log = self._writer.finish(fallen_at, [e for e in loop.mpc.events if e.time >= begin])
        return Execution(log, self._report(log, planned, done_at is not None))

    def _note(self, contact: NDArray[np.bool_]) -> None:
        """Writes down where the plan is, what the feet bear, and which have landed."""
        loop, progress = self._loop, self._loop.mpc.progress
        force = np.asarray(getattr(loop.plant, "contact_force", np.empty((0, 3))))
        share = float(getattr(loop.plant, "torque_share", 0.0))
        if progress is None:  # stands for good
            number, time, _, _, _ = self._rows[-1] if self._rows else (0, 0.0, force, force, 0.0)
        else:
            number, time = progress.number, progress.plan_time
        pose = np.concatenate([loop.plant.state.com_position, loop.plant.state.euler])
        self._rows.append((number, time, pose, force, share))
        clock = loop.mpc.clock
        for leg in np.flatnonzero(contact & ~self._stood).tolist():
            swing = clock.landed(leg) if isinstance(clock, PlanClock) else None
            if swing is not None:
                away = (loop.plant.state.foot_position[leg] - swing.foothold)[:2]
                self._footholds.append(Foothold(number, leg, loop.time, float(np.hypot(*away))))
        self._stood = contact

    def _report(self, log: MpcLog, planned: float, done: bool) -> ExecutionReport:
        numbers, times, poses, forces, shares = (np.array(column) for column in zip(*self._rows, strict=True))
        wanted = _at(self._plans, numbers, times)
        away = np.linalg.norm(poses[:, :3] - np.array([row.com_position for row in wanted]), axis=1)
        planned_euler = np.array([row.euler for row in wanted])
        up, up_planned = _up(poses[:, 3:]), _up(planned_euler)
        distances = np.array([one.distance for one in self._footholds] or [0.0])
        force_rms = ()
        if forces.size:
            gaps = forces - np.array([row.force * row.contact[:, None] for row in wanted])
            force_rms = tuple(np.sqrt(np.mean(np.sum(gaps**2, axis=2), axis=0)).tolist())
        plant: Any = self._loop.plant
        controller, progress = log.report(), self._loop.mpc.progress
        last = self._final(wanted[-1], poses[-1])
        return ExecutionReport(
            passed=done and controller.passed,
            done=done,
            fallen_at=log.fallen_at,
            end=float(self._loop.time),
            planned=planned,
            shift=0.0 if progress is None else progress.shift,
            holds=0 if progress is None else progress.holds,
            **last,
            footholds=tuple(self._footholds),
            foothold_worst=float(distances.max()),
            foothold_rms=float(np.sqrt(np.mean(distances**2))),
            com_rms=float(np.sqrt(np.mean(away**2))),
            com_worst=float(away.max()),
            tilt=float(np.arccos(np.clip(up[:, 2], -1.0, 1.0)).max()),
            tilt_error=float(np.arccos(np.clip((up * up_planned).sum(axis=1), -1.0, 1.0)).max()),
            force_rms=force_rms,
            torque_share=float(shares.max()),
            at_limit=log.period * int((shares >= AT_LIMIT).sum()),
            unplanned=tuple(getattr(plant, "unplanned", {}).values()),
            controller=controller,
            replacements=() if self._replanner is None else tuple(self._replanner.replacements),
        )

    def _final(self, wanted: Samples, pose: Array) -> dict[str, float]:
        """How far the base is from its plan at the end."""
        plant: Any = self._loop.plant
        own = getattr(plant, "pose", None)
        if own is None:
            away = pose[:3] - wanted.com_position
        else:
            away = own.base_position - planned_base(plant, wanted)
        R, R_planned = rotations(pose[None, 3:])[0], rotations(wanted.euler[None])[0]
        error = R @ R_planned.T
        return {
            "final_distance": float(np.hypot(*away[:2])),
            "final_height": float(away[2]),
            "final_angle": float(np.arccos(np.clip(0.5 * (np.trace(error) - 1.0), -1.0, 1.0))),
            "final_yaw": float(np.arctan2(error[1, 0], error[0, 0])),
        }


def planned_base(plant: Any, wanted: Samples) -> Array:
    """Where the base link of a whole body is that stands as a plan has it at a time, (3,), m."""
    from rollgait.tracking.kinematics import InverseKinematics
    from rollgait.tracking.tasks import Target

    R = rotations(wanted.euler[None])[0]
    target = Target(wanted.com_position, R, wanted.foot_position, wanted.heading, np.zeros(len(LEG_NAMES)))
    return np.asarray(InverseKinematics(plant.follower.model).stand(target).p_base)


def _at(plans: Sequence[Plan], numbers: NDArray[np.int_], times: Array) -> list[Samples]:
    """What the plans have in each row."""
    rows: list[Samples] = []
    for number, plan in enumerate(plans):
        own = plan.sample(times[numbers == number])
        rows += [own.at(k) for k in range(len(own.time))]
    return rows


def _up(euler: Array) -> Array:
    """z axes of bases with Euler angles (n, 3), (n, 3)."""
    return np.asarray(rotations(euler)[:, :, 2])
