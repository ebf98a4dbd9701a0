"""A program that drives robots until their run is over."""

from __future__ import annotations

import inspect
import os
import queue
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import grpc

from .brain import Brain, Value
from .channel import open_channel
from .errors import Error, NoServer, Refused, Restart, printable
from .handshake import failed
from .reconnect import Backoff, Tell, tell_on_stderr
from .session import Make, Session, hello
from .settings import Settings
from .v1 import brain_link_pb2 as pb
from .v1 import control_pb2
from .v1.brain_link_pb2_grpc import BrainLinkServiceStub
from .v1.control_pb2_grpc import ControlServiceStub

#: An operator's call is answered at once, or the server is in trouble.
PATIENCE_S = 30.0


@dataclass(frozen=True, slots=True)
class Summary:
    """How a run went."""

    #: Turns of all brains together.
    turns: int
    #: The tick of the last turn.
    last_tick: int


def attach(
    brain: type[Brain],
    *,
    connect: str | None = None,
    world: str | None = None,
    robots: str | Iterable[str] | None = None,
    seed: int | None = None,
    parameters: Mapping[str, Value] | None = None,
    reconnect_s: float | None = None,
    tell: Tell = tell_on_stderr,
    announce: bool = False,
) -> Summary:
    """Drives robots, each with a brain of its own, until the run is over.

    What is not given is taken from the environment (`BAUDBOT_CONNECT`, …), which `baudbot run` sets for the programs that it
    starts, or else is the default: `127.0.0.1:7400`, the server's only world, its only robot. If the connection is lost, it
    tries to reconnect for `reconnect_s` seconds; the brains then start over, since the world may have changed meanwhile. `tell` gets
    the messages about this and, with `announce`, one that says what is driven.

    Raises an `Error`, whose text is a line for people.
    """
    return drive(brain, Settings.find(connect, world, robots, seed, parameters, reconnect_s), tell, announce)


def drive(
    brain: type[Brain], settings: Settings, tell: Tell = tell_on_stderr, announce: bool = False
) -> Summary:
    """Like `attach`, with settings that have been found."""
    for name, value in settings.parameters.items():
        brain.parameter(name, value)
    if inspect.iscoroutinefunction(brain.step):
        raise Error(f"{brain.__name__}.step is a coroutine; attach it with `await baudbot.aio.attach({brain.__name__})`")
    backoff, found = Backoff(settings.reconnect_s, tell), None
    while True:
        try:
            with _channel(settings.connect) as channel:
                found = found or find_robots(channel, settings)
                return _drive(channel, brain, settings, *found, backoff=backoff, tell=tell, announce=announce)
        except Restart:
            tell(f"the operator has restarted the brain of {', '.join(found[1]) if found else 'the robots'}")
        except Error as error:
            time.sleep(backoff.wait_s(error))


@contextmanager
def _channel(address: str) -> Iterator[grpc.Channel]:
    """A channel whose errors are ours."""
    channel = open_channel(address)
    try:
        yield channel
    except grpc.RpcError as error:
        raise failed(error, address) from None
    finally:
        channel.close()


def find_robots(channel: grpc.Channel, settings: Settings) -> tuple[str, list[str]]:
    """The world and the robots that the settings name."""
    if not settings.needs_look():
        assert settings.world is not None
        return settings.world, list(settings.robots)
    try:
        worlds = ControlServiceStub(channel).ListWorlds(control_pb2.ListWorldsRequest(), timeout=PATIENCE_S).worlds
    except grpc.RpcError as error:
        raise (unlisted(error) or error) from None
    return settings.choose(worlds)


def unlisted(error: grpc.RpcError) -> Refused | None:
    """What to do with a token by which worlds and robots cannot be listed, if that is the reason."""
    if error.code() != grpc.StatusCode.PERMISSION_DENIED:
        return None
    return Refused(
        "this token cannot list worlds and robots, so name the world and the robots in full (by world and robots, --world and --robot, or "
        f"BAUDBOT_WORLD and BAUDBOT_ROBOT); the server says: {printable(error.details() or '')}"
    )


def program_name() -> str:
    """What the program calls itself, for people."""
    return os.path.basename(sys.argv[0]) or "python"


def brain_maker(brain: type[Brain], settings: Settings) -> Make:
    """Makes the brain of each robot of a stream."""
    return lambda body: brain(body, settings.seed, settings.parameters)


def closed() -> NoServer:
    """The error of a stream that ends before its run."""
    return NoServer("the server closed the connection before the run was over")


def _drive(
    channel: grpc.Channel,
    brain: type[Brain],
    settings: Settings,
    world: str,
    robots: list[str],
    *,
    backoff: Backoff,
    tell: Tell,
    announce: bool,
) -> Summary:
    requests: queue.SimpleQueue[pb.AttachRequest | None] = queue.SimpleQueue()
    requests.put(hello(world, robots, brain, program_name()))
    responses = BrainLinkServiceStub(channel).Attach(iter(requests.get, None))
    try:
        welcome = next(responses).welcome
        session = Session(welcome, brain_maker(brain, settings))
        driving = f"driving {', '.join(robots)} of world {world}"
        if backoff.is_lost():
            tell(f"reconnected with a restarted brain: {driving}")
        elif announce:
            tell(driving)
        backoff.connected()
        for response in responses:
            if response.HasField("ended"):
                return Summary(session.turns, response.ended.tick)
            if not response.HasField("turn"):
                continue  # of a kind that a later version of the contract has
            for seat, turn in session.asked(response.turn):
                seat.answer(turn, seat.brain.step(turn))
                # In lockstep, what is published before the answer is visible at the next tick, on any machine.
                look = seat.look(turn)
                if look is not None:
                    requests.put(look)
            requests.put(session.answer())
        raise closed()
    except StopIteration:
        raise closed() from None
    finally:
        requests.put(None)
        responses.cancel()
