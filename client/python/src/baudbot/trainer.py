"""A trainer: a program that improves a brain by its runs. It drives robots of many worlds at once, and is told the truth."""

from __future__ import annotations

import queue
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count as numbers
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar, Union, cast

import grpc

from . import scenarios
from .attach import closed, program_name
from .brain import Brain
from .channel import open_channel
from .client import Client
from .commands import Output
from .errors import Error, NotFound, Refused, from_status
from .handshake import failed
from .names import matching, unknown
from .session import Seat, Session, hello
from .turn import Turn
from .v1 import control_pb2, world_pb2
from .v1 import trainer_pb2 as pb
from .v1.trainer_pb2_grpc import TrainerServiceStub
from .world import ServedWorld

#: What a world's robots do: an output if it has one robot, otherwise one for each robot's name.
Commands = Union[Output, Mapping[str, Output]]
#: A place to start: x and y in metres, and the heading in radians.
Pose = tuple[float, float, float]

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Result:
    """A world after a step or a reset: what is true at the start of its tick."""

    #: Its name.
    world: str
    #: Number of the tick.
    tick: int
    #: Simulated time at the start of the tick.
    time_s: float
    #: What brains of its robots would get now, by the robots' names; robots without news have none.
    turns: Mapping[str, Turn]
    #: The truth about all robots that are held, by their names, as the contract has it.
    truths: Mapping[str, pb.Truth]
    #: What the referee counted; None if the scenario counts nothing.
    score: world_pb2.Score | None = None
    #: Why the run has ended, such as `time-is-over` or `collision`; None while it goes on.
    ended: str | None = None
    #: Why the robots were released, such as by the deletion of the world; None while they are held.
    error: Error | None = field(default=None)

    @property
    def turn(self) -> Turn:
        """The turn of the only robot."""
        return self._only(self.turns, "turn")

    @property
    def truth(self) -> pb.Truth:
        """The truth about the only robot."""
        return self._only(self.truths, "truth")

    def _only(self, by_robot: Mapping[str, T], what: str) -> T:
        if self.error is not None:
            raise self.error
        # Of several robots a single one may have a turn, and that is not always the same one.
        if len(self.truths) == len(by_robot) == 1:
            return next(iter(by_robot.values()))
        if self.ended is not None and not by_robot:
            raise Error(f"the run of world `{self.world}` has ended ({self.ended}), and there is no {what}; reset it")
        raise Error(f"world `{self.world}` has {len(self.truths)} robots; choose by a robot's name: result.{what}s[\"…\"]")


