#!/usr/bin/env python3
"""How long a turn of a brain in Python takes, beside a bare gRPC stream, and with ten robots in a stream.

    python crates/bench/python/turn.py [--pairs 9] [--seconds 100] [--json FILE]

It needs the packages of client/python (`pip install -e client/python`), and starts the program that BAUDBOT names, or else
target/release/baudbot.

A turn is one message from the server and its answer. The world is `wander`: readings every 20 ms over 9600 baud, in lockstep,
in which the server simulates two ticks of 10 ms between two turns and the brain says what it waits for (`until_message`). The
server is another process; both are connected by a Unix socket. Four kinds of runs take turns, A B C D A B C D:

- A `one`: a robot, driven by a class of the package (`attach`).
- B `one, bare`: the same robot, driven by a loop over the generated stubs and messages, as short as one can write it.
- C `ten`: ten such robots in one stream: a turn has the readings of all ten, and its answer has ten commands.
- D `ten, bare`: the same ten by the bare loop.

All four decide by the same function. A and B, and C and D, must end with the same fingerprint of the world: they had the same
turns and gave the same answers. A run is timed from its first turn to its end, by three clocks:

- the wall clock, with the server's part and whatever else the machine does;
- the processor time of the brain's process, all its threads: what Python and gRPC do;
- the processor time of the server's process: of ten robots, it simulates ten times as much.

What is printed is the median over the rounds of the time of a turn, and the median, the least and the greatest of the ratios
A / B, C / D and C / A by the first two clocks.
"""

from __future__ import annotations

import argparse
import json
import os
import queue
import statistics
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import baudbot
from baudbot import scenarios
from baudbot.channel import open_channel
from baudbot.v1 import brain_link_pb2 as pb
from baudbot.v1.brain_link_pb2_grpc import BrainLinkServiceStub

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "client/python/tests"))
from server import Server  # noqa: E402

SENSORS = ("ir_left", "ir_front_left", "ir_front", "ir_front_right", "ir_right")
PATIENCE_NS = 100_000_000


def decide(left, front_left, front, front_right, right):
    """A Braitenberg vehicle: away from what is near."""
    near_left, near_right = max(left, front_left, 0.5 * front), max(right, front_right)
    return 0.3 - near_right, 0.3 - near_left


class Vehicle(baudbot.Brain):
    """The brain as one writes it with the package."""

    clock = None  # of the run's first robot

    def start(self):
        if Vehicle.clock is None:
            Vehicle.clock = Clock()

    def step(self, turn):
        value = turn.value
        return baudbot.drive(*decide(*[value(name, 0.0) for name in SENSORS]))


class Clock:
    """Measures from now on."""

    server = 0  # number of the server's process

    def __init__(self):
        self.start = self.now_s()

    @classmethod
    def now_s(cls):
        """By each of the clocks, in seconds."""
        # User and system time, in ticks of 10 ms. The program's name before them has no spaces in it.
        user, system = Path(f"/proc/{cls.server}/stat").read_text().split()[13:15]
        ticks = int(user) + int(system)
        return {"wall": time.perf_counter(), "brain": time.process_time(), "server": ticks / os.sysconf("SC_CLK_TCK")}

    def stop(self, turns):
        """Microseconds a turn, by each of the clocks."""
        return {clock: (end - self.start[clock]) / turns * 1e6 for clock, end in self.now_s().items()}


def package(address, world, robots):
    """A run by the package: the times of a turn."""
    Vehicle.clock = None
    turns = baudbot.attach(Vehicle, connect=address, world=world, robots=robots).turns
    return Vehicle.clock.stop(turns / len(robots))


