"""Plan a motion of the library, look at it at any time, see its certificate, save it and load it again.

python examples/plan_and_sample.py [folder]     (writes into ./out if no folder is given)
"""

import sys
from pathlib import Path

import numpy as np

import rollgait as rg


def main(folder: Path) -> None:
    plan = rg.plan("hybrid-forward")
    statistics = plan.statistics
    print(f"solved in {statistics.solve_time:.1f} s, {statistics.iterations} iterations")

    print("\n time s   CoM x m   pitch deg   speed of FL m/s   feet on the ground")
    for time in np.linspace(0.0, plan.horizon, 6):
        now = plan.sample(time)
        down = " ".join(
            leg for leg, touches in zip(("FL", "FR", "HL", "HR"), now.contact, strict=True) if touches
        )
        print(
            f"{time:7.2f} {now.com_position[0]:9.3f} {np.degrees(now.euler[1]):11.2f} "
            f"{now.speed[0]:17.3f}   {down}"
        )

    # many times at once: arrays with the time as their first axis
    samples = plan.sample_every(rate=200.0)
    print(f"\nhighest lift of a foot   {samples.foot_position[..., 2].max() * 1000:6.1f} mm")
    print(f"largest force on a foot  {samples.force[..., 2].max():6.1f} N")

    certificate = plan.certificate()
    print(f"\ncertificate: {'passed' if certificate.passed else 'FAILED'}; the rows about the dynamics:")
    for row in certificate.rows:
        if row.name.endswith("_defect"):
            print(f"  {row.description:<58} {row.worst:8.1e} {row.unit}")

    file = plan.save(folder / "hybrid-forward.npz")
    again = rg.Plan.load(file)
    same = np.array_equal(again.sample(1.0).force, plan.sample(1.0).force)
    print(f"\nsaved as {file} and loaded again: {'the same' if same else 'something else'}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
