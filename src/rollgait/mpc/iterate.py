"""The controller's iterate: states and inputs of the horizon, kept from step to step and shifted in time."""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.live import LiveProblem

Array = NDArray[np.float64]

SMALL_FORCE = 0.1
"""Of the weight: less than that is no sum of forces to be kept."""


class Iterate:
    """States (N + 1, n_x) and inputs (N, n_u) in the units of the variables.

    Attributes:
        states: at the nodes, the first being the measured one.
        inputs: of the intervals.
        previous: inputs before the horizon that costs and bounds refer to, (16,): forces, then speeds.
    """

    def __init__(self, problem: LiveProblem) -> None:
        layout, count = problem.layout, len(problem.structure.nx) - 1
        self._layout, self._count = layout, count
        self.states: Array = np.zeros((count + 1, layout.last))
        self.inputs: Array = np.zeros((count, layout.inputs.size))
        self.previous: Array = np.zeros(layout.node.size - layout.last)
        self.forget_contacts()
        self._w: Array = np.zeros(problem.nlp.size)
        self._rows = np.zeros((count, layout.stage))
        self._force, self._motion = layout.inputs["force"], layout.inputs["motion"]

    @property
    def first_node(self) -> Array:
        """The node from which the motion starts."""
        return np.concatenate([self.states[0], self.previous])

    def forget_contacts(self) -> None:
        """The forces are again those of a robot that stands on all feet."""
        self._share, self._usual = np.ones((4, self._count)), np.full((4, self._count), 0.25)

    def stand(self, state: Array, force: Array) -> None:
        """Begins anew: at rest in one state (n_x,), on vertical forces (4,) in weights of the robot."""
        self.states[:] = state
        self.inputs[:] = 0.0
        self.forget_contacts()
        self.inputs[:, self._force][:, 2::3] = force
        self.previous[:] = 0.0
        self.previous[2:12:3] = force

    def begin(self, state: Array, previous: Array) -> None:
        """The motion begins in this state (n_x,), after these inputs (16,)."""
        self.states[0] = state
        self.previous[:] = previous

    def with_variables(self, w: Array) -> Iterate:
        """A copy with other free variables of the problem."""
        other = copy.copy(self)  # what is made anew at each change is shared: shares, usual forces
        for name in ("states", "inputs", "previous", "_w", "_rows"):
            setattr(other, name, getattr(self, name).copy())
        other.take(w)
        return other

    def rest(self, state: Array) -> None:
        """Nothing moves any more: all nodes but the first are this state (n_x,), forces are the last."""
        self.states[1:] = state
        self.inputs[:, self._force] = self.previous[:12]
        self.inputs[:, self._motion] = 0.0

    def shift(self, share: float) -> None:
        """Moves on in time by a share of an interval (the last input is held)."""
        steps = int(share)
        for _ in range(min(steps, self._count)):
            self._move(1.0)
        self._move(share - steps)

    def _move(self, share: float) -> None:
        X, U = self.states, self.inputs
        last = X[-1] + share * (X[-1] - X[-2])
        X[:-1] += share * (X[1:] - X[:-1])
        X[-1] = last
        U[:-1] += share * (U[1:] - U[:-1])

    def adapt_forces(self, share: Array, low: Array, high: Array, usual: Array) -> None:
        """Makes the forces fit the contact schedule of now, so that one iteration has little to mend.

        Within the horizon the shift in time has done that; the last interval gets what standing still would
        change, as nothing follows it. All feet together carry what they did.

        Args:
            share: of each interval in which a foot stands, (4, N).
            low, high: limits of the vertical forces, (4, N), in the units of the variables.
            usual: vertical forces of standing still, (4, N).
        """
        force = self.inputs[:, self._force].reshape(self._count, 4, 3)
        stood, stands = self._share.T > 0.0, share.T > 0.0
        before = (force[:, :, 2] * stood).sum(axis=1)
        force[stands & ~stood] = 0.0
        force[-1, :, 2] += np.where(stands[-1], usual[:, -1] - self._usual[:, -1], 0.0)
        after = (force[:, :, 2] * stands).sum(axis=1)
        scale = np.where(after > SMALL_FORCE, before / np.maximum(after, SMALL_FORCE), 1.0)
        scaled = force[:, :, 2] * np.where(stands, scale[:, None], 1.0)
        force[:, :, 2] = np.minimum(np.maximum(scaled, low.T), high.T)
        self.inputs[:, self._force] = force.reshape(self._count, 12)
        self._share, self._usual = share, usual

    def variables(self) -> Array:
        """The free variables of the problem."""
        rows, layout = self._rows, self._layout
        rows[:, : layout.inputs.size] = self.inputs
        nodes = rows[:, layout.inputs.size :]
        nodes[:, : layout.last] = self.states[1:]
        nodes[:, layout.last : layout.last + 12] = self.inputs[:, self._force]
        nodes[:, layout.last + 12 :] = self.inputs[:, self._motion][:, 0::2]
        self._w[:] = rows.ravel()[: self._w.size]
        return self._w

    def take(self, w: Array) -> None:
        """Takes free variables of the problem for its own."""
        rows, layout = self._rows, self._layout
        flat = rows.reshape(-1)
        flat[: w.size] = w
        self.inputs[:] = rows[:, : layout.inputs.size]
        self.states[1:] = rows[:, layout.inputs.size : layout.inputs.size + layout.last]
