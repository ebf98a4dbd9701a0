#!/usr/bin/env python3
"""How long a turn of a brain in Python takes, beside a bare gRPC stream, and with ten robots in a stream.

    python bench/python/turn.py [--pairs 9] [--seconds 100] [--json FILE]

It needs the packages of client/python (`pip install -e client/python`), and starts the program that BAUDBOT names, or else
target/release/baudbot.

A turn is one message from the server and its answer. The world is `wander`: readings every 20 ms over 9600 baud, in lockstep,
in which the server simulates two ticks of 10 ms between two turns and the brain says what it waits for (`until_message`). The
server is another process; both are connected by a Unix socket. Four kinds of runs take turns, A B C D A B C D:

- A `one`: a robot, driven by a class of the package (`attach`).
- B `one, bare`: the same robot, driven by a loop over the generated stubs and messages, as short as one can write it.
- C `ten`: ten such robots in one stream: a turn has the readings of all ten, and its answer has ten commands.
- D `ten, bare`: the same ten by the bare loop.

All four decide by the same function. A and B, and C and D, must end with the same fingerprint of the world, so they had the
same turns and gave the same answers. A run is timed from its first turn to its end, by the wall clock (with the server's
part, and whatever else the machine does) and by the processor time of the brain's process, all its threads (without both).
What is printed is, over the rounds, the median of a turn's time, and the median, the least and the greatest of the ratios
A / B, C / D and C / A.
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

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "client/python/tests"))
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
    """Measures from now on: wall-clock time and this process's processor time."""

    def __init__(self):
        self.wall_s, self.processor_s = time.perf_counter(), time.process_time()

    def stop(self, turns):
        """Microseconds a turn."""
        wall_s, processor_s = time.perf_counter() - self.wall_s, time.process_time() - self.processor_s
        return {"wall_us": wall_s / turns * 1e6, "processor_us": processor_s / turns * 1e6}


def package(address, world, robots):
    """A run by the package: the times of a turn."""
    Vehicle.clock = None
    turns = baudbot.attach(Vehicle, connect=address, world=world, robots=robots).turns
    return Vehicle.clock.stop(turns / len(robots))


def bare(address, world, robots):
    """A run by a bare loop: the times of a turn."""
    requests = queue.SimpleQueue()
    requests.put(pb.AttachRequest(hello=pb.Hello(world=world, robots=robots, mode=pb.PORT_MODE_MESSAGES, thinks_as_scenario=True)))
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
        place = f'name = "robot-{i}"\nstart = {{ x_m = {-1.2 + 0.6 * (i % 5)}, y_m = {0.5 * (i // 5)}, heading_rad = {i % 5 - 2.0} }}'
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
    for clock in ("wall_us", "processor_us"):
        print("wall-clock time" if clock == "wall_us" else "processor time of the brain's process")
        for kind, rounds in found.items():
            print(f"  {kind:10} {statistics.median(times[clock] for times in rounds):8.1f} µs a turn")
        for above, below in RATIOS:
            ratios = [a[clock] / b[clock] for a, b in zip(found[above], found[below], strict=True)]
            middle = f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
            print(f"  {above} / {below}: {middle}, {len(ratios)} rounds")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=9, help="rounds; each runs all four kinds (default 9)")
    parser.add_argument("--seconds", type=float, default=100.0, help="simulated seconds of a run; 50 turns each (default 100)")
    parser.add_argument("--json", help="file for the times of all runs")
    arguments = parser.parse_args()
    print(f"load of the machine before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} processors")
    with TemporaryDirectory() as folder:
        server = Server(folder, "wander", "--paused")
        try:
            with baudbot.Client(server.unix) as client:
                found = measure(client, arguments.pairs, arguments.seconds)
        finally:
            server.kill()
    report(found)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(found) + "\n")


if __name__ == "__main__":
    main()
