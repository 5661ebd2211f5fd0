"""Drive a robot in real time on a rigid-body model: straight on, then a curve at a trot, and a push.

python examples/mpc.py
"""

from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.script import Script, TimedCommand, TimedPush
from rollgait.mpc.setup import make_loop


def main() -> None:
    straight = VelocityCommand(forward=0.4)
    curve = VelocityCommand(forward=0.3, turn_rate=0.3, gait="trot")
    script = Script(
        duration=8.0,
        commands=(TimedCommand(command=straight), TimedCommand(at=3.0, command=curve)),
        pushes=(TimedPush(at=5.0, force=(0.0, -100.0, 0.0)),),
    )
    log = make_loop("centauro", "rigid").run(script)
    report = log.report()
    x, y, _ = log.com_position[-1]
    print(f"{report.steps} steps of the controller, {report.median_ms:.1f} ms each, {report.late} too late")
    print(f"forward velocity within {1e3 * report.forward_rms:.0f} mm/s (rms) of what was asked for")
    print(f"ends at x = {x:.2f} m, y = {y:.2f} m: {report.verdict}")


if __name__ == "__main__":
    main()
