"""A real server for tests. BAUDBOT names the program; without it, it is target/release/baudbot."""

import os
import re
import subprocess
import time
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[3]
BAUDBOT = os.environ.get("BAUDBOT") or str(ROOT / "target/release/baudbot")


def baudbot(*arguments, **options):
    """Runs the program to its end."""
    return subprocess.run([BAUDBOT, *arguments], capture_output=True, text=True, timeout=120, **options)


class Server:
    """`baudbot serve`, over TCP and a Unix socket."""

    def __init__(self, folder, *arguments):
        self.unix = f"unix:{folder}/baudbot.sock"
        command = [BAUDBOT, "serve", *arguments, "--listen", "127.0.0.1:0", "--listen", self.unix]
        self.log = Path(folder) / "log"
        with self.log.open("w") as out:
            self.process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while not (found := re.search(r"listening on (127\.0\.0\.1:\d+)", self.log.read_text())):
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise AssertionError(f"the server does not listen; it says:\n{self.log.read_text()}")
            time.sleep(0.02)
        self.tcp = found[1]

    def kill(self):
        self.process.kill()
        self.process.wait()


class WithServer(unittest.TestCase):
    """Tests that start servers."""

    def folder(self):
        return self.enterContext(TemporaryDirectory())

    def serve(self, *arguments, folder=None):
        server = Server(folder or self.folder(), *arguments)
        self.addCleanup(server.kill)
        return server
