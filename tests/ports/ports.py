"""Robots that are served with ports and recorded meanwhile, and what their recordings say of the run."""

import csv
import io
import os
import pathlib
import re
import signal
import subprocess
import sys
from collections.abc import Sequence


class Served:
    """A scenario with ports, recorded while the body of a `with` runs. `places` has where the ports are."""

    def __init__(
        self,
        baudbot: str,
        scenario: pathlib.Path,
        ports: Sequence[str],
        folder: str,
        changes: Sequence[str] = (),
        options: Sequence[str] = (),
    ) -> None:
        self.baudbot, self.folder, self.ports = baudbot, folder, ports
        name = scenario.stem
        while os.path.exists(os.path.join(folder, name + ".mcap")):
            name += "-again"
        self.recording = os.path.join(folder, name + ".mcap")
        self.command = [baudbot, "serve", str(scenario), "--viewer", "off", "--listen", "127.0.0.1:0"]
        self.command += ["--record", self.recording]
        self.command += [part for port in ports for part in ("--port", port)]
        self.command += [part for change in changes for part in ("--set", change)]
        self.command += options
        self.places: list[str] = []
        self.report = ""

    def __enter__(self) -> "Served":
        self.server = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True, cwd=self.folder)
        while len(self.places) < len(self.ports):
            line = self.server.stdout.readline()
            if not line:
                sys.exit(f"{self.command}: the server has ended")
            found = re.fullmatch(r"serial port of \S+: (\S+).*\n", line)
            if found:
                self.places.append(found[1])
        return self

    def __exit__(self, *_: object) -> None:
        """Ends the server, and replays what was recorded to the same bits."""
        self.server.send_signal(signal.SIGINT)
        rest, _stderr = self.server.communicate(timeout=60)
        self.report = "".join(line + "\n" for line in rest.splitlines() if line.startswith("port "))
        subprocess.run([self.baudbot, "replay", self.recording], check=True, stdout=subprocess.DEVNULL)

    def run(self, program: Sequence[str]) -> str:
        """What a Python program says that comes to a good end."""
        command = [sys.executable, "-B", *program]
        done = subprocess.run(command, check=True, cwd=self.folder, timeout=240, stdout=subprocess.PIPE, text=True)
        return done.stdout

    def export(self, what: str) -> list[dict[str, str]]:
        """A table of the recording: `csv`, a row for each tick, or `events`."""
        command = [self.baudbot, "export", self.recording, f"--{what}", "-", "--quiet"]
        text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        return list(csv.DictReader(io.StringIO(text)))


def number(place: str) -> str:
    """The number of a TCP port."""
    return place.rsplit(":", 1)[1]
