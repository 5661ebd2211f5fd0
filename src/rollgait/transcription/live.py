"""A transcription whose numbers stay open: the controller's, solved again and again as time goes on.

The same step and the same contract of terms as the planner's. What differs: contact enters as data (the
share of each interval in which a foot stands, so that a step may come between nodes), foot heights are a
known profile, costs are squares (Gauss-Newton), and nothing is presolved: one structure for all schedules.

Forces are means over their interval, f̄ = share · f. Where a foot does not stand at all its force has no
effect, and a small cost keeps it at zero; the same with the rolling of a locked wheel.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, ClassVar, Final

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.dynamics.ground import MODEL_SIZE
from rollgait.dynamics.step import FootInput, State, step
from rollgait.dynamics.wrench import WRENCH_SIZE
from rollgait.ocp.context import Context
from rollgait.ocp.costs import FORCE_INTERVAL_REF
from rollgait.ocp.friction import Friction
from rollgait.ocp.instant import Inputs, Instant
from rollgait.ocp.term import Cost, Place
from rollgait.robot.robot import Robot
from rollgait.transcription.base import Structure
from rollgait.transcription.code import CodeStore, StageSymbols
from rollgait.transcription.layout import Layout, StageLayout
from rollgait.transcription.nlp import Block, Nlp
from rollgait.transcription.stage import Stage, find_code
from rollgait.transcription.states import figures, instant_of, state_entries, state_of
from rollgait.transcription.uses import Outline, outline

Array = NDArray[np.float64]

FEET: Final = 4
INPUT_COSTS: Final = ("force", "speed", "yaw", "share", "idle")
"""Costs of the inputs, which belong to this transcription: they are about means over an interval."""
TERRAIN: Final[tuple[tuple[str, int], ...]] = (
    ("ground_model", FEET * MODEL_SIZE),
    ("contact_slope", FEET * 2),
    ("foot_radius", FEET),
    ("base_tilt", 4),
)
"""What a stage knows of ground that is not level: names and sizes. The first three are of what is under each
foot, the last pitch and roll that it asks for at both ends: feet are seen from a base so tilted."""


def _layout(robot: Robot) -> StageLayout:
    """The layout of a robot's variables."""
    steerable = tuple(i for i, leg in enumerate(robot.leg_list) if leg.foot == "steerable")
    state = [("theta", 3), ("L", 3), ("r", 3), ("dr", 3), ("xy", 2 * FEET), ("sigma", len(steerable))]
    node = Layout([*state, ("previous_force", 3 * FEET), ("previous_speed", FEET)])
    inputs = Layout([("force", 3 * FEET), ("motion", 2 * FEET)])
    return StageLayout(node, inputs, steerable, sum(size for _, size in state))


class LiveStage:
    """A stage whose numbers are filled in by name before each solve."""

    def __init__(
        self,
        recipe: _IntervalStage | _EndStage,
        costs: Sequence[Cost],
        context: Context,
        count: int,
        store: CodeStore | None,
    ) -> None:
        self._costs, self._is_end = tuple(costs), recipe.terminal
        code = find_code(recipe, recipe.outline(costs, context), store)
        self._places: dict[str, slice] = {}
        size = 0
        for name, length in code.parameters:
            self._places[name] = slice(size, size + length)
            size += length
        self._row_places: dict[str, slice] = {}
        begin = 0
        for group in code.groups:
            self._row_places[group.source] = slice(begin, begin + group.count)
            begin += group.count
        is_equation = np.zeros((begin, 1), dtype=bool)
        if "dynamics" in self._row_places:
            is_equation[self._row_places["dynamics"]] = True
        self.stage = Stage(
            code=code,
            # Fortran order: the solver reads these very numbers, stage after stage
            parameters=np.zeros((size, count), order="F"),
            lower=np.where(is_equation, 0.0, -np.ones((begin, count))),
            upper=np.where(is_equation, 0.0, np.ones((begin, count))),
            holds=np.ones((begin, count), dtype=bool),
            weight=context.robot.weight,
        )
        for cost in self._costs:
            if self.has(f"{cost.name}_weight"):
                self.numbers(f"{cost.name}_weight")[:] = cost.weight
        self.put_terms(self._costs, context)

    def numbers(self, name: str) -> Array:
        """The numbers of a parameter, (size, count): a view to write to."""
        return self.stage.parameters[self._places[name]]

    def has(self, name: str) -> bool:
        """Whether there is such a parameter."""
        return name in self._places

    def rows(self, name: str) -> slice:
        """Which rows of the stage have this name."""
        return self._row_places[name]

    def put_terms(self, costs: Sequence[Cost], context: Context) -> None:
        """Writes what the terms say of themselves in a context; at the end, of its last interval."""
        for cost in costs:
            if self.has(f"{cost.name}_weight"):
                for name, value in cost.data(context).items():  # type: ignore[arg-type]
                    self._put(f"{cost.name}_{name}", value)

    def _put(self, name: str, value: ArrayLike) -> None:
        array = np.atleast_1d(np.asarray(value, dtype=float))
        array = array[:, None] if array.ndim == 1 else array
        self.numbers(name)[:] = array[:, -1:] if self._is_end else array


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
    name: ClassVar[str] = "live"


