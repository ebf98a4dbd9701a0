#!/usr/bin/env python3
"""A brain in Python: drives about and turns away from what its infra-red sensors see.

Made from the bare contract, proto/baudbot/v1/brain_link.proto, and plain grpcio; ../README.md says how to run
it. A brain of your own is this file with another `decide`.
"""

import argparse
import math
import queue
import sys
from pathlib import Path

PYTHON = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(PYTHON / "generated"))
try:
    import grpc
    from baudbot.v1 import brain_link_pb2 as pb
    from baudbot.v1.brain_link_pb2_grpc import BrainLinkServiceStub
except ImportError as error:
    sys.exit(f"avoid.py: {error}; run: pip install -r {PYTHON}/requirements.txt && {PYTHON}/generate.sh")


class Avoid:
    # A reading is a nearness: 0 if nothing is in range, 1 if something is very near. With ARSim's sensors
    # 0.28 is a wall about 0.4 m away.
    TURN, CLEAR = 0.28, 0.2
    # A command is repeated after so long without news.
    REPEAT_NS = 100_000_000

    def __init__(self, body):
        # Where each infra-red sensor looks: 0 is straight on, positive is to the left. Those that look aside
        # or back are of no use here.
        bearings = {i: s.mount.heading_rad for i, s in enumerate(body.sensors) if s.kind == pb.SENSOR_KIND_IR}
        self.bearings = {i: b for i, b in bearings.items() if math.cos(b) > 0.3}
        self.nearness = {}  # last reading by sensor; empty until something has come over the cable
        self.sent_ns = -math.inf  # when the last command was sent
        self.spin = 0.0  # turning on the spot to the left (1) or to the right (-1), or driving (0)

    def step(self, turn):
        # What is not readable is an old reading, repeated. Without news there is nothing to say, and a command
        # at every tick would only queue up on a slow cable; now and then one goes out all the same, because
        # the cable may have lost the last one. In lockstep there are no turns in between, if we say what we wait for.
        if turn.at_ns < self.sent_ns:
            self.sent_ns = -math.inf  # the world was reset
        news = {r.sensor: r.values[0] for r in turn.readings if r.readable and r.sensor in self.bearings}
        self.nearness |= news
        command = None
        if news or turn.at_ns >= self.sent_ns + self.REPEAT_NS:
            left, right = self.decide()
            command = pb.Command(left_signal=left, right_signal=right)
            self.sent_ns = turn.at_ns
        until = pb.UntilMessage(at_latest_ns=self.sent_ns + self.REPEAT_NS)
        return pb.RobotStep(robot=turn.robot, command=command, until_message=until)

    def decide(self):
        nearest = max(self.nearness.values(), default=math.inf)
        if nearest == math.inf:
            return 0.0, 0.0  # has seen nothing yet: stand still
        if nearest < self.CLEAR:
            self.spin = 0.0
        elif nearest >= self.TURN and self.spin == 0.0:
            # Away from the nearer side, and the same way until all is clear: else it dithers in a corner.
            side = sum(near * math.sin(self.bearings[sensor]) for sensor, near in self.nearness.items())
            self.spin = -1.0 if side > 0.0 else 1.0
        if self.spin != 0.0:
            return -0.5 * self.spin, 0.5 * self.spin
        return 0.5 - nearest, 0.5 - nearest  # the nearer, the slower


def run(args):
    # Without this option grpcio calls the host of a Unix socket by its path, which servers refuse.
    options = [("grpc.default_authority", "localhost")] if args.connect.startswith("unix:") else []
    requests = queue.SimpleQueue()  # what is put here goes out on the stream
    with grpc.insecure_channel(args.connect, options) as channel:
        requests.put(pb.AttachRequest(hello=pb.Hello(world=args.world, robots=[args.robot], brain="avoid.py")))
        responses = BrainLinkServiceStub(channel).Attach(iter(requests.get, None))
        welcome = next(responses).welcome
        brain = Avoid(welcome.robots[0])
        if not brain.bearings:
            sys.exit(f"avoid.py: robot `{args.robot}` has no infra-red sensor that looks ahead")
        last_tick = math.inf
        for response in responses:
            if response.HasField("ended"):
                return print(f"the run ended at tick {response.ended.tick}")
            turn = response.turn
            last_tick = min(last_tick, turn.tick + args.seconds * 1e9 / welcome.step_ns)
            if turn.tick >= last_tick:
                return print(f"stopped at tick {turn.tick}")
            # Exactly one Step a Turn: in lockstep the world waits for it.
            robots = [brain.step(robot) for robot in turn.robots]
            requests.put(pb.AttachRequest(step=pb.Step(turn=turn.turn, robots=robots)))
        print("the server closed the stream")


if __name__ == "__main__":
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--connect", default="127.0.0.1:7400", help="HOST:PORT or unix:/PATH [%(default)s]")
    flags.add_argument("--world", default="wander", help="name of the world [%(default)s]")
    flags.add_argument("--robot", default="robot", help="name of the robot [%(default)s]")
    flags.add_argument("--seconds", type=float, default=math.inf, help="stop after so much simulated time")
    args = flags.parse_args()
    try:
        run(args)
    except grpc.RpcError as error:
        if error.code() == grpc.StatusCode.UNAVAILABLE:
            sys.exit(f"avoid.py: no server answers at {args.connect}: is `baudbot serve` running there?")
        sys.exit(f"avoid.py: the server says {error.code().name}: {error.details()}")
    except KeyboardInterrupt:
        sys.exit(130)
