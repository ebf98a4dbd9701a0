"""Sweeps and searches on a cluster, by Ray. A node may die: its runs are done again elsewhere, and come out the same, as every run does.

::

    import baudbot.ray

    frame = baudbot.ray.sweep("catalogue/experiments/baud-vs-speed.toml", out="speeds")
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import ray

from . import _given, _native
from ._runs import MOST_RUNS, Progress, Runs, done, folder_of, given_progress, seeds_text, warn_of_failures

if TYPE_CHECKING:
    import pandas


def sweep(
    experiment: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    seeds: str | int | None = None,
    shards: int | None = None,
    retries: int = 10,
    fresh: bool = False,
    progress: Progress | None = None,
) -> pandas.DataFrame:
    """Runs an experiment's file on all processors of the cluster that Ray is connected to, and returns a row for each run.

    The runs are cut into `shards` (four for each processor), each a task of Ray's on one processor. A task whose node dies is
    done again elsewhere, up to so many `retries`. The journals of the shards come to the folder `out` + `.shards-N` as they are finished;
    a sweep that was stopped continues from there. The tables in `out` are those of `baudbot.sweep`, to the byte.

    The package `baudbot` must be installed on all nodes in the same version. `ray.init()` is called if nobody has.
    """
    experiment, folder = folder_of(experiment, out, "sweep")
    cluster = _Cluster(folder, seeds_text(seeds), shards, retries, fresh, progress)
    packed, runs = _native.pack(experiment, cluster.seeds, None)
    place = cluster.run(packed, runs, None)
    told = _native.merge(experiment, [place], folder, cluster.seeds, cluster.fresh)
    result = Runs(folder, done(told, folder))
    warn_of_failures(result.summary)
    return result.frame()


def worst(
    experiment: str | os.PathLike[str],
    *,
    runs: int,
    out: str | os.PathLike[str] | None = None,
    seeds: str | int | None = None,
    shards: int | None = None,
    retries: int = 10,
    fresh: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Looks for the runs that come nearest to a failure, on all processors of the cluster: `baudbot.worst`, by the method `random`, in
    shards as `sweep` has them. The files in `out` are those of one machine, to the byte."""
    experiment, folder = folder_of(experiment, out, "worst")
    cluster = _Cluster(folder, seeds_text(seeds), shards, retries, fresh, progress)
    runs = _given.whole(runs, "runs", 1, MOST_RUNS, "number of runs")
    packed, runs = _native.pack(experiment, cluster.seeds, runs)
    place = cluster.run(packed, runs, runs)
    told: dict[str, Any] = json.loads(done(_native.merge_worst(experiment, [place], folder, cluster.seeds, cluster.fresh, runs), folder))
    return told


class _Cluster:
    """How an experiment is done in shards."""

    def __init__(
        self, folder: Path, seeds: str | None, shards: int | None, retries: int, fresh: bool, progress: Progress | None
    ) -> None:
        self.folder, self.seeds = folder, seeds
        self.retries = _given.whole(retries, "retries", -1, MOST_SHARDS)
        self.fresh, self.progress = _given.flag(fresh, "fresh"), given_progress(progress)
        self.shards = None if shards is None else _given.whole(shards, "shards", 1, MOST_SHARDS, "number of shards")

    def run(self, packed: _native.Packed, runs: int, search_runs: int | None) -> Path:
        """Does all shards that are missing; returns the folder of their journals."""
        if not ray.is_initialized():
            ray.init()
        count = self.shards if self.shards is not None else 4 * max(1, int(ray.cluster_resources().get("CPU", 1)))
        count = min(count, max(runs, 1))
        # A search for more runs has others in each shard.
        extent = "" if search_runs is None else f"-of-{search_runs}"
        place = self.folder.with_name(f"{self.folder.name}.shards-{count}{extent}")
        missing = [index for index in range(count) if self.fresh or not _journal(place, index, count).exists()]
        shard = ray.remote(num_cpus=1, max_retries=self.retries)(_shard)
        waiting = {shard.remote(packed, self.seeds, f"{index}/{count}", search_runs): index for index in missing}
        while waiting:
            ready, _ = ray.wait(list(waiting), num_returns=1)
            for task in ready:
                _keep(_journal(place, waiting.pop(task), count), ray.get(task))
                if self.progress is not None:
                    self.progress(count - len(waiting), count)
        return place


#: As many as the command has.
MOST_SHARDS = 1_000_000


def _shard(packed: _native.Packed, seeds: str | None, shard: str, search_runs: int | None) -> bytes:
    """The journal of a shard, done on whatever node this is."""
    with tempfile.TemporaryDirectory() as folder:
        if search_runs is None:
            _native.sweep(packed, folder, seeds, 1, False, None, shard)
        else:
            _native.worst(packed, folder, seeds, 1, False, None, search_runs, None, False, shard)
        return (Path(folder) / "rows.jsonl").read_bytes()


def _journal(place: Path, index: int, count: int) -> Path:
    return place / f"{index}-of-{count}" / "rows.jsonl"


def _keep(journal: Path, rows: bytes) -> None:
    """Whole or not at all."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    fresh = journal.with_suffix(".new")
    fresh.write_bytes(rows)
    fresh.replace(journal)