class Trainer:
    """Drives robots of many worlds of a server that has an address for trainers (`baudbot serve --trainer ADDRESS`). ::

        with baudbot.Trainer("unix:/tmp/trainer.sock") as trainer:
            trainer.create("wander", count=64, seeds=range(64), baud=2400)
            results = trainer.reset()
            while not all(result.ended for result in results):
                results = trainer.step([None if result.ended else policy(result.turn) for result in results])

    A robot has a turn when a message has come, and at the latest `patience_s` of simulated time after its last one (None:
    never without a message), or with `every_tick` in each tick. On leaving `with`, robots are released and the worlds that
    `create` has made are deleted.
    """

    def __init__(self, connect: str, *, patience_s: float | None = 0.1, every_tick: bool = False) -> None:
        #: For operators: worlds can be made, cloned and deleted here, too, but not observed.
        self.client = Client(connect)
        # The class whose place a trainer takes.
        attributes = {"patience_s": patience_s, "every_tick": every_tick}
        self._brain = cast("type[Brain]", type("Trainer", (Brain,), attributes))
        self._channel = open_channel(connect)
        self._stream: _Stream | None = None
        self._trained: dict[str, _Trained] = {}
        self._made: list[ServedWorld] = []
        self._text: str | None = None

    def __enter__(self) -> Trainer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Releases all robots, and deletes the worlds that `create` has made."""
        if self._stream is not None:
            self._stream.close()
        self._channel.close()
        try:
            self._delete(self._made)
        finally:
            self.client.close()

    @property
    def results(self) -> list[Result]:
        """The state of the worlds as last reported, in their order."""
        return [trained.last for trained in self._trained.values()]

    def create(
        self,
        scenario: str | Path,
        count: int | None = None,
        name: str = "trained",
        *,
        seeds: Iterable[int] | None = None,
        set: Mapping[str, Any] | None = None,
        **fields: Any,
    ) -> list[ServedWorld]:
        """Makes worlds `NAME-1`, `NAME-2`, … in lockstep, and takes all their robots.

        There are `count` of them, or as many as `seeds`; without either, one. Other arguments are those of
        `Client.create_world`.
        """
        self._check_unopened()
        chosen = None if seeds is None else list(seeds)
        if count is not None and chosen is not None and count != len(chosen):
            raise Refused(f"seeds: there are {len(chosen)}, and count is {count}")
        total = count if count is not None else 1 if chosen is None else len(chosen)
        if total < 1:
            raise Refused(f"count: must be at least 1, is {total}")
        self._text = scenarios.read(scenario)
        taken = {world.name for world in self.client.worlds()}
        free = (f"{name}-{number}" for number in numbers(1) if f"{name}-{number}" not in taken)
        try:
            for i, own in zip(range(total), free):
                seed = {} if chosen is None else {"seed": chosen[i]}
                self._made.append(self.client.create_world(scenario, own, set=set, **{**fields, **seed}))
            self._open([world.name for world in self._made])
        except Error:
            self._delete(self._made)
            raise
        return list(self._made)

    def open(self, worlds: str | Iterable[str] = ("*",)) -> list[ServedWorld]:
        """Takes all robots of worlds that the server has, which must be in lockstep; names may be patterns (`wander-*`)."""
        self._check_unopened()
        self._text = None
        names = matching([worlds] if isinstance(worlds, str) else worlds, [world.name for world in self.client.worlds()], "world")
        self._open(names)
        return [ServedWorld(self.client, name) for name in names]

    def reset(
        self,
        worlds: str | ServedWorld | Iterable[str | ServedWorld] | None = None,
        *,
        seed: int | Iterable[int] | None = None,
        poses: Mapping[str, Pose] | Iterable[Mapping[str, Pose]] | None = None,
        set: Mapping[str, Any] | None = None,
        **fields: Any,
    ) -> list[Result]:
        """Takes worlds back to their start, all unless some are named, and returns their state there.

        `seed` and `poses` (by robot) are for all of these worlds, or a list with one for each. `set` and keywords change
        fields of the scenario as for `create`. What is not given is as `create` made it. Raises `Refused` or `NotFound` if a
        world refuses its reset; that world then stays as it was, and the others are reset.
        """
        named = [worlds] if isinstance(worlds, (str, ServedWorld)) else worlds
        chosen = list(self._trained.values()) if named is None else [self._find(world) for world in named]
        if "baud" in fields and self._text is None:
            raise Refused("baud: is for worlds that `create` has made; use set={\"robots.NAME.link.baud\": …}")
        changes = scenarios.overrides(self._text or "", set or {}, fields)
        seeds = _for_each(chosen, seed, "seed")
        starts = _for_each(chosen, poses, "poses")
        actions = {}
        for trained, own_seed, own_poses in zip(chosen, seeds, starts):
            request = control_pb2.ResetWorldRequest(seed=own_seed, overrides=changes)
            for robot, (x_m, y_m, heading_rad) in (own_poses or {}).items():
                request.starts.add(robot=robot, x_m=x_m, y_m=y_m, heading_rad=heading_rad)
            actions[trained] = pb.WorldAction(world=trained.place, reset=request)
        refused = self._exchange(actions)
        if refused is not None:
            raise refused
        return [trained.last for trained in chosen]

    def step(self, commands: Sequence[Commands] | Mapping[str, Commands]) -> list[Result]:
        """Answers turns: with a list, those of all worlds in their order; with a mapping, those of the worlds that it names.

        Answers to a world whose run has ended are ignored. Returns the state of these worlds at their next turns.
        """
        if isinstance(commands, Mapping):
            pairs = [(self._find(world), command) for world, command in commands.items()]
        elif len(commands) == len(self._trained):
            pairs = list(zip(self._trained.values(), commands))
        else:
            raise Refused(f"commands: there are {len(commands)}, but one for each of {len(self._trained)} worlds is needed")
        actions = {trained: trained.answer(command) for trained, command in pairs if trained.last.turns}
        refused = self._exchange(actions)
        if refused is not None:
            raise refused
        return [trained.last for trained, _ in pairs]

    def _check_unopened(self) -> None:
        if self._trained:
            raise Error(f"this trainer drives {len(self._trained)} worlds already; make another Trainer for others")

    def _find(self, world: str | ServedWorld) -> _Trained:
        name = world.name if isinstance(world, ServedWorld) else world
        if name not in self._trained:
            raise NotFound(unknown("world of this trainer", name, list(self._trained)))
        return self._trained[name]

    def _delete(self, worlds: list[ServedWorld]) -> None:
        """Deletes those of these worlds that still exist."""
        while worlds:
            try:
                worlds.pop().delete()
            except NotFound:
                pass  # somebody has deleted it
            except Error:
                worlds.clear()  # the server is gone or does not answer

    def _open(self, names: list[str]) -> None:
        program = program_name()
        hellos = [hello(name, [], self._brain, program).hello for name in names]
        # A stream of its own: that of an attempt which was refused is over.
        self._stream = _Stream(self._channel, self.client.address)
        response = self._stream.ask(pb.TrainRequest(open=pb.OpenTraining(worlds=hellos)), names)
        make = self._brain
        for place, (name, message) in enumerate(zip(names, response.worlds, strict=True)):
            self._trained[name] = _Trained(place, name, Session(message.welcome, make))
        first = zip(self._trained.values(), response.worlds, strict=True)
        self._exchange({trained: action for trained, message in first if (action := trained.take(message))})

    def _exchange(self, actions: dict[_Trained, pb.WorldAction]) -> Error | None:
        """Does something in some worlds, and waits for a turn of theirs with news; the first refusal, if there is any."""
        refused = None
        while actions and self._stream is not None:
            cycle = pb.TrainingCycle(worlds=actions.values())
            response = self._stream.ask(pb.TrainRequest(cycle=cycle), [trained.name for trained in actions])
            told = list(zip(actions, response.worlds, strict=True))
            for trained, message in told:
                if refused is None and message.HasField("refused"):
                    refused = trained.problem(message.refused)
            taken = [(trained, trained.take(message)) for trained, message in told]
            actions = {trained: action for trained, action in taken if action is not None}
        return refused


class _Stream:
    """Requests to the server, each with a response."""

    def __init__(self, channel: grpc.Channel, address: str) -> None:
        self._address = address
        self._requests: queue.SimpleQueue[pb.TrainRequest | None] = queue.SimpleQueue()
        self._responses = TrainerServiceStub(channel).Train(iter(self._requests.get, None))

    def close(self) -> None:
        self._requests.put(None)
        self._responses.cancel()

    def ask(self, request: pb.TrainRequest, names: Sequence[str]) -> pb.TrainResponse:
        """The response to a request about the worlds of these names."""
        self._requests.put(request)
        try:
            return next(self._responses)
        except grpc.RpcError as error:
            problem = failed(error, self._address)
            raise type(problem)(_named(str(problem), names)) from None
        except StopIteration:
            raise closed() from None


def _named(text: str, names: Sequence[str]) -> str:
    """What is wrong with `worlds[3]` of a request, with the name of that world."""
    place = re.search(r"worlds\[(\d+)\]", text)
    if place is None or int(place[1]) >= len(names):
        return text
    return f"world `{names[int(place[1])]}`: {text}"


class _Trained:
    """A world that is driven."""

    def __init__(self, place: int, name: str, session: Session) -> None:
        self.place, self.name, self._session = place, name, session
        self._robots = [seat.body.robot for seat in session.seats]
        self._asked: dict[str, tuple[Seat, Turn]] = {}
        # Robots that have collided in turns of which the trainer was not told.
        self._collided: set[str] = set()
        self.last = Result(name, 0, 0.0, {}, {})

    def problem(self, problem: pb.TrainingProblem) -> Error:
        return from_status(problem.code, f"world `{self.name}`: {problem.message}")

    def take(self, message: pb.WorldResult) -> pb.WorldAction | None:
        """Takes what is told; the answer if it is a turn without news, to which nobody is asked."""
        if message.HasField("refused"):
            return None
        self._asked = {}
        if message.HasField("turn"):
            self._asked = {seat.body.robot: (seat, turn) for seat, turn in self._session.asked(message.turn)}
        truths = dict(zip(self._robots, message.truths))
        for robot, truth in truths.items():
            truth.collided = truth.collided or robot in self._collided
        if message.HasField("turn") and not self._asked:
            self._collided = {robot for robot, truth in truths.items() if truth.collided}
            return self._step()
        self._collided = set()
        ended = message.ended if message.HasField("ended") else None
        self.last = Result(
            world=self.name,
            tick=message.tick,
            time_s=message.time_ns / 1e9,
            turns={robot: turn for robot, (_, turn) in self._asked.items()},
            truths=truths,
            score=message.score if message.HasField("score") else None,
            ended=_kind(ended.kind) if ended is not None else None,
            error=self.problem(message.closed) if message.HasField("closed") else None,
        )
        return None

    def answer(self, command: Commands) -> pb.WorldAction:
        """The answer to the last turn."""
        if not isinstance(command, Mapping):
            if len(self._robots) != 1 and command is not None:
                raise Refused(f"world `{self.name}` has {len(self._robots)} robots; say what each does: {{name: drive(…)}}")
            command = dict.fromkeys(self._robots, command)
        for robot in command:
            if robot not in self._robots:
                raise NotFound(unknown(f"robot of world `{self.name}`", robot, self._robots))
        for robot, (seat, turn) in self._asked.items():
            seat.answer(turn, command.get(robot))
        return self._step()

    def _step(self) -> pb.WorldAction:
        return pb.WorldAction(world=self.place, step=self._session.answer().step)


def _kind(kind: world_pb2.EndingKind.ValueType) -> str:
    """`time-is-over` of `ENDING_KIND_TIME_IS_OVER`."""
    known = world_pb2.EndingKind.Name(kind) if kind in world_pb2.EndingKind.values() else "UNSPECIFIED"
    return known.removeprefix("ENDING_KIND_").lower().replace("_", "-")


def _for_each(worlds: Sequence[_Trained], given: object, what: str) -> list[Any]:
    """What is given for all worlds, or for each."""
    if isinstance(given, Mapping) or not isinstance(given, Iterable):
        return [given] * len(worlds)
    each = list(given)
    if len(each) != len(worlds):
        raise Refused(f"{what}: there are {len(each)}, but one for each of {len(worlds)} worlds is needed")
    return each