def transcribe(
    costs: Sequence[Cost],
    context: Context,
    store: CodeStore | None = None,
    terrain: bool = False,
    pulled: bool = False,
) -> LiveProblem:
    """The problem of a controller with these costs.

    Args:
        costs: sums of squares, besides those of the inputs.
        context: robot and horizon, and the first numbers of the terms.
        store: keeps the code of the stages.
        terrain: whether the ground has slopes; level ground costs less.
        pulled: whether there are wrenches from outside; none cost less.

    Raises:
        InputError: a cost is no sum of squares.
    """
    robot, count = context.robot, context.schedule.intervals
    layout = _layout(robot)
    interval = LiveStage(_IntervalStage(layout, terrain, pulled), costs, context, count, store)
    end = LiveStage(_EndStage(layout, terrain), costs, context, 1, store)
    interval.stage.holds[layout.last : layout.node.size, -1] = False
    rows = interval.stage.code.rows
    nlp = Nlp(
        [
            Block(interval.stage, layout.variables(count), next_state=layout.defined(rows)),
            Block(end.stage, layout.last_variables(count), first=count),
        ],
        layout.total(count),
        initial=np.zeros(layout.node.size),
        live=True,
    )
    structure = Structure(
        nx=(0, *[layout.node.size] * (count - 1), layout.last),
        nu=(*[layout.inputs.size] * count, 0),
        ng=(*[rows - layout.node.size] * count, 0),
    )
    return LiveProblem(robot, nlp, structure, layout, interval, end)


# -- stages ----------------------------------------------------------------------------------------------


class _Symbols:
    """What both stages read: figures of the robot, known heights of the feet."""

    def __init__(self, symbols: StageSymbols) -> None:
        self.body, self.figures = symbols.body, figures(symbols)
        inertia = symbols["inertia"]
        self.momentum = (inertia[0] + inertia[3] + inertia[5]) / 3.0
        self.foot_height = symbols["foot_height"]

    def instant(self, x: State, inputs: Inputs) -> Instant:
        """The instant of a state; how fast feet rise is known, and no term asks for it."""
        height = ca.vertsplit(self.foot_height)
        return instant_of(self.body, self.figures, x, height, [ca.SX(0)] * FEET, inputs, Inputs.none())


