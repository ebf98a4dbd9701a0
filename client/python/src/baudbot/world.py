"""A world on a server, for operators and observers."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import scenarios
from .paces import pace
from .v1 import budget_pb2, control_pb2, observe_pb2, world_pb2

if TYPE_CHECKING:
    from .client import Client

_POLL_S = 0.02


class ServedWorld:
    """A world, by its name. Its brains are programs of their own, such as those that `baudbot.attach` makes."""

    def __init__(self, client: Client, name: str) -> None:
        self.client, self.name = client, name

    def __repr__(self) -> str:
        return f"<world {self.name} at {self.client.address}>"

    @property
    def status(self) -> world_pb2.WorldStatus:
        """What it is doing and what has happened in it so far, as the contract has it."""
        return self.client.call(self.client.control.GetWorld, control_pb2.GetWorldRequest(world=self.name)).status

    @cached_property
    def description(self) -> observe_pb2.DescribeWorldResponse:
        """What stands still in it, and what its robots are, as the contract has it."""
        return self.client.call(self.client.observe.DescribeWorld, observe_pb2.DescribeWorldRequest(world=self.name))

    @property
    def robots(self) -> list[str]:
        """The names of its robots."""
        return [robot.robot for robot in self.description.robots]

    @property
    def time_s(self) -> float:
        """Simulated time since the start of the run."""
        return self.status.time_ns / 1e9

    @property
    def hash(self) -> str:
        """Fingerprint of the whole state, as `baudbot run` prints it: equal for equal bits."""
        return f"{self.status.state_hash:016x}"

    def start(self) -> None:
        """Starts it, or lets it continue."""
        self.client.call(self.client.control.StartWorld, control_pb2.StartWorldRequest(world=self.name))

    def pause(self) -> None:
        """Stops it before its next tick."""
        self.client.call(self.client.control.PauseWorld, control_pb2.PauseWorldRequest(world=self.name))

    def step(self, ticks: int = 1) -> world_pb2.WorldStatus:
        """Runs some ticks of a world whose pace is `stepped`; the state after them, or after fewer if the run ended."""
        request = control_pb2.StepWorldRequest(world=self.name, ticks=ticks)
        return self.client.call(self.client.control.StepWorld, request, timeout_s=None).status

    def set_pace(self, name: str) -> None:
        """`lockstep`, `stepped`, `real-time`, `scaled:X` or `free`."""
        self.client.call(self.client.control.SetPace, control_pb2.SetPaceRequest(world=self.name, pace=pace(name)))

    def reset(
        self,
        *,
        seed: int | None = None,
        poses: Mapping[str, tuple[float, float, float]] | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> None:
        """Takes it back to its start. Brains stay attached.

        The run may begin with another seed, robots at other poses (x and y in metres, heading in radians), and other fields
        of the scenario by their path. What is not given is as it was when the world was made.
        """
        request = control_pb2.ResetWorldRequest(world=self.name, seed=seed, overrides=scenarios.overrides("", set or {}, {}))
        for robot, (x_m, y_m, heading_rad) in (poses or {}).items():
            request.starts.add(robot=robot, x_m=x_m, y_m=y_m, heading_rad=heading_rad)
        self.client.call(self.client.control.ResetWorld, request)

    def snapshot(self) -> int:
        """Keeps its current state on the server; the number for `restore`."""
        return self.client.call(self.client.control.SnapshotWorld, control_pb2.SnapshotWorldRequest(world=self.name)).snapshot

    def restore(self, snapshot: int) -> None:
        """Takes it back to a snapshot. Brains stay attached."""
        self.client.call(self.client.control.RestoreWorld, control_pb2.RestoreWorldRequest(world=self.name, snapshot=snapshot))

    def clone(self, name: str = "") -> ServedWorld:
        """A new, paused world that continues from the present state."""
        request = control_pb2.CloneWorldRequest(original=self.name, world=name)
        return ServedWorld(self.client, self.client.call(self.client.control.CloneWorld, request).status.world)

    def delete(self) -> None:
        """Ends it; its brains' and observers' streams end."""
        self.client.call(self.client.control.DeleteWorld, control_pb2.DeleteWorldRequest(world=self.name))

    def budget(self, robots: Iterable[str] = ()) -> budget_pb2.GetBudgetResponse:
        """What a control cycle of each robot costs, from the scenario alone."""
        return self.client.call(self.client.control.GetBudget, budget_pb2.GetBudgetRequest(world=self.name, robots=list(robots)))

    def place_robot(self, robot: str, x_m: float, y_m: float, heading_rad: float) -> None:
        """Puts a robot somewhere else, where there is room for it."""
        placed = control_pb2.PlaceRobot(robot=robot, x_m=x_m, y_m=y_m, heading_rad=heading_rad)
        self._intervene(control_pb2.InterveneRequest(world=self.name, place_robot=placed))

    def pull_cable(self, robot: str, pulled: bool = True) -> None:
        """Pulls the cable between a robot and its brain, or plugs it in again."""
        pull = control_pb2.PullCable(robot=robot, pulled=pulled)
        self._intervene(control_pb2.InterveneRequest(world=self.name, pull_cable=pull))

    def set_baud(self, robot: str, baud: int) -> None:
        """Gives the cable between a robot and its brain another baud rate."""
        change = control_pb2.SetBaud(robot=robot, baud=baud)
        self._intervene(control_pb2.InterveneRequest(world=self.name, set_baud=change))

    def detach_brain(self, robot: str, restart: bool = False) -> None:
        """Ends the stream that holds the robot; or has its brain started afresh."""
        detached = control_pb2.DetachBrain(robot=robot, restart=restart)
        self._intervene(control_pb2.InterveneRequest(world=self.name, detach_brain=detached))

    def _intervene(self, request: control_pb2.InterveneRequest) -> None:
        self.client.call(self.client.control.Intervene, request)

    def wait(self, timeout_s: float | None = None) -> world_pb2.WorldStatus:
        """Waits until the run is over; the state at its end. TimeoutError after so much wall-clock time."""
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            status = self.status
            if status.state == world_pb2.WORLD_STATE_ENDED:
                return status
            if end_s is not None and time.monotonic() > end_s:
                raise TimeoutError(f"world `{self.name}` has not ended within {timeout_s:g} s; it is at tick {status.tick}")
            time.sleep(_POLL_S)

    def watch(self, every_ticks: int = 0, details: Iterable[str] = ()) -> Iterator[observe_pb2.WatchResponse]:
        """The truth at a rate, frame by frame, until the run is over; 0 ticks is about 20 frames a simulated second. `details`
        names robots of which frames have rays, readings, cables and timelines, too."""
        request = observe_pb2.WatchRequest(world=self.name, every_ticks=every_ticks, details=list(details))
        for frame in self.client.watch(request):
            yield frame
            if frame.ending:
                return

    def rows(self, every_ticks: int = 0) -> Iterator[dict[str, Any]]:
        """The truth as rows, one for each frame and robot, until the run is over: `pandas.DataFrame(world.rows())`.

        The columns are those of `baudbot run --csv`; what a robot does not have yet is NaN.
        """
        yield from rows(self.description, self.watch(every_ticks))


def rows(
    description: observe_pb2.DescribeWorldResponse, frames: Iterable[observe_pb2.WatchResponse]
) -> Iterator[dict[str, Any]]:
    """Frames of a world as rows, one for each frame and robot."""
    for frame in frames:
        for robot, truth in zip(description.robots, frame.robots, strict=True):
            yield {
                "t_s": frame.time_ns / 1e9,
                "robot": robot.robot,
                "x_m": truth.x_m,
                "y_m": truth.y_m,
                "heading_rad": truth.heading_rad,
                "speed_m_s": truth.speed_m_s,
                "turn_rate_rad_s": truth.turn_rate_rad_s,
                "left_signal": truth.left_signal,
                "right_signal": truth.right_signal,
                "collided": truth.collided,
                **dict(zip(robot.sensor_columns, truth.samples, strict=False)),
            }
