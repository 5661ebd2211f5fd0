"""What was measured of a simulation: does the robot do what was planned?"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plant.unplanned import UnplannedContact
from rollgait.robot.robot import LEG_NAMES
from rollgait.simulation.record import SimulationRecord

Array = NDArray[np.float64]

LOADED: Final = 0.02
"""Share of the robot's weight that a foot must carry for its slip to count."""

PERCENTILES: Final = (50.0, 95.0)


@dataclass(frozen=True)
class JointUse:
    """How a joint used its limit: largest torque, N m, and its share of the limit (0 where there is none)."""

    joint: str
    torque: float
    share: float
    time: float


@dataclass(frozen=True)
class SimulationReport:
    """What came of a simulation.

    Attributes:
        fallen: whether the robot fell.
        fallen_at: when, s; None if it did not.
        end: time of the last sample, s.
        final_distance: of the base link from its planned place in the ground plane at the end, m.
        final_height: by how much it is higher than planned there, m.
        final_angle: of the base link from its planned orientation at the end, rad.
        final_yaw: the yaw in that, rad.
        tilt: largest angle of the base link's z axis from the vertical, rad.
        tilt_error: largest angle of it from its plan, rad.
        com_rms: root mean square of the distance of the CoM from its plan, m.
        com_worst: largest such distance, m.
        slip_p50, slip_p95: percentiles of the speed of loaded contact points over the ground, m/s.
        force_rms: root mean square of measured less planned contact force of each leg, (4,), N.
        force_planned_rms: that of the planned force itself, to compare with, (4,), N.
        unplanned: what else than a foot touched the ground, in the order in which it did first.
        joints: use of the torque limits, the most used first.
        real_time_factor: simulated time over the time it took.
    """

    fallen: bool
    fallen_at: float | None
    end: float
    final_distance: float
    final_height: float
    final_angle: float
    final_yaw: float
    tilt: float
    tilt_error: float
    com_rms: float
    com_worst: float
    slip_p50: float
    slip_p95: float
    force_rms: tuple[float, ...]
    force_planned_rms: tuple[float, ...]
    unplanned: tuple[UnplannedContact, ...]
    joints: tuple[JointUse, ...]
    real_time_factor: float

    @property
    def verdict(self) -> str:
        """One sentence: what became of the robot."""
        if self.fallen:
            return f"the robot falls after {self.fallen_at:.4g} s"
        place, angle = 1e3 * self.final_distance, abs(math.degrees(self.final_angle))
        return f"the robot stays on its feet and ends {place:.1f} mm and {angle:.2f} degrees from the plan"

    def __str__(self) -> str:
        return self.verdict

    def to_dict(self) -> dict[str, Any]:
        """Plain data, e.g. for JSON; angles in rad."""
        data = asdict(self)
        data["unplanned"] = [contact.model_dump() for contact in self.unplanned]
        for name in ("force_rms", "force_planned_rms"):
            data[name] = dict(zip(LEG_NAMES, data[name], strict=True))
        return data


def judge(log: SimulationRecord) -> SimulationReport:
    """The report of a log."""
    missing = log.base_position - log.planned_base_position
    R_world_base = rotation_matrices(log.base_quaternion)
    R_planned = rotation_matrices(log.planned_base_quaternion)
    R_error = np.einsum("nij,nkj->nik", R_world_base, R_planned)
    com = np.linalg.norm(log.com_position - log.planned_com_position, axis=1)
    up, up_planned = R_world_base[:, :, 2], R_planned[:, :, 2]
    difference = log.force - log.planned_force
    slip_p50, slip_p95 = _slip(log)
    return SimulationReport(
        fallen=log.fallen,
        fallen_at=log.fallen_at,
        end=float(log.time[-1]),
        final_distance=float(np.hypot(*missing[-1, :2])),
        final_height=float(missing[-1, 2]),
        final_angle=float(_angle(np.trace(R_error[-1]))),
        final_yaw=float(np.arctan2(R_error[-1, 1, 0], R_error[-1, 0, 0])),
        tilt=float(np.max(np.arccos(np.clip(up[:, 2], -1.0, 1.0)))),
        tilt_error=float(np.max(np.arccos(np.clip(np.sum(up * up_planned, axis=1), -1.0, 1.0)))),
        com_rms=float(np.sqrt(np.mean(com**2))),
        com_worst=float(np.max(com)),
        slip_p50=slip_p50,
        slip_p95=slip_p95,
        force_rms=_rms_by_leg(difference),
        force_planned_rms=_rms_by_leg(log.planned_force),
        unplanned=log.unplanned,
        joints=_joint_use(log),
        real_time_factor=float(log.time[-1] / log.wall_time) if log.wall_time > 0.0 else np.inf,
    )


def rotation_matrices(quaternions: Array) -> Array:
    """Rotation matrices of quaternions (x, y, z, w): (n, 4) to (n, 3, 3)."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    return np.moveaxis(
        np.array(
            [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
                [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
                [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
            ]
        ),
        2,
        0,
    )


def _angle(trace: float) -> float:
    """Angle of a rotation matrix with this trace, rad."""
    return float(np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0)))


def _slip(log: SimulationRecord) -> tuple[float, float]:
    loaded = np.isfinite(log.slip) & (log.force[:, :, 2] > LOADED * log.robot.weight)
    if not loaded.any():
        return 0.0, 0.0
    p50, p95 = np.percentile(log.slip[loaded], PERCENTILES)
    return float(p50), float(p95)


def _rms_by_leg(forces: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in np.sqrt(np.mean(np.sum(forces**2, axis=2), axis=0)))


def _joint_use(log: SimulationRecord) -> tuple[JointUse, ...]:
    when = np.argmax(log.torque_peak, axis=0)
    use = []
    for joint, name in enumerate(log.joint_names):
        torque = float(log.torque_peak[when[joint], joint])
        use.append(
            JointUse(name, torque, torque / float(log.effort_max[joint]), float(log.time[when[joint]]))
        )
    return tuple(sorted(use, key=lambda item: -item.share))
