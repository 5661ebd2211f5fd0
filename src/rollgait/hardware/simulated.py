"""The robot in MuJoCo as hardware is: sensors with noise, late messages, drives that hold when nobody speaks.

It knows no controller. What it hears are joint commands, what it says are sensors; the truth is for tests and
reports, and crosses no transport.
"""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.config import Config, NonNegative, Positive
from rollgait.errors import InputError
from rollgait.hardware.last_stage import COMMAND_AGE_MAX, LastStage, bounds_of
from rollgait.hardware.postures import rise_of
from rollgait.hardware.topics import IMU, JOINT_COMMANDS, TRUTH, decoded, encoded
from rollgait.hardware.transports.transport import Transport
from rollgait.plant.disturbances import Disturbances
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.robot import GRAVITY, Robot
from rollgait.robot.urdf_model import WholeBodyModel, load_model
from rollgait.robot.whole_body import find_whole_body
from rollgait.ros import messages
from rollgait.ros.messages import Fields
from rollgait.ros.messages import Pose as FramePose
from rollgait.ros.topics import BASE_LINK, JOINT_STATES, ODOM, ODOMETRY, Topic
from rollgait.simulation.controller import JointReference
from rollgait.simulation.drives import gains_of
from rollgait.simulation.joint_path import JointPath
from rollgait.simulation.measure import StateReader, reader_at
from rollgait.simulation.physics import Physics, Pose
from rollgait.simulation.plant import PRESSING, SMOOTHING
from rollgait.simulation.world import TIME_STEP
from rollgait.terrain.terrain import Terrain
from rollgait.tracking.follower import JointTarget

Array = NDArray[np.float64]

SETTLING: Final = 0.5
"""How long it rests on the ground before its time begins, s."""


class SensorNoise(Config):
    """Standard deviations of white noise, and what is late."""

    joint_position: NonNegative = 2e-4
    """rad: an encoder of 15 bits behind a gear."""
    joint_velocity: NonNegative = 0.02
    """rad/s."""
    effort: NonNegative = 1.0
    """N m."""
    tilt: NonNegative = 1e-3
    """Of the orientation of the IMU, rad."""
    angular_velocity: NonNegative = 5e-3
    """rad/s."""
    acceleration: NonNegative = 0.05
    """m/s²."""
    place: NonNegative = 2e-3
    """Of the odometry, m."""
    yaw: NonNegative = 2e-3
    """Of the odometry, rad."""
    velocity: NonNegative = 0.01
    """Of the odometry, m/s."""
    latency: NonNegative = 5e-3
    """Age of what the sensors say when it leaves, s."""
    period: Positive = 0.01
    """Between two messages of a sensor, s."""


