"""The brain beside a server of its own: `pip install pytest`, and `python -m pytest`."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

# Ten seconds of simulated time, which take a moment: the world waits for the brain and not for the clock.
WORLD = ["wander", "--pace", "lockstep", "--set", "end.after_s=10.0"]


@pytest.fixture
def server(tmp_path):
    """The address of a server at a free port."""
    file = tmp_path / "address"
    program = os.environ.get("BAUDBOT", "baudbot")
    command = [program, "serve", *WORLD, "--listen", "127.0.0.1:0", "--port-file", file, "--viewer", "off"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        deadline = time.monotonic() + 30
        while not file.exists():
            assert process.poll() is None and time.monotonic() < deadline, "the server does not come up"
            time.sleep(0.02)
        yield file.read_text().strip()
        process.terminate()


def test_it_drives_to_the_end_of_the_run(server):
    brain = Path(__file__).with_name("brain.py")
    command = [sys.executable, brain, "--connect", server, "--world", "wander"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert "the run is over" in done.stdout
