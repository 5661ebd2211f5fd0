"""The controller's optimal control problem: the same step and terms as the planner's, with open numbers.

What differs from a plan: contact enters as data (the share of each interval in which a foot stands, so that
a step may come between nodes), foot heights are a known profile, references move, the workspace is a cost
beyond its limits (a disturbed robot may start outside), and nothing is demanded at the end.

Forces are means over their interval, f̄ = share · f. Where a foot does not stand at all its force has no
effect, and a small cost keeps it at zero; the same with the rolling of a locked wheel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import Figures, FootInput, State, step
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.stage_data import LiveStage
from rollgait.ocp.costs import FORCE_INTERVAL_REF
from rollgait.ocp.friction import Friction
from rollgait.ocp.instant import Body, Inputs, Instant
from rollgait.ocp.limb import JointSteering, Reach
from rollgait.ocp.limits import Box
from rollgait.robot.robot import Robot
from rollgait.transcription.base import Structure
from rollgait.transcription.layout import Layout, StageLayout
from rollgait.transcription.nlp import Accelerate, Block, Nlp, StageFunction
from rollgait.transcription.stage import symmetric
from rollgait.transcription.states import instant_of, state_entries, state_of

Array = NDArray[np.float64]

FEET: Final = 4
HINGE: Final = 1e-3
"""Width over which the cost beyond a limit sets in, m or rad: without it its slope would have a corner."""
OPEN: Final = 10.0
"""Limit of a scaled input that has no effect: far enough not to be felt."""


def _layout(robot: Robot) -> StageLayout:
    """The layout of a robot's variables."""
    steerable = tuple(i for i, leg in enumerate(robot.leg_list) if leg.foot == "steerable")
    state = [("theta", 3), ("L", 3), ("r", 3), ("dr", 3), ("xy", 2 * FEET), ("sigma", len(steerable))]
    node = Layout([*state, ("previous_force", 3 * FEET), ("previous_speed", FEET)])
    inputs = Layout([("force", 3 * FEET), ("motion", 2 * FEET)])
    return StageLayout(node, inputs, steerable, sum(size for _, size in state))


@dataclass(frozen=True)
class LiveProblem:
    """The problem of a controller.

    Attributes:
        robot: whose.
        nlp: what the solver solves.
        structure: its stages.
        layout: of the variables.
        interval, end: the stages, whose numbers are to be filled in.
    """

    robot: Robot
    nlp: Nlp
    structure: Structure
    layout: StageLayout
    interval: LiveStage
    end: LiveStage


def build(robot: Robot, settings: MpcSettings, accelerate: Accelerate | None = None) -> LiveProblem:
    """The problem of a robot with the horizon of the settings."""
    layout, count = _layout(robot), settings.intervals
    interval, end = LiveStage(count), LiveStage(1)
    workspace = settings.bounds.workspace
    interval_stage = interval.finish(_fill_interval(interval, robot, layout, workspace))
    end_stage = end.finish(_fill_end(end, robot, layout, workspace))
    interval_stage.holds[layout.last : layout.node.size, -1] = False
    functions = StageFunction("live_interval", interval_stage, residuals=ca.vertcat(*interval.residuals))
    at_end = StageFunction("live_end", end_stage, residuals=ca.vertcat(*end.residuals))
    if accelerate is not None:
        functions.accelerate(accelerate)
        at_end.accelerate(accelerate)
    defined = layout.defined(interval_stage.rows.numel())
    nlp = Nlp(
        [
            Block(interval_stage, functions, layout.variables(count), next_state=defined),
            Block(end_stage, at_end, layout.last_variables(count), first=count),
        ],
        layout.total(count),
        initial=np.zeros(layout.node.size),
        live=True,
    )
    rows = interval_stage.rows.numel() - layout.node.size
    structure = Structure(
        nx=(0, *[layout.node.size] * (count - 1), layout.last),
        nu=(*[layout.inputs.size] * count, 0),
        ng=(*[rows] * count, 0),
    )
    return LiveProblem(robot, nlp, structure, layout, interval, end)


# -- stages ----------------------------------------------------------------------------------------------


