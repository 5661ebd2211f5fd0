"""Plans, maps and reports of a bridge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import InputError
from rollgait.hardware.bridge import Bridge
from rollgait.hardware.operator import COMMAND_TIMEOUT, Operator, terrain_from
from rollgait.hardware.reports import HEALTH_PERIOD, Reports
from rollgait.hardware.topics import DIAGNOSTICS, ENABLE, GOAL, HEIGHTS, IMU, PLAN, decoded, encoded
from rollgait.hardware.transports.loopback import TICK, Loopback
from rollgait.hardware.transports.transport import Several
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.settings import MpcSettings
from rollgait.ros.markers import UPRIGHT
from rollgait.ros.messages import Pose, header, joint_state, odometry, pose, quaternion
from rollgait.ros.topics import JOINT_STATES, MARKERS, ODOMETRY, TF
from tests.hardware.rig import Rig

MILLI = 1e-3
SLOPE = np.radians(8.0)
"""Of the ramp of a map."""
UP = 1.8
"""x at which a robot is on that ramp with all wheels, m."""


@pytest.fixture(scope="module")
def rolling() -> rg.Plan:
    """A plan in which nothing but wheels moves."""
    goal = rg.Goal(x=0.5)
    return rg.plan(rg.Scenario(robot="centauro", goal=goal, horizon=2.5, gait=rg.Drive()))


def test_a_plan_is_carried_out_while_somebody_is_there(mpc: Mpc, rolling: rg.Plan) -> None:
    rig = Rig(mpc, plans=[rolling])
    rig.enable()
    rig.until("active", 3.0, lambda: rig.switch(True))
    begin = rig.robot.truth.com_position[:2]
    rig.run(rolling.horizon + 1.5, lambda: rig.switch(True))
    assert rig.bridge.phase == "active"
    assert rig.bridge.mpc.progress is not None
    assert rig.bridge.mpc.progress.phase == "done"
    planned = rolling.sample(np.array([0.0, rolling.horizon])).com_position[:, :2]
    away = rig.robot.truth.com_position[:2] - planned[1]
    assert np.linalg.norm(begin - planned[0]) < 10 * MILLI
    assert np.linalg.norm(away) < 10 * MILLI
    assert rig.stands()


def test_a_plan_is_stopped_when_nobody_is_there_any_more(mpc: Mpc, rolling: rg.Plan) -> None:
    rig = Rig(mpc, plans=[rolling])
    rig.enable()
    rig.until("active", 3.0, lambda: rig.switch(True))
    rig.run(1.0, lambda: rig.switch(True))
    rig.until("stopped", COMMAND_TIMEOUT + 0.05)
    rig.run(1.0)
    assert rig.stands()
    assert rig.robot.truth.com_position[0] < 0.4
    Bridge(mpc, Loopback().end(), plans=[rolling])  # a controller may be used again, wherever it was


def test_a_plan_that_begins_elsewhere_moves_nothing(mpc: Mpc, rolling: rg.Plan) -> None:
    rig = Rig(mpc, plans=[rolling])
    rig.robot._physics.data.qpos[0] += 1.0
    rig.enable()
    rig.until("stopped", 3.0, lambda: rig.switch(True))
    assert any("begin" in event.text for event in rig.bridge.events)
    rig.run(0.5, lambda: rig.switch(True))
    assert rig.stands()


def test_a_plan_of_another_robot_is_refused_before_anything_moves(built: Mpc) -> None:
    other = rg.plan(rg.Scenario(robot="rover", goal=rg.Goal(x=0.2), horizon=2.0, gait=rg.Drive()))
    with pytest.raises(InputError, match="robot"):
        Bridge(built, Loopback().end(), plans=[other])


def test_a_goal_is_reached_and_a_velocity_takes_its_place(up: Rig) -> None:
    goal = encoded(GOAL, {"header": header(0, "odom"), "pose": pose(np.array([0.3, 0.0, 0.0]))})
    up.run(4.0, lambda: up.hand.publish(GOAL, goal))
    assert up.robot.truth.com_position[0] == pytest.approx(0.3, abs=0.02)
    up.run(1.5, lambda: up.drive(-0.2))
    assert up.robot.truth.com_velocity[0] < -0.1


CELL = 0.1
COUNT = 61
"""Cells of a map along a side, each as long, m: 6 m × 6 m about the origin."""


def heights(slope: float) -> dict[str, Any]:
    """A GridMap, level, and a ramp from x = 0.8 m on. The first cell is that of the largest x and y."""
    x = CELL * (np.arange(COUNT)[::-1] - 0.5 * (COUNT - 1))
    rows = np.repeat(np.maximum(0.0, slope * (x - 0.8))[:, None], COUNT, axis=1)
    data = rows.T.ravel().astype(np.float32)
    layout = {
        "dim": [
            {"label": "column_index", "size": COUNT, "stride": COUNT * COUNT},
            {"label": "row_index", "size": COUNT, "stride": COUNT},
        ]
    }
    return {
        "info": {
            "resolution": CELL,
            "length_x": CELL * COUNT,
            "length_y": CELL * COUNT,
            "pose": pose(np.zeros(3)),
        },
        "layers": ["elevation"],
        "data": [{"layout": layout, "data": data}],
    }


def test_a_map_that_came_is_the_ground_that_is_asked_for_once() -> None:
    loopback = Loopback()
    end, hand, refused = loopback.end(), loopback.end(), list[str]()
    operator = Operator(end, lambda: 0.0, refused.append)
    hand.publish(HEIGHTS, encoded(HEIGHTS, heights(0.1)))
    end.receive(0.0)
    ground = operator.ground()
    assert ground is not None
    x = np.array([-1.0, 0.5, 1.8])
    np.testing.assert_allclose(ground.height(x, np.zeros(3)), [0.0, 0.0, 0.1], atol=1e-3)
    assert operator.ground() is None
    hand.publish(HEIGHTS, encoded(HEIGHTS, {"layers": ["intensity"]}))
    end.receive(0.0)
    assert operator.ground() is None
    assert "elevation" in refused[0]


@pytest.mark.slow
def test_a_robot_climbs_what_the_map_shows() -> None:
    """Simulated robot and map know the same ramp; the controller knows the map alone."""
    message = heights(np.tan(SLOPE))
    terrain = terrain_from(encoded(HEIGHTS, message))
    rig = Rig(Mpc("centauro", MpcSettings(deadline=60.0), kernels=False), terrain=terrain)
    rig.hand.publish(HEIGHTS, encoded(HEIGHTS, message))
    rig.enable()
    assert any("ground is that of the last map" in event.text for event in rig.bridge.events)
    rig.until("active", 3.0)
    begin = rig.robot.truth.com_position
    while rig.robot.truth.com_position[0] < UP:
        assert rig.loopback.time < 20.0
        rig.run(0.1, lambda: rig.drive(0.3))
    assert rig.bridge.phase == "active"
    assert rig.bridge.prediction is not None
    truth, planned = rig.robot.truth, rig.bridge.prediction.foot_position[-1]
    assert not rig.robot.has_fallen
    risen = truth.com_position[2] - begin[2]
    ramp = np.maximum(0.0, np.tan(SLOPE) * (truth.foot_position[:, 0] - 0.8))
    assert risen == pytest.approx(ramp.mean(), abs=0.02)
    np.testing.assert_allclose(truth.foot_position[:, 2], ramp, atol=0.015)
    ahead = np.maximum(0.0, np.tan(SLOPE) * (planned[:, 0] - 0.8))
    np.testing.assert_allclose(planned[:, 2], ahead, atol=0.02)  # it goes where the ramp will be


def test_a_map_that_takes_its_time_does_not_stop_the_robot(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """A controller builds its problem anew for the first terrain, and nobody reads messages meanwhile."""

    def set_ground(_: Any) -> None:
        for _ in range(round(1.0 / TICK)):
            rig.loopback.pass_time()

    monkeypatch.setattr(rig.bridge.mpc, "set_ground", set_ground)
    rig.run(0.05)
    for topic, fields in ((HEIGHTS, heights(0.1)), (ENABLE, {"data": False}), (ENABLE, {"data": True})):
        rig.hand.publish(topic, encoded(topic, fields))  # all at once
    rig.until("active", 4.0)


# -- sensors that are not there ---------------------------------------------------------------------------


def test_who_waits_for_sensors_is_told_which(mpc: Mpc) -> None:
    loopback = Loopback()
    bridge, robot = Bridge(mpc, loopback.end(), clock=lambda: loopback.time), loopback.end()
    names, row = bridge.plant.joint_names, np.zeros(len(bridge.plant.joint_names))

    def run(seconds: float, imu: str) -> str:
        end = loopback.time + seconds
        while loopback.time < end:
            stamp = 10**9 + round(1e9 * loopback.time)
            state = joint_state(stamp, names, row, row, row)
            tilt = {"header": header(stamp, imu), "orientation": quaternion([0.0, 0.0, 0.0, 1.0])}
            place = odometry(stamp, Pose("odom", "base_link", np.zeros(3), UPRIGHT), np.zeros(3), np.zeros(3))
            for topic, fields in ((JOINT_STATES, state), (IMU, tilt), (ODOMETRY, place)):
                if imu and loopback.time > 2.2:
                    robot.publish(topic, encoded(topic, fields))
            bridge.step()
        return bridge.events[-1].text if bridge.events else ""

    assert run(1.0, "") == ""  # they may only just begin
    silent = "nothing comes on /joint_states; nothing comes on /imu; nothing comes on /odom"
    assert run(1.2, "") == silent
    wrong = "the IMU speaks in the frame 'imu_link', which must be that of the base link"
    unused = f"nothing comes on /imu that can be used: {wrong}"
    assert run(0.2, "imu_link") == unused
    for on in (False, True):
        robot.publish(ENABLE, encoded(ENABLE, {"data": on}))
    assert run(0.05, "imu_link") == f"the robot is not enabled: {unused}"
    assert run(0.1, "base_link") == "all sensors speak"
    assert len(bridge.events) == 4


def test_reports_say_where_the_robot_is_and_how_it_goes(up: Rig) -> None:
    seen: dict[str, dict[str, Any]] = {}
    for topic in (TF, PLAN, MARKERS, DIAGNOSTICS):

        def take(data: bytes, topic: Any = topic) -> None:
            seen[topic.name] = decoded(topic, data)

        up.hand.subscribe(topic, take)
    end = up.loopback.end()
    reports = Reports(end, lambda: up.loopback.time)
    up.run(HEALTH_PERIOD + 0.2, lambda: (up.drive(0.2), reports.after(up.bridge))[1])
    base = seen["/tf"]["transforms"][0]
    assert (base["header"]["frame_id"], base["child_frame_id"]) == ("odom", "base_link")
    x, y, z = up.robot._physics.pose.base_position
    place = base["transform"]["translation"]
    np.testing.assert_allclose([place["x"], place["y"], place["z"]], [x, y, z], atol=0.02)
    assert len(seen["/plan"]["poses"]) == len(up.bridge.loop.prediction.time)  # type: ignore[union-attr]
    arrows = [marker["points"] for marker in seen["/markers"]["markers"]]
    weight = sum(points[1]["z"] - points[0]["z"] for points in arrows) / 1e-3
    assert weight == pytest.approx(up.bridge.mpc.robot.weight, rel=0.1)
    (status,) = seen["/diagnostics"]["status"]
    values = {each["key"]: each["value"] for each in status["values"]}
    assert values["phase"] == "active"
    assert values["operator"] == "there"
    assert values["messages lost"] == "0"
    assert status["level"] == 0


def test_several_transports_say_the_same_and_hear_all() -> None:
    one, two = Loopback(), Loopback()
    both, heard = Several(one.end(), [two.end()]), []
    hands = [one.end(), two.end()]
    for hand in hands:
        hand.subscribe(JOINT_STATES, heard.append)
    both.publish(JOINT_STATES, b"said")
    for hand in hands:
        hand.receive(0.0)
    assert heard == [b"said", b"said"]
    came: list[bytes] = []
    both.subscribe(GOAL, came.append)
    for number, hand in enumerate(hands):
        hand.publish(GOAL, bytes([number]))
    both.receive(0.0)
    assert sorted(came) == [b"\x00", b"\x01"]
