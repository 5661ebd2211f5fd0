"""Gaits that are found, on the page: let the goal go and see how to get there, and what was tried."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.view.browser import centre, near, needs_chromium, picture, seen, wait_until

from rollgait.plan.plan import CandidateResult, Plan  # isort: skip  # the line above skips where viser is absent
from rollgait.planner import plan  # isort: skip
from rollgait.view.clip import clip_of_plan  # isort: skip
from rollgait.view.layers.discovery import foothold_regions, in_vain  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip
from tests.view.test_viewer import GIZMO_X  # isort: skip


@pytest.fixture(scope="module")
def kerb() -> Plan:
    return plan("kerb-discover")


@pytest.fixture(scope="module")
def viewer(kerb: Plan) -> Iterator[Viewer]:
    shown = Viewer(clip_of_plan(kerb, "kerb"), port=0)
    yield shown
    shown.close()


def test_each_foothold_lies_in_a_region_of_its_foot(kerb: Plan) -> None:
    regions = foothold_regions(clip_of_plan(kerb, "kerb"))
    for swing in kerb.schedule.swings():
        landed = kerb.sample(kerb.schedule.node_times[swing.touch_down]).foot_position[swing.leg, :2]
        assert any(inside(polygon, landed) for polygon in regions[swing.leg])


def inside(polygon: Any, place: Any) -> bool:
    """Whether a closed convex outline, counter-clockwise or not, has a place in it or on its border."""
    edge = np.diff(polygon, axis=0)
    arm = place - polygon[:-1]
    side = edge[:, 0] * arm[:, 1] - edge[:, 1] * arm[:, 0]
    return bool((side >= -1e-6).all() or (side <= 1e-6).all())


def test_what_was_tried_in_vain_is_drawn(kerb: Plan, viewer: Viewer) -> None:
    clip = clip_of_plan(kerb, "kerb")
    assert in_vain(clip) == ()
    assert viewer.scene is not None
    assert "gaits tried in vain" not in viewer.scene.layers
    failed = CandidateResult(
        "wide", 9.0, 9.0, 4, "not solved", way=((0.0, 0.0), (2.2, 0.4)), footholds=((1.2, 0.3),)
    )
    tried = (failed, *kerb.statistics.discovery)
    viewer.show(clip_of_plan(kerb.with_statistics(replace(kerb.statistics, discovery=tried)), "kerb, again"))
    assert {"gaits tried in vain", "foothold regions"} <= set(viewer.scene.layers)
    viewer.show(clip)


def test_the_record_of_what_was_tried_says_where_feet_land(kerb: Plan) -> None:
    found = kerb.statistics.discovery[-1]
    assert found.outcome == "certified"
    assert found.way[-1] == pytest.approx((kerb.scenario.goal.x, kerb.scenario.goal.y))
    assert len(found.footholds) == found.steps
    landed = [
        tuple(kerb.sample(kerb.schedule.node_times[s.touch_down]).foot_position[s.leg, :2])
        for s in kerb.schedule.swings()
    ]
    assert np.allclose(sorted(found.footholds), sorted(landed), atol=1e-3)


@pytest.mark.slow
@needs_chromium
def test_who_lets_the_goal_go_sees_how_to_get_there(sheet: Any, viewer: Viewer) -> None:
    sheet.goto(viewer.url)
    sheet.get_by_text("normal force").wait_for()
    sheet.get_by_role("tab", name="Design").click()
    viewer.designer.pick("kerb-discover")
    panel = viewer.designer.panel
    assert panel.gait.gait.value == "discover"
    assert panel.places.goal.value == (2.2, 0.0, 0.0)
    wait_until(lambda: near(picture(sheet), GIZMO_X, 0.25).any())
    x, y = centre(near(seen(sheet, viewer.server), GIZMO_X, 0.25))
    sheet.mouse.move(x, y)
    sheet.mouse.down()
    sheet.mouse.move(x - 20, y - 6, steps=6)
    sheet.mouse.move(x - 40, y - 12, steps=6)
    sheet.mouse.up()
    wait_until(lambda: viewer.clip.name == "my kerb-discover, planned")
    sheet.get_by_text("4 steps found").wait_for()
    assert viewer.clip.plan is not None
    assert viewer.clip.plan.scenario.gait.kind == "schedule"
    assert panel.gait.gait.value == "discover"  # the next goal has a gait of its own, too
    assert viewer.clip.samples.com_position[-1, 0] == pytest.approx(panel.places.goal.value[0], abs=0.05)
    viewer.timeline.pause()
