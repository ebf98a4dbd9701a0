#!/usr/bin/env python3
"""A sweep and a search on Ray with a head and two nodes on this machine, one of which is killed: the tables of one machine, byte for byte.

It needs the packages of python/requirements.txt and Ray (`pip install ray`); `./test cluster` runs it.
"""

from __future__ import annotations

import filecmp
import sys
import tempfile
import threading
import time
from pathlib import Path

import baudbot
import ray
from ray.cluster_utils import Cluster

import baudbot.ray

EXPERIMENT = """
name = "baud"
scenario = "wander"
brain = "avoid"
seconds = 60.0
seeds = 40

[[fields]]
field = "robots.robot.link.baud"
label = "baud"
values = [1200, 2400, 4800, 9600]
"""

#: Which files are compared; the journal's rows are in the order in which they came.
FILES = ("rows.csv", "summary.txt", "rows.parquet")


def main() -> None:
    started = time.monotonic()
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    nodes = [cluster.add_node(num_cpus=1) for _ in range(2)]
    ray.init(address=cluster.address, log_to_driver=False)
    said(started, f"a head and {len(nodes)} nodes are up, {ray.cluster_resources()['CPU']:.0f} processors")
    with tempfile.TemporaryDirectory() as folder:
        experiment = Path(folder) / "baud.toml"
        experiment.write_text(EXPERIMENT)
        killed = threading.Event()

        def kill(done: int, total: int) -> None:
            if done >= 3 and not killed.is_set():
                killed.set()
                cluster.remove_node(nodes[1], allow_graceful=False)
                said(started, f"a node was killed after {done} of {total} shards")

        frame = baudbot.ray.sweep(experiment, out=Path(folder) / "cluster", shards=16, progress=kill)
        said(started, f"{len(frame)} runs are done")
        baudbot.sweep(experiment, out=Path(folder) / "here")
        differs = [name for name in FILES if not filecmp.cmp(Path(folder) / "cluster" / name, Path(folder) / "here" / name, shallow=False)]
        if not killed.is_set() or differs or len(frame) != 160:
            sys.exit(f"killed: {killed.is_set()}; {len(frame)} rows; files that differ: {differs}")
        again = baudbot.ray.sweep(experiment, out=Path(folder) / "cluster", shards=16)
        assert again.equals(frame)
        search(Path(folder))
        said(started, "a search is that of one machine, too")
    ray.shutdown()
    cluster.shutdown()
    said(started, "the tables are those of one machine, byte for byte")


SEARCH = """
name = "near"
scenario = "wander"
brain = "avoid"
seconds = 20.0

[require]
always = "clearance_m > 0.05"

[worst]
method = "random"
"""


def search(folder: Path) -> None:
    """The worst of 48 runs, in eight shards and at once."""
    experiment = folder / "near.toml"
    experiment.write_text(SEARCH)
    cluster = baudbot.ray.worst(experiment, runs=48, out=folder / "cluster.worst", shards=8)
    here = baudbot.worst(experiment, runs=48, out=folder / "here.worst")
    assert cluster == here, (cluster, here)
    for name in ("summary.txt", "worst.toml"):
        assert filecmp.cmp(folder / "cluster.worst" / name, folder / "here.worst" / name, shallow=False), name


def said(started: float, text: str) -> None:
    print(f"{time.monotonic() - started:6.1f} s  {text}", flush=True)


if __name__ == "__main__":
    main()
