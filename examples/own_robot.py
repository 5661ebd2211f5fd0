"""A robot of your own: a light quadruped whose wheels cannot steer, and the same one on point feet.

python examples/own_robot.py [folder]     (writes its YAML file into ./out if no folder is given)
"""

import sys
from pathlib import Path

import numpy as np

import rollgait as rg
from rollgait.config import dump_yaml
from rollgait.robot.robot import FootKind, Inertia, Leg, Legs


def leg(x: float, y: float, foot: FootKind) -> Leg:
    return Leg(
        foot=foot,
        stance=(x, y, -0.50),  # nominal contact point from the centre of mass, m
        wheel_radius=0.10,  # m
        speed_max=2.0,  # m/s
        force_max=600.0,  # N
    )


def quadruped(foot: FootKind) -> rg.Robot:
    return rg.Robot(
        name="light",
        description="45 kg, wheels fixed to the legs",
        mass=45.0,  # kg
        inertia=Inertia(xx=1.2, yy=2.6, zz=3.0),  # about the centre of mass, base axes, kg m²
        box=(0.20, 0.12, 0.12),  # half-sizes of the space of a foot, m
        legs=Legs(
            FL=leg(0.36, 0.22, foot),
            FR=leg(0.36, -0.22, foot),
            HL=leg(-0.36, 0.22, foot),
            HR=leg(-0.36, -0.22, foot),
        ),
    )


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    print("feet     goal reached   largest wheel speed   feet apart at most   certificate")
    kinds: tuple[FootKind, FootKind] = ("fixed", "point")
    for foot in kinds:
        robot = quadruped(foot)
        scenario = rg.Scenario(
            robot=robot,
            # wheels that cannot steer get sideways and around by stepping only
            goal=rg.Goal(x=0.5, y=0.1, yaw_deg=15),
            horizon=6.0,
            interval=0.1,
            gait=rg.Crawl(steps=8, pause_start=0.5, pause_end=0.5),
            bounds=rg.Bounds(force_min=15.0),
        )
        plan = rg.plan(scenario)
        s = plan.sample_every(rate=100.0)
        end = s.com_position[-1]
        apart = np.linalg.norm(s.foot_position[:, 0, :2] - s.foot_position[:, 3, :2], axis=1).max()
        speed = np.abs(s.speed[s.contact]).max()
        verdict = "passed" if plan.certificate().passed else "FAILED"
        print(f"{foot:<8} ({end[0]:.3f}, {end[1]:.3f}) m {speed:15.3f} m/s {apart:18.3f} m   {verdict}")

    file = folder / "light.yaml"
    file.write_text(dump_yaml(quadruped("fixed").model_dump(mode="json")), encoding="utf-8")
    print(f"\nwritten: {file}; a scenario takes it as  robot: {file}")
    again = rg.find_robot(str(file))
    print(f"read again: {again.name}, {again.mass:.0f} kg, standing {again.height:.2f} m high")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
