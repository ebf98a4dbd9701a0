"""Recordings of runs, such as `baudbot run --record` makes, as tables."""

from __future__ import annotations

import importlib
import math
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

from google.protobuf.message import DecodeError, Message

from .body import kind_name
from .errors import Error, NotARecording, NotFound
from .names import unknown
from .v1 import control_pb2, observe_pb2, recording_pb2
from .world import rows

#: The version of the format that is read here.
_FORMAT = 1

_HEADER, _STATE, _MARKS, _EVENTS = "/baudbot/header", "/baudbot/state", "/baudbot/marks", "/baudbot/events"
_WORLD, _FRAMES = "/baudbot/world", "/baudbot/frames"

M = TypeVar("M", bound=Message)


def open(path: str | os.PathLike[str]) -> Recording:
    """Opens a recording. It needs the package `mcap`.

    From a file that is damaged or cut off, as a killed program leaves it, everything intact is read; a warning and
    `Recording.problem` say what is wrong. A recording that is still being made is cut off, too.

    Raises `NotFound` if there is no such file, `NotARecording` if it is something else, `Error` if it cannot be read.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"path: {path!r} is not a path")
    recording = Recording(Path(path))
    if recording.problem is not None:
        intact = f"what is intact up to tick {recording.last_tick} is read"
        warnings.warn(f"{recording.path}: {recording.problem}; {intact}", stacklevel=2)
    return recording


class Table(Iterator[dict[str, Any]]):
    """Rows of a table, one after the other. With the package `baudbot`, libraries that know Arrow take the remaining ones as a table:
    `pyarrow.table(recording.rows())`, `polars.DataFrame(…)`."""

    def __init__(self, rows: Iterator[dict[str, Any]]) -> None:
        self._rows = rows

    def __iter__(self) -> Table:
        return self

    def __next__(self) -> dict[str, Any]:
        return next(self._rows)

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        try:
            native = importlib.import_module("._native", __package__)
        except ModuleNotFoundError:
            raise Error("Arrow tables need the package `baudbot`, and only `baudbot-client` is installed: pip install baudbot") from None
        rows = list(self._rows)
        names = list(dict.fromkeys(name for row in rows for name in row))
        return native.stream_of_columns(names, [[row.get(name) for row in rows] for name in names])


class Recording:
    """A recorded run.

    Its tables are iterators of rows, and a row is a dictionary: `pandas.DataFrame(recording.rows())`. They are read from the
    file whenever they are asked for. Their times `t_s` are simulated seconds since the start of the run. What a robot does
    not have, or not yet, is NaN.
    """

    def __init__(self, path: Path) -> None:
        #: The file.
        self.path = path
        #: What stands still in the world, and what its robots are, as the contract has it; None if there are no frames.
        self.description: observe_pb2.DescribeWorldResponse | None = None
        #: The first and the last tick of the run that are in the file.
        self.first_tick, self.last_tick = 0, 0
        #: Why the run ended, in words; None if it had not ended when the recording did.
        self.ending: str | None = None
        #: What is wrong with the file; None if nothing is.
        self.problem: str | None = None
        self._events: list[recording_pb2.RecordedEvent] = []
        #: What the recording begins with, as the contract has it.
        self.header = self._look_through()

    def __repr__(self) -> str:
        return f"<recording {self.path} of world {self.header.world}, ticks {self.first_tick} to {self.last_tick}>"

    @property
    def scenario(self) -> str:
        """The text of the scenario (TOML), with whatever it refers to in it. `overrides` are not applied to it."""
        return self.header.scenario_toml

    @property
    def overrides(self) -> list[str]:
        """Changes of single fields of the scenario, such as `end.after_s=60.0`."""
        return list(self.header.overrides)

    @property
    def seed(self) -> int:
        """The seed of all random numbers of the run."""
        return self.header.seed

    @property
    def step_s(self) -> float:
        """Length of a tick."""
        return self.header.step_ns / 1e9

    @property
    def robots(self) -> list[str]:
        """The names of the robots."""
        return list(self.header.robots)

    def events(self) -> Table:
        """What happened in the run: `kind` is `collision`, `brain` (attached or detached), `change` (by hand) or `ending`."""
        return Table(self._event(event) for event in self._events)

    def _event(self, event: recording_pb2.RecordedEvent) -> dict[str, Any]:
        kind = kind_name(control_pb2.ReplayEventKind, event.kind, "REPLAY_EVENT_KIND_")
        return {"t_s": self._seconds(event.tick), "tick": event.tick, "kind": kind, "text": event.text}

    def frames(self) -> Iterator[observe_pb2.WatchResponse]:
        """All that an observer saw, frame by frame, as the contract has it; there are as many as `--record-hz` asked for."""
        self._described()
        return self._frames()

    def rows(self) -> Table:
        """The truth: poses, speeds, signals and samples, a row for each frame and robot, with the columns of `ServedWorld.rows`."""
        return Table(rows(self._described(), self._frames()))

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The table `rows`, for libraries that know Arrow."""
        return self.rows().__arrow_c_stream__(requested_schema)

    def readings(self, robot: str, sensor: str) -> Table:
        """What the robot's brain had from a sensor, a row for each frame, from the first reading on: its values; when it was
        sampled, and how old it was then (NaN if that is not known); whether it was new since the brain's last step.

        A recording has the readings of its first 64 robots.
        """
        robots = self._described().robots
        names = [one.robot for one in robots]
        if robot not in names:
            raise NotFound(f"{self.path}: {unknown('robot', robot, names)}")
        place = names.index(robot)
        sensors = [one.sensor for one in robots[place].description.sensors]
        if sensor not in sensors:
            raise NotFound(f"{self.path}: {unknown('sensor', sensor, sensors, f' of robot `{robot}`')}")
        # A sensor's name has no dot in it.
        columns = [column for column in robots[place].sensor_columns if column.partition(".")[0] == sensor]
        return Table(self._readings(place, sensors.index(sensor), {"robot": robot}, columns))

    def _readings(self, place: int, sensor: int, robot: dict[str, str], columns: list[str]) -> Iterator[dict[str, Any]]:
        for frame in self._frames():
            for detail in frame.details:
                if detail.robot != place or not detail.sensors[sensor].values:
                    continue
                reading = detail.sensors[sensor]
                known = reading.HasField("sampled_at_ns")
                yield {
                    "t_s": frame.time_ns / 1e9,
                    **robot,
                    "sampled_at_s": reading.sampled_at_ns / 1e9 if known else math.nan,
                    "age_s": (frame.time_ns - reading.sampled_at_ns) / 1e9 if known else math.nan,
                    "readable": reading.readable,
                    **dict(zip(columns, reading.values, strict=False)),
                }

    def cycles(self) -> Table:
        """How the control cycles went so far, a row for each frame and robot: how many kept their deadline, were late, and
        were not answered, and how long the answered ones took. The last rows are of the whole run.

        A recording has the cycles of its first 64 robots.
        """
        return Table(self._cycles([robot.robot for robot in self._described().robots]))

    def _cycles(self, names: list[str]) -> Iterator[dict[str, Any]]:
        for frame in self._frames():
            for detail in frame.details:
                cycles, durations = detail.cycles, detail.cycles.durations
                yield {
                    "t_s": frame.time_ns / 1e9,
                    "robot": names[detail.robot],
                    "deadline_s": cycles.deadline_ns / 1e9,
                    "kept": cycles.kept,
                    "late": cycles.late,
                    "unanswered": cycles.unanswered,
                    **{
                        f"{name}_s": getattr(durations, f"{name}_ns") / 1e9 if durations.count else math.nan
                        for name in ("mean", "min", "p50", "p95", "p99", "max")
                    },
                }

    def _seconds(self, tick: int) -> float:
        return tick * self.header.step_ns / 1e9

    def _described(self) -> observe_pb2.DescribeWorldResponse:
        if self.description is None:
            why = self.problem or "it was recorded with `--record-hz 0`"
            remedy = f"`baudbot export {self.path} --csv FILE` computes the run again, and writes a table of it"
            raise Error(f"{self.path}: has no frames, since {why}; {remedy}")
        return self.description

    def _frames(self) -> Iterator[observe_pb2.WatchResponse]:
        for topic, data in self._messages(_FRAMES):
            yield self._parsed(observe_pb2.WatchResponse, topic, data)

    def _look_through(self) -> recording_pb2.RecordingHeader:
        """Reads all but the tables; the header."""
        damages: list[tuple[int, bool]] = []
        header: recording_pb2.RecordingHeader | None = None
        first_tick: int | None = None
        for topic, data in self._messages(_HEADER, _STATE, _MARKS, _EVENTS, _WORLD, damages=damages):
            if topic == _HEADER:
                header = self._known(self._parsed(recording_pb2.RecordingHeader, topic, data))
            elif topic == _WORLD:
                self.description = self._parsed(observe_pb2.DescribeWorldResponse, topic, data)
            elif topic == _EVENTS:
                self._events.append(self._parsed(recording_pb2.RecordedEvent, topic, data))
            elif topic == _MARKS:
                self.last_tick = self._parsed(recording_pb2.RecordedMark, topic, data).tick
            elif first_tick is None:
                first_tick = self._parsed(recording_pb2.RecordedState, topic, data).tick
        self.problem = _problem(damages)
        if header is None:
            raise NotARecording(
                f"{self.path}: {self.problem}, and the header with the scenario is missing"
                if self.problem
                else f"{self.path}: is an MCAP file, but not a recording of baudbot: it has no message on {_HEADER}"
            )
        self.first_tick = first_tick or 0
        ending = control_pb2.REPLAY_EVENT_KIND_ENDING
        self.ending = next((event.text for event in self._events if event.kind == ending), None)
        return header

    def _known(self, header: recording_pb2.RecordingHeader) -> recording_pb2.RecordingHeader:
        if header.format != _FORMAT:
            raise NotARecording(
                f"{self.path}: is of format {header.format}, which baudbot {header.program_version} wrote; "
                f"this version of baudbot-client reads format {_FORMAT}"
            )
        return header

    def _parsed(self, message: type[M], topic: str, data: bytes) -> M:
        try:
            return message.FromString(data)
        except DecodeError as error:
            raise NotARecording(f"{self.path}: has a message on {topic} that cannot be read: {error}") from None

    def _messages(self, *topics: str, damages: list[tuple[int, bool]] | None = None) -> Iterator[tuple[str, bytes]]:
        try:
            from .mcap_file import messages
        except ModuleNotFoundError:
            raise Error("recordings are read with the package `mcap`, which is not installed: pip install mcap") from None
        told = [] if damages is None else damages
        return messages(self.path, topics, lambda at, goes_on: told.append((at, goes_on)))


def _problem(damages: list[tuple[int, bool]]) -> str | None:
    """What is wrong with a file that is damaged at these bytes, as `baudbot replay` says it."""
    if not damages:
        return None
    at, goes_on = damages[0]
    return f"the file is {'damaged' if goes_on else 'cut off or damaged'} at byte {at}"
