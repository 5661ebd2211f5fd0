"""Plans, maps and reports of a bridge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import InputError
from rollgait.hardware.bridge import Bridge
from rollgait.hardware.operator import COMMAND_TIMEOUT
from rollgait.hardware.reports import HEALTH_PERIOD, Reports
from rollgait.hardware.topics import DIAGNOSTICS, GOAL, HEIGHTS, PLAN, decoded, encoded
from rollgait.hardware.transports.loopback import Loopback
from rollgait.hardware.transports.transport import Several
from rollgait.mpc.mpc import Mpc
from rollgait.ros.messages import header, pose
from rollgait.ros.topics import JOINT_STATES, MARKERS, TF
from tests.hardware.rig import Rig

MILLI = 1e-3


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


def heights(step: float) -> dict[str, Any]:
    """A GridMap of 6 m × 6 m: level, higher where x > 1 m. The first cell is that of the largest x and y."""
    count, resolution = 61, 0.1
    x = resolution * (np.arange(count)[::-1] - 0.5 * (count - 1))
    rows = np.repeat(np.where(x > 1.0, step, 0.0)[:, None], count, axis=1)
    data = rows.T.ravel().astype(np.float32)
    layout = {
        "dim": [
            {"label": "column_index", "size": count, "stride": count * count},
            {"label": "row_index", "size": count, "stride": count},
        ]
    }
    return {
        "info": {
            "resolution": resolution,
            "length_x": resolution * count,
            "length_y": resolution * count,
            "pose": pose(np.zeros(3)),
        },
        "layers": ["elevation"],
        "data": [{"layout": layout, "data": data}],
    }


def test_a_map_that_came_is_the_ground_that_is_asked_for_once(rig: Rig) -> None:
    rig.hand.publish(HEIGHTS, encoded(HEIGHTS, heights(0.1)))
    rig.run(0.02)
    ground = rig.bridge.operator.ground()
    assert ground is not None
    x = np.array([-1.0, 0.5, 1.5])
    np.testing.assert_allclose(ground.height(x, np.zeros(3)), [0.0, 0.0, 0.1], atol=1e-3)
    assert rig.bridge.operator.ground() is None
    rig.hand.publish(HEIGHTS, encoded(HEIGHTS, {"layers": ["intensity"]}))
    rig.run(0.02)
    assert rig.bridge.operator.ground() is None
    assert "elevation" in rig.bridge.events[-1].text


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
