"""A scenario built in Python, and a sweep of one of its weights: how much to pay for steering?

python examples/own_scenario.py
"""

import numpy as np

import rollgait as rg

PARKING = rg.Scenario(
    description="to the side and a little forward, as into a parking space",
    robot="centauro",
    goal=rg.Goal(x=0.4, y=0.5),
    horizon=6.0,
    interval=0.2,
    gait=rg.Drive(),
    weights=rg.Weights(acc=2.0),
)


def main() -> None:
    print("weight of yaw   steered deg   travelled m   missed mm   iterations")
    for weight in (0.5, 1.5, 15.0):
        scenario = PARKING.with_values({"weights.yaw": weight})
        plan = rg.plan(scenario)
        s = plan.sample_every(rate=100.0)
        steered = np.degrees(np.abs(np.diff(s.heading, axis=0)).sum(axis=0).mean())
        travelled = np.trapezoid(np.abs(s.speed).mean(axis=1), s.time)
        missed = 1000 * np.hypot(*(s.com_position[-1, :2] - [0.4, 0.5]))
        iterations = plan.statistics.iterations
        print(f"{weight:13.1f} {steered:13.1f} {travelled:13.3f} {missed:11.1f} {iterations:12d}")

    # what is wrong in a scenario is one sentence
    try:
        PARKING.with_values({"weights.jaw": 1.0})
    except rg.InputError as error:
        print(f"\na slip of the pen: {error}")

    # a scenario is text as well: this is what a YAML file of it holds
    print(f"\n{PARKING.to_yaml()}")


if __name__ == "__main__":
    main()
