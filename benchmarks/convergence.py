"""How fast do the transcriptions converge? Prints Markdown tables; docs/convergence.md keeps a result.

    python benchmarks/convergence.py

First as integrators: the robot tumbles and steers under fixed inputs, and its state at the end is compared
with an integration by the certificate's physics (DOP853). Then as transcriptions of an optimal control
problem: a smooth drive is planned on meshes of half the interval each, and compared with the finest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve

import rollgait as rg
from rollgait.ocp.problem import Problem, make_problem
from rollgait.plan.certificate.physics import (
    BodyState,
    Inputs,
    angular_velocity_world,
    derivative,
    rotation_angle,
    rotation_world_base,
)
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import Trajectory
from rollgait.scenario import ContactSchedule, Mesh
from rollgait.transcription import TRANSCRIPTION_NAMES, transcribe
from rollgait.transcription.guess import MotionGuess, kinematic_guess

Array = NDArray[np.float64]

# -- fixed inputs --------------------------------------------------------------------------------------------

HORIZON = 0.6
"""s; short enough to stay away from a pitch of 90°."""
FORCE = np.array([[20.0, 30.0, 250.0], [-30.0, 10.0, 300.0], [10.0, -20.0, 240.0], [15.0, 5.0, 200.0]])
"""N, on each foot, world."""
SPEED = np.array([0.5, -0.4, 0.6, 0.3])  # m/s
HEADING_RATE = np.array([1.5, -1.0, 0.8, 2.0])  # rad/s
START_EULER = np.array([0.4, -0.1, 0.2])  # rad
START_RATE = np.array([0.3, -0.2, 0.1, 1.0, 0.6, -0.8])  # m/s, rad/s


def tumbling(mesh: Mesh) -> Problem:
    """A problem without terms, so that only the dynamics is left; the robot starts turning about all axes."""
    scenario = rg.Scenario(robot="centauro-2020", goal={"x": 0.0}, horizon=HORIZON, profile="paper")
    schedule = ContactSchedule(np.ones((4, mesh.intervals), dtype=bool), mesh)
    problem = make_problem(scenario, schedule=schedule)
    base = problem.start.base + np.concatenate([np.zeros(3), START_EULER])
    return replace(problem, terms=(), start=replace(problem.start, base=base, base_rate=START_RATE))


def simulated(name: str, problem: Problem) -> Trajectory:
    """The motion from x0 under the fixed inputs: the transcription's dynamics, solved by Newton's method."""
    transcribed = transcribe(name, problem)
    nlp = transcribed.nlp
    w = transcribed.encode(_driven(problem, 0.0))
    state = w == transcribed.encode(_driven(problem, 1.0))
    for _ in range(30):
        g, jacobian = nlp.functions["nlp_jac_g"](w, nlp.parameters)
        columns = csc_matrix(jacobian.sparse())[:, state]
        rows = np.flatnonzero(np.diff(columns.tocsr().indptr))
        assert rows.size == state.sum(), "as many equations as unknowns"
        step = spsolve(columns.tocsr()[rows].tocsc(), -np.asarray(g).ravel()[rows])
        w[state] += step
        if np.abs(step).max() < 1e-11:
            return transcribed.decode(w)
    raise RuntimeError("Newton's method did not converge")


def _driven(problem: Problem, more: float) -> MotionGuess:
    """The fixed inputs; with `more` added to each of them, to tell inputs from states."""
    guess = kinematic_guess(problem)

    def motion(times: Array) -> Samples:
        n = times.size
        return replace(
            guess(times),
            force=np.tile(FORCE, (n, 1, 1)) + more,
            speed=np.tile(SPEED, (n, 1)) + more,
            heading_rate=np.tile(HEADING_RATE, (n, 1)) + more,
            foot_velocity=np.full((n, 4, 3), more),
        )

    return motion


def integrated(problem: Problem) -> BodyState:
    """The state at the end by the certificate's physics."""
    start = problem.start
    begin = BodyState(
        position=start.base[:3],
        velocity=start.base_rate[:3],
        rotation=rotation_world_base(start.base[3:]),
        angular_velocity=angular_velocity_world(start.base[3:], start.base_rate[3:]),
        foot=start.p_foot,
        heading=start.heading,
    )
    inputs = Inputs(FORCE, SPEED, np.zeros(4), np.zeros(4), HEADING_RATE)

    def right_side(t: float, y: Array) -> Array:
        return derivative(problem.robot, BodyState.from_flat(y), inputs).flat()

    solution = solve_ivp(right_side, (0.0, HORIZON), begin.flat(), method="DOP853", rtol=1e-12, atol=1e-13)
    return BodyState.from_flat(solution.y[:, -1])


