"""A cost and a constraint of your own: each a small class that describes one instant.

    python examples/custom_cost.py

The expressions are CasADi's; `Instant` and `Foot` say what there is to write them in, with frames and units.
"""

import casadi as ca
import numpy as np

import rollgait as rg
from rollgait.ocp.context import PlanContext
from rollgait.ocp.term import INPUT, Data, Phase


class LowBody(rg.Cost):
    """(r_z − wanted)²: keeps the centre of mass at another height while the robot drives."""

    name = "low_body"

    def data(self, problem: PlanContext) -> dict[str, list[float]]:
        return {
            "wanted": [problem.scenario.height - 0.06]
        }  # m; data is a parameter, not part of the derivatives

    def expression(self, x: rg.Instant, d: Data) -> ca.SX:
        square: ca.SX = (x.r[2] - d.wanted) ** 2
        return square


class EvenLoad(rg.FootConstraint):
    """Every foot on the ground carries at least 15 % of the weight."""

    name = "even_load"
    places = INPUT  # forces are inputs, constant in an interval: once per interval is enough
    phase = Phase.STANCE
    lower = 0.15

    def expression(self, x: rg.Instant, foot: rg.Foot, d: Data) -> ca.SX:
        return foot.force[2] / x.body.weight


def report(title: str, plan: rg.Plan) -> None:
    s = plan.sample_every(rate=100.0)
    share = s.force[..., 2] / plan.robot.weight
    height = s.com_position[:, 2]
    print(
        f"{title:<18} {height.min():10.3f} {np.mean(height):10.3f} {100 * share.min():14.1f}"
        f" {100 * share.max():14.1f}   {'passed' if plan.certificate().passed else 'FAILED'}"
    )


def main() -> None:
    scenario = rg.Scenario(robot="centauro", goal=rg.Goal(x=1.2), horizon=4.0, interval=0.1, gait=rg.Drive())
    print("                    lowest m     mean m   least load %   most load %   certificate")
    report("as it is", rg.plan(scenario))
    report("with the cost", rg.plan(scenario, terms=[LowBody(weight=200.0)]))
    both = rg.plan(scenario, terms=[LowBody(weight=200.0), EvenLoad()])
    report("and the constraint", both)

    print("\ncosts of the last one:")
    for name, cost in both.statistics.costs.items():
        print(f"  {name:<14} {cost:8.3f}")


if __name__ == "__main__":
    main()
