"""Small problems for tests of the transcription."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.problem import Problem, make_problem
from rollgait.robot.library import find_robot
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import kinematic_guess

Array = NDArray[np.float64]

KINDS = ("steerable", "fixed", "point")
STEPPING = {"kind": "schedule", "HL": [[0.3, 0.6]]}


UNEVEN = (0.12, 0.18, 0.08, 0.22, 0.2, 0.1)
"""s; lengths of six intervals that end where the swing begins and ends, as six of 0.15 s do."""

CASES = (*KINDS, "uneven")
"""Problems that a transcription has to know: of each kind of foot, and on intervals that are not equal."""


def problem_of(case: str) -> Problem:
    """One of `CASES`."""
    return small_problem(lengths=UNEVEN) if case == "uneven" else small_problem(case)


def small_problem(
    kind: str = "steerable",
    robot: str = "centauro-2020",
    lengths: Sequence[float] | None = None,
    **values: Any,
) -> Problem:
    """Six intervals of 0.15 s, or of these lengths in s, with a swing of the hind left foot."""
    data: dict[str, Any] = {
        "robot": find_robot(robot).with_feet(kind),
        "goal": {"x": 0.05, "y": 0.01, "yaw_deg": 3},
        "horizon": 0.9,
        "interval": 0.15,
        "gait": STEPPING,
    }
    scenario = Scenario.from_dict(data | values)
    if lengths is None:
        return make_problem(scenario)
    schedule = ContactSchedule(scenario.schedule.contact, Mesh(np.array(lengths)))
    return make_problem(scenario, schedule=schedule)


def about_the_guess(transcribed: Transcribed, seed: int = 0, size: float = 0.1) -> Array:
    """Free variables near the guess, within their bounds, that obey nothing else."""
    guess = transcribed.encode(kinematic_guess(transcribed.problem))
    w = guess + np.random.default_rng(seed).uniform(-size, size, guess.shape)
    return np.clip(w, transcribed.nlp.lower, transcribed.nlp.upper)
