"""Experiments: many runs of a scenario on all cores, as tables."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex

from . import _given, _native
from ._errors import Mistyped
from .errors import Error

if TYPE_CHECKING:
    import pandas

Progress = Callable[[int, int], object]

#: Each has a thread.
MOST_JOBS = 1024
#: Runs of a search.
MOST_RUNS = 10_000_000
MOST_SEED = 2**63 - 1


class Runs:
    """The result of a sweep: a folder as the command `baudbot sweep` writes it, with a journal from which either continues."""

    def __init__(self, folder: Path, told: str) -> None:
        #: The folder with the journal, the tables and the charts.
        self.folder = folder
        #: What was found in each combination of values, as `baudbot sweep --json` tells it.
        self.summary: dict[str, Any] = json.loads(told)

    def frame(self) -> pandas.DataFrame:
        """A row for each run, as a DataFrame of pandas."""
        return _frame(self.folder / "rows.csv")

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The same for libraries that know Arrow: `pyarrow.table(runs)`, `polars.DataFrame(runs)`, DuckDB."""
        return _native.stream_of_file(self.folder / "rows.parquet")

    def charts(self) -> list[Path]:
        """Its charts, in SVG."""
        return sorted(self.folder.glob("*.svg"))

    def _repr_html_(self) -> str:
        pictures = "".join(path.read_text(encoding="utf-8") for path in self.charts())
        return self.frame().to_html(max_rows=60) + pictures

    def __repr__(self) -> str:
        return f"<runs in {self.folder}>"


def sweep(
    experiment: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    seeds: str | int | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> pandas.DataFrame:
    """Runs an experiment's file, or the runs that are still missing, and returns a row for each run as a DataFrame.

    It does what `baudbot sweep` does, with the same journal in the folder `out` (the experiment's name with `.sweep`): a sweep that was
    stopped, also by Ctrl-C, continues from there, here or by the command. `runs` returns the whole result.
    """
    return runs(experiment, out=out, seeds=seeds, jobs=jobs, fresh=fresh, progress=progress).frame()


def runs(
    experiment: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    seeds: str | int | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> Runs:
    """Like `sweep`, with the summary and the charts."""
    experiment, folder = folder_of(experiment, out, "sweep")
    options = seeds_text(seeds), _jobs(jobs), _given.flag(fresh, "fresh"), given_progress(progress)
    result = Runs(folder, done(_native.sweep(experiment, folder, *options, None), folder))
    warn_of_failures(result.summary)
    return result


def tune(
    experiment: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    seeds: str | int | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Looks for the numbers with which an experiment's runs are best: what `baudbot tune --json` tells, and `frame`, a DataFrame of all
    candidates."""
    experiment, folder = folder_of(experiment, out, "tune")
    options = seeds_text(seeds), _jobs(jobs), _given.flag(fresh, "fresh"), given_progress(progress)
    told: dict[str, Any] = json.loads(done(_native.tune(experiment, folder, *options), folder))
    table = folder / "candidates.csv"
    return {**told, "frame": _frame(table)} if table.exists() else told


def worst(
    experiment: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    seeds: str | int | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
    runs: int | None = None,
    within_s: float | None = None,
    first: bool = False,
) -> dict[str, Any]:
    """Looks for the runs that come nearest to a failure: what `baudbot worst --json` tells.

    It does `runs` runs (1,000 if `within_s` is not given either), and begins none after `within_s` seconds by the wall clock; with `first`
    it ends as soon as one fails. The scenario of the worst run is `worst.toml` in the folder `out`.
    """
    experiment, folder = folder_of(experiment, out, "worst")
    options = seeds_text(seeds), _jobs(jobs), _given.flag(fresh, "fresh"), given_progress(progress)
    if runs is not None:
        runs = _given.whole(runs, "runs", 1, MOST_RUNS, "number of runs")
    if within_s is not None:
        within_s = _given.number(within_s, "within_s")
    extent = runs, within_s, _given.flag(first, "first")
    told: dict[str, Any] = json.loads(done(_native.worst(experiment, folder, *options, *extent, None), folder))
    return told


def cost(experiment: str | os.PathLike[str], values: Mapping[str, float], *, seed: int = 1) -> dict[str, Any]:
    """Does one run of an experiment, with these values of its fields by their labels, for an optimizer of your own: its `robustness`, which
    is below 0, or 0, if it fails (`holds`), the instant that decides (`at_s`), and its `state_hash`."""
    file = _given.path(experiment, "experiment")
    numbers = {label: _given.number(value, "values") for label, value in _given.mapping(values, "values").items()}
    told: dict[str, Any] = json.loads(_native.cost(file, numbers, _given.whole(seed, "seed", 0, MOST_SEED)))
    return told


def folder_of(experiment: object, out: object, ending: str) -> tuple[str, Path]:
    """The file of an experiment, and the folder for its results."""
    file = _given.path(experiment, "experiment")
    return file, Path(f"{Path(file).stem}.{ending}" if out is None else _given.path(out, "out"))


def seeds_text(seeds: str | int | None) -> str | None:
    """As `--seeds` has them."""
    if seeds is not None and not isinstance(seeds, (str, SupportsIndex)):
        raise Mistyped(f"seeds: {seeds!r} is neither a number of seeds nor a text such as \"1..20\"", "seeds")
    return None if seeds is None else str(seeds)


def _jobs(jobs: int | None) -> int:
    if jobs is None:
        return os.cpu_count() or 1
    return _given.whole(jobs, "jobs", 1, MOST_JOBS, "number of runs at a time")


def given_progress(progress: Progress | None) -> Progress | None:
    return None if progress is None else _given.function(progress, "progress")


def done(outcome: tuple[str, list[str], bool, list[str]], folder: Path) -> str:
    """What a run of all told; warnings are passed on."""
    told, _files, interrupted, notes = outcome
    for note in notes:
        warnings.warn(note, stacklevel=3)
    if interrupted:
        raise Error(f"stopped; what was run is recorded in {folder}, and the same call continues from there")
    return told


def warn_of_failures(summary: dict[str, Any]) -> None:
    """Runs that failed have no numbers in the table, for which `baudbot sweep` ends with an exit code."""
    if not summary["failed"]:
        return
    reasons = "; ".join(f"run {one['run']}: {one['error']}" for one in summary["failures"][:3])
    warnings.warn(f"{summary['failed']} of {summary['runs']} runs failed, and their rows have no numbers: {reasons}", stacklevel=4)


def _frame(path: Path) -> pandas.DataFrame:
    try:
        import pandas
    except ModuleNotFoundError:
        raise Error(f"a DataFrame needs the package `pandas`: pip install pandas; the table is {path}") from None
    # Fingerprints are not numbers.
    return pandas.read_csv(path, dtype={"state_hash": str})