class _Symbols:
    """Figures of the robot as symbols of a stage."""

    def __init__(self, stage: LiveStage, robot: Robot) -> None:
        inertia = stage.symbol("inertia", 6)
        inverse = stage.symbol("inertia_inverse", 6)
        self.body = Body(
            mass=stage.symbol("mass", 1),
            weight=stage.symbol("weight", 1),
            inertia=symmetric(inertia),
            stance=ca.reshape(stage.symbol("stance", 12), 3, FEET),
            heading_offset=stage.symbol("heading_offset", FEET),
            interval=stage.symbol("interval", 1),
            ground=ca.SX.zeros(FEET),
        )
        self.figures = Figures(
            mass=self.body.mass,
            inertia_inverse=[[symmetric(inverse)[i, j] for j in range(3)] for i in range(3)],
            kinds=[leg.foot for leg in robot.leg_list],
            heading_offset=ca.vertsplit(self.body.heading_offset),
        )
        self.momentum = (inertia[0] + inertia[3] + inertia[5]) / 3.0
        self.foot_z = stage.symbol("foot_z", FEET)


def _fill_interval(stage: LiveStage, robot: Robot, layout: StageLayout, workspace: bool) -> ca.SX:
    symbols = _Symbols(stage, robot)
    body, h = symbols.body, symbols.body.interval
    node, u = ca.SX.sym("node", layout.node.size), ca.SX.sym("inputs", layout.inputs.size)
    following = ca.SX.sym("next_node", layout.node.size)
    force, motion = u[layout.inputs["force"]], u[layout.inputs["motion"]]
    stands, moves = stage.symbol("stands", FEET), stage.symbol("moves", 2 * FEET)
    lift_rate = stage.symbol("lift_rate", 2 * FEET)
    effective = [stands[i] * force[3 * i : 3 * i + 3] for i in range(FEET)]
    motions = [moves[2 * i : 2 * i + 2] * motion[2 * i : 2 * i + 2] for i in range(FEET)]
    begin = state_of(layout, node, symbols.momentum, symbols.foot_z)
    feet = [
        FootInput(
            ca.vertsplit(body.weight * effective[i]),
            ca.vertsplit(motions[i]),
            [lift_rate[2 * i], lift_rate[2 * i + 1]],
        )
        for i in range(FEET)
    ]
    end, middle = step(ca, begin, feet, h, symbols.figures)
    reached = ca.vertcat(*state_entries(layout, end, symbols.momentum), force, motion[0::2])
    stage.add_rows("dynamics", following - reached, equation=True)

    inputs = Inputs([body.weight * f for f in effective], motions, [ca.SX.zeros(2)] * FEET)
    x = _instant(symbols, begin, inputs)
    _add_state_costs(stage, robot, symbols, x, h, workspace)
    weight = _weights(stage)
    stage.add_cost("acc", weight("acc") * h, x.ddr)
    change = body.weight * (force - node[layout.node["previous_force"]])
    stage.add_cost("force", weight("force") * FORCE_INTERVAL_REF**2 / h, change)
    stage.add_cost("speed", weight("speed") * h, motion[0::2] - stage.symbol("speed_ref", FEET))
    stage.add_cost("yaw", weight("yaw") * h, motion[1::2])
    stage.add_cost("share", weight("share") * h, force - stage.symbol("force_ref", 3 * FEET))
    idle = ca.vertcat(
        *((1 - stands[i]) * force[3 * i : 3 * i + 3] for i in range(FEET)), (1 - moves) * motion
    )
    stage.add_cost("idle", weight("idle") * h, idle)

    mu = stage.symbol("mu", 1)
    friction, data = Friction(), SimpleNamespace(mu=mu)
    raw = Inputs([force[3 * i : 3 * i + 3] for i in range(FEET)], motions, [ca.SX.zeros(2)] * FEET)
    cones = _instant(symbols, middle, raw)
    stage.add_rows(
        "friction", ca.vertcat(*(friction.expression(cones, f, data) for f in cones.feet)), unit="mg"
    )
    stage.add_rows("force", force[2::3], unit="mg")
    stage.add_rows("first_motion", motion[0::2], unit="m/s")
    stage.add_rows("second_motion", motion[1::2], unit="rad/s")
    stage.add_rows("acceleration", motion[0::2] - node[layout.node["previous_speed"]], unit="m/s")
    return ca.vertcat(node, u, following)


def _fill_end(stage: LiveStage, robot: Robot, layout: StageLayout, workspace: bool) -> ca.SX:
    symbols = _Symbols(stage, robot)
    node = ca.SX.sym("node", layout.last)
    x = _instant(symbols, state_of(layout, node, symbols.momentum, symbols.foot_z), Inputs.none())
    factor = stage.symbol("factor", 1)
    _add_state_costs(stage, robot, symbols, x, factor * symbols.body.interval, workspace)
    return node