def errors_at_the_end(name: str, mesh: Mesh) -> dict[str, float]:
    """Errors of the state at the end: of the CoM and the feet in m, the orientation in rad, ω in rad/s."""
    problem = tumbling(mesh)
    exact = integrated(problem)
    end = simulated(name, problem).sample(np.array([HORIZON]), problem.robot).at(0)
    omega = angular_velocity_world(end.euler, end.euler_rate)
    return {
        "CoM, m": float(np.linalg.norm(end.com_position - exact.position)),
        "orientation, rad": float(rotation_angle(rotation_world_base(end.euler), exact.rotation)),
        "ω, rad/s": float(np.linalg.norm(omega - exact.angular_velocity)),
        "feet, m": float(np.linalg.norm(end.foot_position - exact.foot, axis=1).max()),
    }


# -- an optimal control problem ------------------------------------------------------------------------------

DRIVE = rg.Scenario(
    robot="centauro-2020",
    profile="paper",
    goal={"x": 0.5, "y": 0.1, "yaw_deg": 10},
    horizon=4.0,
    # v = 0 in the last interval is another problem on each mesh
    bounds={"without": ["wheels_rest_at_end"]},
)


def distances_to_the_finest(name: str, intervals: list[float]) -> list[dict[str, float]]:
    """Distances of the plans on meshes of these intervals (s) to that of the last one."""
    plans = [
        rg.plan(DRIVE.with_values({"interval": h}), transcription=name, solver="ipopt") for h in intervals
    ]
    times = np.arange(0.0, DRIVE.horizon + 1e-9, intervals[0])  # nodes of every mesh
    finest, best = plans[-1].statistics.cost, plans[-1].sample(times)
    rows = []
    for plan in plans[:-1]:
        s = plan.sample(times)
        certificate = plan.certificate()
        rows.append(
            {
                "ΔJ / J": abs(plan.statistics.cost - finest) / finest,
                "CoM, m": float(np.linalg.norm(s.com_position - best.com_position, axis=1).max()),
                "angles, rad": float(np.linalg.norm(s.euler - best.euler, axis=1).max()),
                "feet, m": float(np.linalg.norm(s.foot_position - best.foot_position, axis=-1).max()),
                "defect, rad": certificate.row("angle_defect").worst,
                "defect, rad/s": certificate.row("angular_velocity_defect").worst,
            }
        )
    return rows


# -- tables --------------------------------------------------------------------------------------------------


def print_table(intervals: list[float], rows: list[dict[str, float]]) -> None:
    """A row for each interval; behind each error the order since the row above."""
    names = list(rows[0])
    print(f"| h, s | {' | '.join(f'{name} | order' for name in names)} |")
    print("|---|" + "---|---|" * len(names))
    for i, (h, row) in enumerate(zip(intervals, rows, strict=True)):
        cells = []
        for name in names:
            order = "" if i == 0 else _order(rows[i - 1][name], row[name])
            cells.append(f"{row[name]:.1e} | {order}")
        print(f"| {h:.4g} | {' | '.join(cells)} |")
    print()


def _order(coarse: float, fine: float) -> str:
    round_off = 1e-11
    return "" if fine < round_off else f"{np.log2(coarse / fine):.1f}"


def main() -> None:
    """Prints the tables."""
    study: Callable[[str, Mesh], dict[str, float]] = errors_at_the_end
    for name in TRANSCRIPTION_NAMES:
        print(f"### {name}: fixed inputs, {HORIZON} s, error at the end\n")
        counts = [2, 4, 8, 16]
        print_table([HORIZON / n for n in counts], [study(name, Mesh.equal(HORIZON, n)) for n in counts])
    for name in TRANSCRIPTION_NAMES:
        print(f"### {name}: a planned drive, {DRIVE.horizon:.0f} s, distance to the plan at h = 0.025 s\n")
        intervals = [0.4, 0.2, 0.1, 0.05, 0.025]
        print_table(intervals[:-1], distances_to_the_finest(name, intervals))


if __name__ == "__main__":
    main()