@dataclass(frozen=True)
class _IntervalStage:
    """The stage of an interval."""

    layout: StageLayout
    terrain: bool
    pulled: bool
    name: ClassVar[str] = "live interval"
    places: ClassVar[Mapping[Place, int]] = {}
    terminal: ClassVar[bool] = False
    only_at_nodes: ClassVar[bool] = True
    worth_compiling: ClassVar[bool] = True
    own: ClassVar[tuple[tuple[str, int], ...]] = (
        ("foot_height", FEET),
        ("stands", FEET),
        ("moves", 2 * FEET),
        ("lift_rate", 2 * FEET),
        ("mu", 1),
        ("speed_ref", FEET),
        ("force_ref", 3 * FEET),
        *((f"{name}_weight", 1) for name in INPUT_COSTS),
    )

    @property
    def extra(self) -> Sequence[tuple[str, int]]:
        """Parameters beside those that every stage has."""
        wrench = (("wrench", WRENCH_SIZE),) if self.pulled else ()
        return (*self.own, *(TERRAIN if self.terrain else ()), *wrench)

    def outline(self, costs: Sequence[Cost], context: Any) -> Outline:
        """What the code of the stage depends on."""
        return outline(self.name, costs, context, self.places, self.terminal, self.extra)

    def write(self, symbols: StageSymbols) -> ca.SX:
        own, layout = _Symbols(symbols), self.layout
        body, h = own.body, own.body.interval
        node, u = ca.SX.sym("node", layout.node.size), ca.SX.sym("inputs", layout.inputs.size)
        following = ca.SX.sym("next_node", layout.node.size)
        force, motion = u[layout.inputs["force"]], u[layout.inputs["motion"]]
        stands, moves, lift_rate = symbols["stands"], symbols["moves"], symbols["lift_rate"]
        effective = [stands[i] * force[3 * i : 3 * i + 3] for i in range(FEET)]
        motions = [moves[2 * i : 2 * i + 2] * motion[2 * i : 2 * i + 2] for i in range(FEET)]
        begin = state_of(layout, node, own.momentum, own.foot_height, own.body)
        feet = [
            FootInput(
                ca.vertsplit(body.weight * effective[i]),
                ca.vertsplit(motions[i]),
                [lift_rate[2 * i], lift_rate[2 * i + 1]],
            )
            for i in range(FEET)
        ]
        wrench = None if body.wrench is None else ca.vertsplit(body.wrench)
        end, middle = step(ca, begin, feet, h, own.figures, body.terrain, wrench)
        reached = ca.vertcat(*state_entries(layout, end, own.momentum), force, motion[0::2])
        symbols.add_rows(following - reached, "dynamics", Place.INTERVAL_END.name)

        no_lift = [ca.SX.zeros(2)] * FEET
        symbols.add_squares(
            own.instant(begin, Inputs([body.weight * f for f in effective], motions, no_lift)), h
        )

        def add(name: str, factor: ca.SX, residual: ca.SX) -> None:
            symbols.add_square(name, symbols[f"{name}_weight"] * factor, residual)

        change = body.weight * (force - node[layout.node["previous_force"]])
        add("force", FORCE_INTERVAL_REF**2 / h, change)
        add("speed", h, motion[0::2] - symbols["speed_ref"])
        add("yaw", h, motion[1::2])
        add("share", h, force - symbols["force_ref"])
        idle = [(1 - stands[i]) * force[3 * i : 3 * i + 3] for i in range(FEET)]
        add("idle", h, ca.vertcat(*idle, (1 - moves) * motion))

        friction, data = Friction(), SimpleNamespace(mu=symbols["mu"])
        cones = own.instant(middle, Inputs([force[3 * i : 3 * i + 3] for i in range(FEET)], motions, no_lift))
        room = ca.vertcat(*(friction.expression(cones, foot, data) for foot in cones.feet))
        at = Place.NODE.name
        symbols.add_rows(room, "friction", at, unit="mg")
        pressing = force[2::3]
        if self.terrain:  # along the normal
            pressing = ca.vertcat(*(foot.force_contact[2] for foot in cones.feet))
        symbols.add_rows(pressing, "force", at, unit="mg")
        symbols.add_rows(motion[0::2], "first_motion", at, unit="m/s")
        symbols.add_rows(motion[1::2], "second_motion", at, unit="rad/s")
        symbols.add_rows(motion[0::2] - node[layout.node["previous_speed"]], "acceleration", at, unit="m/s")
        return ca.vertcat(node, u, following)


@dataclass(frozen=True)
class _EndStage:
    """The stage of the end: costs of states alone, `factor` intervals long, and terminal ones."""

    layout: StageLayout
    terrain: bool
    name: ClassVar[str] = "live end"
    places: ClassVar[Mapping[Place, int]] = {}
    terminal: ClassVar[bool] = True
    only_at_nodes: ClassVar[bool] = False
    worth_compiling: ClassVar[bool] = True
    own: ClassVar[tuple[tuple[str, int], ...]] = (("foot_height", FEET), ("factor", 1))

    @property
    def extra(self) -> Sequence[tuple[str, int]]:
        """Parameters beside those that every stage has."""
        return (*self.own, *(TERRAIN if self.terrain else ()))

    def outline(self, costs: Sequence[Cost], context: Any) -> Outline:
        """What the code of the stage depends on: the costs that read no inputs, which there are none of."""
        plain = outline(self.name, costs, context, self.places, False, self.extra)
        last = outline(self.name, costs, context, self.places, True)
        of_states = (use for use in plain.uses if not use.reads_inputs(plain.kinds))
        return replace(plain, uses=(*of_states, *last.uses))

    def write(self, symbols: StageSymbols) -> ca.SX:
        own = _Symbols(symbols)
        node = ca.SX.sym("node", self.layout.last)
        x = own.instant(state_of(self.layout, node, own.momentum, own.foot_height, own.body), Inputs.none())
        symbols.add_squares(x, symbols["factor"] * own.body.interval)
        return node
