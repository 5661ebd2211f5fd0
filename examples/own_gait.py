"""A gait of your own: a contact schedule spelled out leg by leg. Here a trot on rolling wheels.

python examples/own_gait.py
"""

import numpy as np
from numpy.typing import NDArray

import rollgait as rg

LEGS = ("FL", "FR", "HL", "HR")


def trot(steps: int, begin: float, swing: float, pause: float) -> rg.Schedule:
    """Diagonal pairs lift in turn: `steps` swings of `swing` seconds, `pause` seconds apart."""
    swings: dict[str, tuple[tuple[float, float], ...]] = dict.fromkeys(LEGS, ())
    for step in range(steps):
        lift_off = begin + step * (swing + pause)
        for leg in ("FL", "HR") if step % 2 == 0 else ("FR", "HL"):
            swings[leg] += ((round(lift_off, 3), round(lift_off + swing, 3)),)
    FL, FR, HL, HR = (swings[leg] for leg in LEGS)
    return rg.Schedule(clearance=0.05, FL=FL, FR=FR, HL=HL, HR=HR)


def show(schedule: NDArray[np.bool_]) -> None:
    """Gait diagram: a line per leg, # on the ground."""
    for leg, contact in zip(LEGS, schedule, strict=True):
        print(f"  {leg} {''.join('#' if down else '.' for down in contact)}")


def main() -> None:
    scenario = rg.Scenario(
        robot="centauro",
        goal=rg.Goal(x=0.8),
        horizon=4.0,
        interval=0.05,
        gait=trot(steps=6, begin=0.8, swing=0.3, pause=0.1),
    )
    show(scenario.schedule.contact)
    plan = rg.plan(scenario)
    s = plan.sample_every(rate=200.0)
    print(f"\nsolved in {plan.statistics.solve_time:.1f} s, {plan.statistics.iterations} iterations")
    print(f"forward by           {s.com_position[-1, 0]:6.3f} m")
    _, pitch, roll = np.degrees(np.abs(s.euler).max(axis=0))
    print(f"largest roll, pitch  {roll:6.2f} deg {pitch:6.2f} deg")
    print(f"sway of the CoM      {1000 * np.ptp(s.com_position[:, 1]):6.1f} mm")
    print(f"certificate          {'passed' if plan.certificate().passed else 'FAILED'}")

    # all feet in the air at once is nothing that wheels can do
    try:
        rg.plan(scenario.with_values({f"gait.{leg}": [[1.0, 1.3]] for leg in LEGS}))
    except rg.InputError as error:
        print(f"\na jump: {error}")


if __name__ == "__main__":
    main()