class SimulatedRobot:
    """A robot that only a transport reaches. Time passes in `tick`, by `TIME_STEP`.

    Args:
        robot: the planner's robot; it needs a whole body.
        transport: its drives listen there, its sensors speak there.
        noise: of the sensors.
        seed: of the noise.
        posture: of the joints at first, (n_j,), rad; as low as the legs let it if not given.
        place: x, y of the CoM and yaw at first, m and rad.
        terrain: the ground; a plane at height 0 if not given.
        disturbances: what else is not as a controller takes it.
        tells_truth: whether it says the truth as well, on `/truth`, for who reports errors.

    Raises:
        InputError: the ground is not known under its feet.

    Attributes:
        joint_names: of the n_j joints.
        held: whether the drives hold because no command has come for `COMMAND_AGE_MAX`.
        stage: its own last stage.
    """

    def __init__(
        self,
        robot: Robot,
        transport: Transport,
        *,
        noise: SensorNoise | None = None,
        seed: int = 0,
        posture: Array | None = None,
        place: tuple[float, float, float] = (0.0, 0.0, 0.0),
        terrain: Terrain | None = None,
        disturbances: Disturbances | None = None,
        tells_truth: bool = False,
    ) -> None:
        self._robot, self._transport = robot, transport
        self._tells_truth = tells_truth
        self._noise, self._random = noise or SensorNoise(), np.random.default_rng(seed)
        body = find_whole_body(robot)
        model = load_model(body)
        self.joint_names = model.joint_names
        joints = rise_of(model, robot).postures[0] if posture is None else np.asarray(posture, dtype=float)
        still = np.zeros_like(joints)
        self._path = JointPath(SMOOTHING, joints, still)
        rest = JointReference(joints[None], still[None], still[None])
        self._physics = Physics(
            body,
            self.joint_names,
            gains_of(robot, body, self.joint_names),
            disturbances or Disturbances(),
            _resting(model, joints, place, terrain),
            rest,
            ground=0.0,
            begins=SETTLING,
            terrain=terrain,
        )
        self.stage = LastStage(self.joint_names, bounds_of(model), self._noise.period)
        self.stage.begin(joints, 0.0)
        self.held = True
        self._reader = self._reader_of(model, joints, place)
        self._heard: tuple[float, JointTarget] | None = None
        self._late: deque[tuple[float, Topic, bytes]] = deque()
        self._velocity: Array = np.zeros(3)
        self._force: Array = np.zeros((4, 3))
        self._pressing = PRESSING * robot.weight
        self._every = max(1, round(self._noise.period / TIME_STEP))
        transport.subscribe(JOINT_COMMANDS, self._listen)
        while self._physics.steps < 0:
            self._step()

    def _reader_of(
        self, model: WholeBodyModel, joints: Array, place: tuple[float, float, float]
    ) -> StateReader:
        """Reads the true state; the headings at first are those that kinematics say."""
        pose, world = self._physics.pose, self._physics.world
        known = model.state(np.concatenate([pose.base_position, pose.base_quaternion, joints]))
        like = standing_state(self._robot, 0.0, *place)
        start = RobotState(
            0.0,
            known.p_com,
            like.euler,
            np.zeros(3),
            np.zeros(3),
            known.p_foot,
            known.heading,
            np.zeros(4),
        )
        return reader_at(world, self._physics.data, model, start)

    # -- the truth --------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """s."""
        return self._physics.time

    @property
    def truth(self) -> RobotState:
        """The true state now."""
        return self._reader.read(self._physics.data, self.time)

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Which feet truly press on the ground, (4,)."""
        return np.asarray(self._force[:, 2] > self._pressing)

    @property
    def contact_force(self) -> Array:
        """Of the ground on the feet over the last period, (4, 3), N."""
        return self._force

    @property
    def has_fallen(self) -> bool:
        """Whether its base lies on its side or in half its height as it was at first."""
        return self._physics.has_fallen

    @property
    def joint_position(self) -> Array:
        """(n_j,), rad."""
        return np.asarray(self._physics.data.qpos[self._physics.world.position])

    def push(self, force: tuple[float, float, float], duration: float) -> None:
        """From now on a force on the base, N, world, for a time, s."""
        self._physics.push(force, duration)

    # -- time -------------------------------------------------------------------------------------------

    def tick(self) -> None:
        """A millisecond: hears, moves, and says what is due."""
        self._transport.receive(0.0)
        self._drive()
        self._step()
        if self._physics.steps % self._every == 0:
            self._force = self._physics.take_load().force
            self._measure()
        while self._late and self._late[0][0] <= self.time + 1e-9:
            _, topic, data = self._late.popleft()
            self._transport.publish(topic, data)

    def _step(self) -> None:
        self._physics.drives.load(self._path.take(1))
        self._physics.step(0)

    # -- drives -----------------------------------------------------------------------------------------

    def _listen(self, data: bytes) -> None:
        """Takes a command that names all joints; any other is as if none had come."""
        try:
            message = decoded(JOINT_COMMANDS, data)
            place = {name: k for k, name in enumerate(message["name"])}
            order = [place[name] for name in self.joint_names]
            parts = (message["position"], message["velocity"], message["effort"])
            rows = [np.asarray(part, dtype=float)[order] for part in parts]
        except Exception:  # of bytes from anywhere
            return
        self._heard = self.time, JointTarget(*rows)

    def _drive(self) -> None:
        if self._heard is None:
            return
        since, target = self._heard
        if since >= self.time - 0.5 * TIME_STEP:
            told = self.stage.let_through(target, self.joint_position, self.time)
            self._path.aim(told, self._every)
            self.held = False
        elif not self.held and self.time - since > COMMAND_AGE_MAX:
            self._path.aim(self.stage.hold(self.time), self._every)
            self.held = True

    # -- sensors ----------------------------------------------------------------------------------------

    def _measure(self) -> None:
        pose, velocity = self._physics.pose, self._physics.velocity
        now = round(1e9 * (self.time + 1.0))  # a stamp of 0 means "the latest" to tf
        noise = self._noise
        R = Rotation.from_quat(pose.base_quaternion)
        joints = messages.joint_state(
            now,
            self.joint_names,
            self._noisy(pose.joint_position, noise.joint_position),
            self._noisy(velocity.joint_velocity, noise.joint_velocity),
            self._noisy(self._physics.data.actuator_force, noise.effort),
        )
        acceleration = (velocity.base_linear - self._velocity) / noise.period + [0.0, 0.0, GRAVITY]
        self._velocity = velocity.base_linear
        tilted = R * Rotation.from_rotvec(self._noisy(np.zeros(3), noise.tilt))
        imu: Fields = {
            "header": messages.header(now, BASE_LINK),
            "orientation": messages.quaternion(tilted.as_quat()),
            "orientation_covariance": _covariance(noise.tilt, 3),
            "angular_velocity": messages.vector(self._noisy(velocity.base_angular, noise.angular_velocity)),
            "angular_velocity_covariance": _covariance(noise.angular_velocity, 3),
            "linear_acceleration": messages.vector(
                self._noisy(R.inv().apply(acceleration), noise.acceleration)
            ),
            "linear_acceleration_covariance": _covariance(noise.acceleration, 3),
        }
        turned = Rotation.from_rotvec([0.0, 0.0, *self._noisy(np.zeros(1), noise.yaw)]) * R
        odometry = messages.odometry(
            now,
            FramePose(ODOM, BASE_LINK, self._noisy(pose.base_position, noise.place), turned.as_quat()),
            self._noisy(R.inv().apply(velocity.base_linear), noise.velocity),
            self._noisy(velocity.base_angular, noise.angular_velocity),
        )
        due = self.time + noise.latency
        for topic, message in ((IMU, imu), (ODOMETRY, odometry), (JOINT_STATES, joints)):
            self._late.append((due, topic, encoded(topic, message)))
        if self._tells_truth:
            self._transport.publish(TRUTH, encoded(TRUTH, {"data": as_numbers(self.truth, self.touching)}))

    def _noisy(self, values: Array, deviation: float) -> Array:
        return np.asarray(values + deviation * self._random.normal(size=len(values)))


def _resting(
    model: WholeBodyModel, joints: Array, place: tuple[float, float, float], terrain: Terrain | None
) -> Pose:
    """Level, with a foot on the ground and none in it, and its CoM at a place."""
    x, y, yaw = place
    quaternion = Rotation.from_euler("z", yaw).as_quat()
    body = model.state(np.concatenate([np.zeros(3), quaternion, joints]))
    feet = body.p_foot + np.array([x - body.p_com[0], y - body.p_com[1], 0.0])
    ground = np.zeros(len(feet)) if terrain is None else terrain.height(feet[:, 0], feet[:, 1])
    if not np.isfinite(ground).all():
        raise InputError("ground", "unknown", "must be known where the robot is to stand")
    p_base = np.array([x - body.p_com[0], y - body.p_com[1], float(np.max(ground - feet[:, 2]))])
    return Pose(p_base, quaternion, joints)


def as_numbers(state: RobotState, touching: NDArray[np.bool_]) -> Array:
    """What errors are reported of, as one row: CoM, Euler angles, feet, CoM's velocity, contacts, (25,)."""
    parts = (state.com_position, state.euler, state.foot_position.ravel(), state.com_velocity, touching)
    return np.concatenate(parts)


def _covariance(deviation: float, size: int) -> Array:
    """The same variance for all, row by row."""
    return np.asarray(deviation**2 * np.eye(size)).ravel()
