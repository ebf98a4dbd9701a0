"""Sweeps on a cluster, by Ray. A node may die: its runs are done again elsewhere, and come out the same, as every run does.

::

    import baudbot.ray

    frame = baudbot.ray.sweep("catalogue/experiments/baud-vs-speed.toml", out="speeds")
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import ray

from . import _given, _native
from ._runs import Progress, Runs, done, folder_of, given_progress, seeds_text, warn_of_failures

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
    seeds, retries = seeds_text(seeds), _given.whole(retries, "retries", -1, MOST_SHARDS)
    fresh, progress = _given.flag(fresh, "fresh"), given_progress(progress)
    if shards is not None:
        shards = _given.whole(shards, "shards", 1, MOST_SHARDS, "number of shards")
    packed, runs = _native.pack(experiment, seeds)
    if not ray.is_initialized():
        ray.init()
    count = shards if shards is not None else 4 * max(1, int(ray.cluster_resources().get("CPU", 1)))
    count = min(count, max(runs, 1))
    place = folder.with_name(f"{folder.name}.shards-{count}")
    missing = [index for index in range(count) if fresh or not _journal(place, index, count).exists()]
    shard = ray.remote(num_cpus=1, max_retries=retries)(_shard)
    waiting = {shard.remote(packed, seeds, f"{index}/{count}"): index for index in missing}
    while waiting:
        ready, _ = ray.wait(list(waiting), num_returns=1)
        for task in ready:
            _keep(_journal(place, waiting.pop(task), count), ray.get(task))
            if progress is not None:
                progress(count - len(waiting), count)
    told = _native.merge(experiment, [place], folder, seeds, fresh)
    result = Runs(folder, done(told, folder))
    warn_of_failures(result.summary)
    return result.frame()


#: As many as the command has.
MOST_SHARDS = 1_000_000


def _shard(packed: _native.Packed, seeds: str | None, shard: str) -> bytes:
    """The journal of a shard, done on whatever node this is."""
    with tempfile.TemporaryDirectory() as folder:
        _native.sweep(packed, folder, seeds, 1, False, None, shard)
        return (Path(folder) / "rows.jsonl").read_bytes()


def _journal(place: Path, index: int, count: int) -> Path:
    return place / f"{index}-of-{count}" / "rows.jsonl"


def _keep(journal: Path, rows: bytes) -> None:
    """Whole or not at all."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    fresh = journal.with_suffix(".new")
    fresh.write_bytes(rows)
    fresh.replace(journal)
