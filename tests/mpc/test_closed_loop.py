"""The controller in closed loop: goals are reached, pushes survived, one iteration is as good as many."""

from __future__ import annotations

import numpy as np
import pytest

from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.gaits import GAITS
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.script import RandomScript, script_of
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.scenario import find_scenario

PATIENT = MpcSettings(deadline=1.0)
"""How busy the machine is shall not decide about a test."""
GOAL_DISTANCE, GOAL_ANGLE = 0.03, 2.0
"""m and degrees."""


def test_one_iteration_costs_little_more_than_convergence() -> None:
    script = RandomScript(duration=12.0, gait_every=4.0, push=100.0, seed=3).script()
    costs = []
    for iterations in (1, 50):
        mpc = Mpc("centauro", MpcSettings(iterations=iterations, deadline=10.0))
        log = ClosedLoop(mpc, RigidPlant(mpc.robot, noise=0.01, seed=3)).run(script)
        assert log.report().passed
        costs.append(log.report().cost)
    assert costs[0] < 1.03 * costs[1]


@pytest.mark.parametrize("gait", sorted(name for name, gait in GAITS.items() if len(set(gait.phase)) == 2))
def test_gaits_of_pairs_follow_a_command(gait: str) -> None:
    loop = make_loop("centauro", "rigid", PATIENT)
    for _ in range(500):
        loop.step(VelocityCommand(forward=0.2, turn_rate=0.2, gait=gait))
    state = loop.plant.state
    assert loop.mpc.clock.gait.name == gait
    assert not loop.plant.fallen
    assert np.hypot(*state.com_position[:2]) > 0.6
    assert state.euler[0] > 0.6
    assert np.abs(state.euler[1:]).max() < np.radians(8.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["wheeled", "hybrid-forward", "legged-forward", "hybrid-goback"])
def test_the_motions_of_the_paper_reach_their_goals_in_physics(name: str) -> None:
    pytest.importorskip("mujoco")
    script = script_of(find_scenario(name))
    log = make_loop("centauro", "mujoco", PATIENT, gait=script.gait).run(script)
    assert log.report().passed
    goal = script.commands[-1].command
    assert isinstance(goal, PoseCommand)
    away = np.hypot(*(log.com_position[-1, :2] - (goal.x, goal.y)))
    assert away < GOAL_DISTANCE
    assert abs(np.degrees(log.euler[-1, 0]) - goal.yaw_deg) < GOAL_ANGLE


@pytest.mark.slow
def test_random_commands_gaits_and_pushes_do_not_fell_the_robot() -> None:
    pytest.importorskip("mujoco")
    gaits = ("drive", "crawl", "trot", "walk", "stand")
    script = RandomScript(duration=30.0, gait_every=6.0, push=100.0, gaits=gaits, seed=11).script()
    report = make_loop("centauro", "mujoco", PATIENT).run(script).report()
    assert report.passed
    assert report.tilt_deg < 10.0
    assert max(report.forward_rms, report.lateral_rms) < 0.1