def bare(address, world, robots):
    """A run by a bare loop: the times of a turn."""
    requests = queue.SimpleQueue()
    hello = pb.Hello(world=world, robots=robots, mode=pb.PORT_MODE_MESSAGES, thinks_as_scenario=True)
    requests.put(pb.AttachRequest(hello=hello))
    with open_channel(address) as channel:
        responses = BrainLinkServiceStub(channel).Attach(iter(requests.get, None))
        order = [[one.sensor for one in robot.sensors] for robot in next(responses).welcome.robots]
        assert all(names == list(SENSORS) for names in order), order
        clock, turns = Clock(), 0
        for response in responses:
            if not response.HasField("turn"):
                break
            turns += 1
            request = pb.AttachRequest()
            step = request.step
            step.turn = response.turn.turn
            for part in response.turn.robots:
                values = [0.0] * len(SENSORS)
                for reading in part.readings:
                    values[reading.sensor] = reading.values[0]
                answer = step.robots.add(robot=part.robot)
                answer.command.left_signal, answer.command.right_signal = decide(*values)
                answer.until_message.at_latest_ns = part.at_ns + PATIENCE_NS
            requests.put(request)
        times = clock.stop(turns)
        requests.put(None)
        responses.cancel()
    return times


def scenario(robots):
    """`wander` with so many of its robots, which stand beside one another and stop at what they run into."""
    head, marker, robot = scenarios.read("wander").partition("[[robots]]")
    text = head.replace('collision = "stop-run"', 'collision = "stop-robot"')
    for i in range(robots):
        x_m, y_m = -1.2 + 0.6 * (i % 5), 0.5 * (i // 5)
        place = f'name = "robot-{i}"\nstart = {{ x_m = {x_m}, y_m = {y_m}, heading_rad = {i % 5 - 2.0} }}'
        kept = [line for line in robot.splitlines() if not line.startswith(('name = "robot"', "start ="))]
        text += "\n".join([marker, place, *kept, ""])
    return text


def run(client, drive, robots, seconds):
    """A world of its own from its start to its end: the times of a turn, and the world's fingerprint."""
    world = client.create_world(scenario(robots), "turns", set={"end.after_s": seconds})
    try:
        times = drive(client.address, world.name, world.robots)
        return times, world.hash
    finally:
        world.delete()


KINDS = {"one": (package, 1), "one, bare": (bare, 1), "ten": (package, 10), "ten, bare": (bare, 10)}
RATIOS = (("one", "one, bare"), ("ten", "ten, bare"), ("ten", "one"))


def measure(client, rounds, seconds):
    """The times of each kind, round by round; the first round warms up and is left out."""
    found = {kind: [] for kind in KINDS}
    for number in range(rounds + 1):
        hashes = {}
        for kind, (drive, robots) in KINDS.items():
            times, hashes[kind] = run(client, drive, robots, seconds)
            if number:
                found[kind].append(times)
        for kind in ("one", "ten"):
            assert hashes[kind] == hashes[f"{kind}, bare"], f"the runs of {kind} robots differ: {hashes}"
    return found


def report(found):
    """For people."""
    print(f"{'µs a turn':12}{'wall clock':>12}{'brain':>12}{'server':>12}")
    for kind, rounds in found.items():
        medians = [statistics.median(times[clock] for times in rounds) for clock in ("wall", "brain", "server")]
        print(f"{kind:12}" + "".join(f"{median:12.1f}" for median in medians))
    for clock, name in (("wall", "by the wall clock"), ("brain", "by the processor time of the brain's process")):
        print(f"{name}:")
        for above, below in RATIOS:
            ratios = [a[clock] / b[clock] for a, b in zip(found[above], found[below], strict=True)]
            middle = f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
            print(f"  {f'({above}) / ({below})':24} {middle}, {len(ratios)} rounds")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=9, help="rounds; each runs all four kinds (default 9)")
    parser.add_argument("--seconds", type=float, default=100.0, help="simulated seconds of a run; 50 turns each (default 100)")
    parser.add_argument("--json", help="file for the times of all runs")
    arguments = parser.parse_args()
    load = os.getloadavg()[0]
    with TemporaryDirectory() as folder:
        server = Server(folder, "wander", "--paused")
        Clock.server = server.process.pid
        try:
            with baudbot.Client(server.unix) as client:
                found = measure(client, arguments.pairs, arguments.seconds)
        finally:
            server.kill()
    report(found)
    print(f"load of the machine: {load:.1f} before, {os.getloadavg()[0]:.1f} after, on {os.cpu_count()} processors")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(found) + "\n")


if __name__ == "__main__":
    main()