def _instant(symbols: _Symbols, x: State, inputs: Inputs) -> Instant:
    """The instant of a state; how fast feet rise is known, and no term asks for it."""
    return instant_of(symbols.body, symbols.figures, x, [ca.SX(0)] * FEET, inputs, Inputs.none())


def _weights(stage: LiveStage) -> Callable[[str], ca.SX]:
    """Weights as parameters of a stage, by the name of their cost."""
    return lambda name: stage.symbol(f"weight_{name}", 1)


def _add_state_costs(
    stage: LiveStage, robot: Robot, symbols: _Symbols, x: Instant, length: ca.SX, workspace: bool
) -> None:
    weight = _weights(stage)
    pose, rate = stage.symbol("pose_ref", 4), stage.symbol("rate_ref", 4)  # (r, yaw) and their rates
    stage.add_cost("goal", weight("goal") * length, ca.vertcat(x.r[:2] - pose[:2], x.theta[0] - pose[3]))
    stage.add_cost("height", weight("height") * length, x.r[2] - pose[2])
    stage.add_cost("tilt", weight("tilt") * length, x.theta[1:])
    stage.add_cost("velocity", weight("velocity") * length, x.dr - rate[:3])
    stage.add_cost("rotation", weight("rotation") * length, x.dtheta - ca.vertcat(rate[3], 0, 0))
    away = [foot.p_body[:2] - x.body.stance[:2, foot.index] for foot in x.feet]
    stage.add_cost("feet", weight("feet") * length, ca.vertcat(*away))
    heading = stage.symbol("heading_ref", FEET)
    steered = [foot.heading - heading[foot.index] for foot in x.feet if foot.kind == "steerable"]
    stage.add_cost("heading", weight("heading") * length, ca.vertcat(*steered))
    if workspace:
        stage.add_cost("workspace", weight("workspace") * length, _beyond(stage, robot, x))


def _beyond(stage: LiveStage, robot: Robot, x: Instant) -> ca.SX:
    """By how much the feet are outside of their workspace, each limit on its own."""
    parts = []
    box, steering, reach = Box(), JointSteering(), Reach()
    for foot in x.feet:
        name, limb = f"{foot.index}", robot.leg_list[foot.index].limb
        values = [box.expression(x, foot, SimpleNamespace())[:2]]
        if limb is not None:
            data = SimpleNamespace(
                hip=stage.symbol(f"hip_{name}", 3),
                offset=stage.symbol(f"offset_{name}", 1),
                direction=stage.symbol(f"direction_{name}", 1),
                ankle_height=stage.symbol(f"ankle_height_{name}", 1),
            )
            values.append(reach.expression(x, foot, data))
            if foot.kind == "steerable":
                values.append(steering.expression(x, foot, data))
        value = ca.vertcat(*values)
        low = stage.symbol(f"low_{name}", value.numel())
        high = stage.symbol(f"high_{name}", value.numel())
        parts += [_hinge(low - value), _hinge(value - high)]
    return ca.vertcat(*parts)


def _hinge(x: ca.SX) -> ca.SX:
    """x where it is positive, else nothing; smooth."""
    return 0.5 * (x + ca.sqrt(x * x + HINGE**2))


def workspace_limits(robot: Robot, leg: int, margin: float) -> tuple[Array, Array, dict[str, Array]]:
    """Limits of what `_beyond` looks at, in its order, and the figures of the limb that it reads.

    Args:
        robot: the robot.
        leg: 0 … 3.
        margin: distance from the limits of hip_yaw and the steering joint, rad.
    """
    data = robot.leg_list[leg]
    low, high = [-np.array(robot.box[:2])], [np.array(robot.box[:2])]
    limb = data.limb
    if limb is None:
        return np.concatenate(low), np.concatenate(high), {}
    low.append(np.square([limb.extension[0], limb.radius_min]))
    high.append(np.array([limb.extension[1] ** 2, OPEN]))
    if data.foot == "steerable":
        ranges = np.array([limb.hip_yaw, limb.steering_joint])
        low.append(ranges[:, 0] + margin)
        high.append(ranges[:, 1] - margin)
    figures = {
        "hip": np.array(limb.hip),
        "offset": np.array([limb.plane_offset]),
        "direction": np.array([limb.direction], dtype=float),
        "ankle_height": np.array([limb.ankle_height]),
    }
    return np.concatenate(low), np.concatenate(high), figures
