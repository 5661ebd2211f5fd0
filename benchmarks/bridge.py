"""Two programs over the loopback: are messages lost, how late are they, does memory grow?

    python benchmarks/bridge.py [--minutes 10] [--quick]

One program sends joint states of 39 joints 100 times a second on the topics of ROS 2 (DDS), another one sends
each of them back as a joint command. A gap between two stamps is a lost message, as the bridge counts
them; that is compared with the true number. Half of the way there and back is the latency. Prints Markdown
and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from reporting import keep, load, machine, table
from rollgait.hardware.measured import Sensors, Stream
from rollgait.hardware.topics import JOINT_COMMANDS, decoded, encoded, nanoseconds_of
from rollgait.hardware.transports.dds import DdsTransport
from rollgait.ros.messages import joint_state
from rollgait.ros.topics import JOINT_STATES

DOMAIN = 96
JOINTS = tuple(f"joint_{k}" for k in range(39))
PERIOD = 0.01
FOUND_WITHIN = 10.0
ROUND_TRIP = 2
SPARE = 2000
"""Messages before the first that counts, at most: those of 10 s, twice."""
P99_MAX = 5.0
"""Latency that 99 % of the messages must keep, ms."""
GROWTH_MAX = 2.0
"""By how much the memory of a program may grow after its first tenth, MB."""
COLUMNS = (
    "program",
    "messages",
    "lost",
    "noticed",
    "median, ms",
    "p99, ms",
    "worst, ms",
    "memory, MB",
    "growth, MB",
)


def memory() -> float:
    """Of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


def echo(pipe: Connection) -> None:
    """The other program: what the bridge's sensors take is sent back, until the pipe is closed."""
    transport = DdsTransport(DOMAIN)
    sensors = Sensors(transport, JOINTS, time.perf_counter, PERIOD)
    transport.subscribe(JOINT_STATES, lambda data: transport.publish(JOINT_COMMANDS, data))
    transport.advertise([JOINT_COMMANDS])
    sizes: list[float] = []
    due = time.perf_counter()
    pipe.send("ready")
    while not pipe.poll():
        transport.receive(PERIOD)
        if time.perf_counter() > due:
            sizes.append(memory())
            due += 1.0
    pipe.recv()
    stream = sensors.streams[JOINT_STATES.name]
    pipe.send((stream.count, stream.lost, sizes))


def until(done: Callable[[], bool], transport: DdsTransport, seconds: float) -> None:
    """Receives until something is so."""
    end = time.perf_counter() + seconds
    while not done() and time.perf_counter() < end:
        transport.receive(0.05)


def measured(seconds: float) -> tuple[list[tuple[str, ...]], bool]:
    """Both programs' rows, and whether all is as it should be."""
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=echo, args=(there,), daemon=True)
    process.start()
    here.recv()
    transport = DdsTransport(DOMAIN)
    count, heard_here = round(seconds / PERIOD), 0
    stamps, times = np.full(count + SPARE, -1), np.full(count + SPARE, np.nan)  # lists would grow
    answers = Stream(PERIOD)

    def receive(data: bytes) -> None:
        nonlocal heard_here
        stamp = nanoseconds_of(decoded(JOINT_COMMANDS, data)["header"])
        if answers.admits(stamp):
            stamps[heard_here], times[heard_here] = stamp, time.perf_counter()
            heard_here += 1

    transport.subscribe(JOINT_COMMANDS, receive)
    transport.advertise([JOINT_STATES])
    row = np.zeros(len(JOINTS))

    def send(number: int) -> None:
        stamp = 10**9 + round(number * 1e9 * PERIOD)
        transport.publish(JOINT_STATES, encoded(JOINT_STATES, joint_state(stamp, JOINTS, row, row, row)))

    number = 0
    while not heard_here and number * PERIOD < FOUND_WITHIN:  # until the two have found one another
        send(number := number + 1)
        transport.receive(PERIOD)
    until(lambda: False, transport, 0.5)
    heard_here = 0
    answers.lost = 0
    first = number + 1
    sent = np.full(count, np.nan)
    sizes = []
    due = time.perf_counter()
    for k in range(count):
        sent[k] = time.perf_counter()
        send(first + k)
        if k % 100 == 0:
            sizes.append(memory())
        due += PERIOD
        while (left := due - time.perf_counter()) > 0.0:
            transport.receive(left)
    until(lambda: heard_here >= count, transport, 2.0)
    here.send("done")
    heard, noticed, others = here.recv()
    transport.close()
    numbers = np.rint((stamps[:heard_here] - 10**9) / (1e9 * PERIOD)).astype(int) - first
    ms = 1e3 * (times[:heard_here] - sent[numbers]) / ROUND_TRIP
    lost_back = count - len(set(numbers.tolist()))
    heard -= number  # those before the first that counts
    lost_there = count - heard
    figures = (np.median(ms), np.percentile(ms, 99.0), ms.max())
    told = [f"{x:.2f}" for x in figures]
    rows = [
        ("sends, hears the answers", str(count), str(lost_back), str(answers.lost), *told, *_sizes(sizes)),
        ("answers", str(heard), str(lost_there), str(noticed), "", "", "", *_sizes(others)),
    ]
    flat = max(_growth(sizes), _growth(others)) <= GROWTH_MAX
    all_noticed = noticed >= lost_there and answers.lost >= lost_back
    return rows, bool(figures[1] <= P99_MAX and flat and all_noticed)


def _growth(sizes: list[float]) -> float:
    """From the mean of the second tenth to that of the last, MB."""
    tenth = max(1, len(sizes) // 10)
    return float(np.mean(sizes[-tenth:]) - np.mean(sizes[tenth : 2 * tenth] or sizes[:1]))


def _sizes(sizes: list[float]) -> tuple[str, str]:
    return f"{sizes[-1]:.0f}", f"{_growth(sizes):+.2f}"


def main() -> None:
    """Runs both programs and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0, help="how long")
    parser.add_argument("--quick", action="store_true", help="five seconds, not kept")
    arguments = parser.parse_args()
    seconds = 5.0 if arguments.quick else 60.0 * arguments.minutes
    before = load()
    rows, passed = measured(seconds)
    text = (
        f"## Bridge\n\n{machine()}; load {before} before, {load()} after.\n"
        f"Joint states of 39 joints over DDS on the loopback, 100 Hz, {seconds:g} s, there and back. "
        "Latency is half of that way. `noticed`: lost messages that gaps in the stamps show the bridge.\n\n"
        f"{table(COLUMNS, rows)}\n\n"
        f"No loss unnoticed, p99 at most {P99_MAX:g} ms, memory flat within {GROWTH_MAX:g} MB: "
        f"{'yes' if passed else 'no'}."
    )
    print(text)
    if not arguments.quick:
        keep("bridge", text)


if __name__ == "__main__":
    main()
