"""Small problems for tests of the transcription."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.problem import Problem, make_problem
from rollgait.robot.library import find_robot
from rollgait.scenario.scenario import Scenario
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import kinematic_guess

Array = NDArray[np.float64]

KINDS = ("steerable", "fixed", "point")
STEPPING = {"kind": "schedule", "HL": [[0.3, 0.6]]}


def small_problem(kind: str = "steerable", robot: str = "centauro-2020", **values: Any) -> Problem:
    """Six intervals of 0.15 s, with a swing of the hind left foot."""
    data: dict[str, Any] = {
        "robot": find_robot(robot).with_feet(kind),
        "goal": {"x": 0.05, "y": 0.01, "yaw_deg": 3},
        "horizon": 0.9,
        "interval": 0.15,
        "gait": STEPPING,
    }
    return make_problem(Scenario.from_dict(data | values))


def about_the_guess(transcribed: Transcribed, seed: int = 0, size: float = 0.1) -> Array:
    """Free variables near the guess, within their bounds, that obey nothing else."""
    guess = transcribed.encode(kinematic_guess(transcribed.problem))
    w = guess + np.random.default_rng(seed).uniform(-size, size, guess.shape)
    return np.clip(w, transcribed.nlp.lower, transcribed.nlp.upper)
