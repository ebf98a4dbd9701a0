#!/usr/bin/env python3
"""Runs examples/avoid.py as people do, against a real server, and asks the operator's service how it went.

BAUDBOT names the server's program; without it, it is target/release/baudbot.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "generated"))
import grpc
from baudbot.v1 import control_pb2, control_pb2_grpc

BAUDBOT = os.environ.get("BAUDBOT") or HERE.parent.parent / "target/release/baudbot"
SECONDS = 10
# A proxy of the machine's has no business on loopback.
ENVIRONMENT = os.environ | {"no_proxy": "127.0.0.1,localhost"}


def avoid(*args):
    command = [sys.executable, HERE / "examples/avoid.py", *args]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, env=ENVIRONMENT)


class Example(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.socket = f"unix:{folder / 'baudbot.sock'}"
        command = [BAUDBOT, "serve", "wander", "--pace", "lockstep", "--listen", "127.0.0.1:0", "--listen", self.socket]
        log = folder / "log"
        with log.open("w") as out:
            server = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        deadline = time.monotonic() + 30
        while not (found := re.search(r"listening on (127\.0\.0\.1:\d+)", log.read_text())):
            dead = server.poll() is not None or time.monotonic() > deadline
            self.assertFalse(dead, f"the server does not listen; it says:\n{log.read_text()}")
            time.sleep(0.05)
        self.tcp = found[1]

    def status(self):
        with grpc.insecure_channel(self.tcp, [("grpc.enable_http_proxy", 0)]) as channel:
            request = control_pb2.GetWorldRequest(world="wander")
            return control_pb2_grpc.ControlServiceStub(channel).GetWorld(request, timeout=10).status

    def drives_without_collision(self, address):
        done = avoid("--connect", address, "--seconds", str(SECONDS))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        status = self.status()
        (robot,) = status.robots
        self.assertGreaterEqual(status.time_ns, SECONDS * 10**9)
        self.assertEqual((status.ending, robot.collisions), ("", 0))
        self.assertGreater(robot.distance_m, 1.0)
        print(f"{address}: {robot.distance_m:.2f} m in {status.time_ns / 1e9:.2f} s, {robot.commands} commands")

    def test_drives_over_tcp(self):
        self.drives_without_collision(self.tcp)

    def test_drives_over_a_unix_socket(self):
        self.drives_without_collision(self.socket)

    def test_refusals_are_one_line(self):
        for args, text in [
            (("--world", "nowhere"), "there is no world `nowhere`"),
            (("--robot", "nobody"), "there is no robot `nobody`"),
        ]:
            done = avoid("--connect", self.tcp, *args)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)


class WithoutServer(unittest.TestCase):
    def test_says_so_in_one_line(self):
        # Port 1 needs a privileged server, of which a test machine has none.
        done = avoid("--connect", "127.0.0.1:1")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, "avoid.py: no server answers at 127.0.0.1:1: is `baudbot serve` running there?\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
