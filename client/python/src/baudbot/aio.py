"""The same as `baudbot.attach`, for programs with asyncio; a brain's `step` may be a coroutine."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager

import grpc.aio

from .attach import PATIENCE_S, Summary, brain_maker, closed, program_name, unlisted
from .brain import Brain, Value
from .channel import open_aio_channel
from .credentials import Credentials
from .errors import Error, Restart
from .handshake import failed
from .reconnect import Backoff, Tell, tell_on_stderr
from .session import Session, hello
from .settings import Settings
from .v1 import brain_link_pb2 as pb
from .v1 import control_pb2
from .v1.brain_link_pb2_grpc import BrainLinkServiceStub
from .v1.control_pb2_grpc import ControlServiceStub

Metadata = tuple[tuple[str, str], ...]


async def attach(
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
    """Like `baudbot.attach`. Cancelling it detaches the brains."""
    settings = Settings.find(connect, world, robots, seed, parameters, reconnect_s)
    for name, value in settings.parameters.items():
        brain.parameter(name, value)
    backoff, found = Backoff(settings.reconnect_s, tell), None
    while True:
        try:
            async with _channel(settings.connect) as (channel, metadata):
                found = found or await _find_robots(channel, metadata, settings)
                call = BrainLinkServiceStub(channel).Attach(metadata=metadata)
                return await _drive(call, brain, settings, *found, backoff=backoff, tell=tell, announce=announce)
        except Restart:
            tell(f"the operator has restarted the brain of {', '.join(found[1]) if found else 'the robots'}")
        except Error as error:
            await asyncio.sleep(backoff.wait_s(error))


@asynccontextmanager
async def _channel(address: str) -> AsyncIterator[tuple[grpc.aio.Channel, Metadata]]:
    credentials = Credentials.find(address)
    channel = open_aio_channel(address, credentials)
    try:
        yield channel, credentials.metadata
    except grpc.aio.AioRpcError as error:
        # It may look why, which takes a while.
        raise (await asyncio.to_thread(failed, error, address)) from None
    finally:
        await channel.close()


async def _find_robots(channel: grpc.aio.Channel, metadata: Metadata, settings: Settings) -> tuple[str, list[str]]:
    if not settings.needs_look():
        assert settings.world is not None
        return settings.world, list(settings.robots)
    request = control_pb2.ListWorldsRequest()
    try:
        listed = await ControlServiceStub(channel).ListWorlds(request, timeout=PATIENCE_S, metadata=metadata)
    except grpc.aio.AioRpcError as error:
        raise (unlisted(error) or error) from None
    return settings.choose(listed.worlds)


async def _drive(
    call: grpc.aio.StreamStreamCall[pb.AttachRequest, pb.AttachResponse],
    brain: type[Brain],
    settings: Settings,
    world: str,
    robots: list[str],
    *,
    backoff: Backoff,
    tell: Tell,
    announce: bool,
) -> Summary:
    try:
        await call.write(hello(world, robots, brain, program_name()))
        first = await call.read()
        if not isinstance(first, pb.AttachResponse):
            raise closed()
        session = Session(first.welcome, brain_maker(brain, settings))
        driving = f"driving {', '.join(robots)} of world {world}"
        if backoff.is_lost():
            tell(f"reconnected with a restarted brain: {driving}")
        elif announce:
            tell(driving)
        backoff.connected()
        while isinstance(response := await call.read(), pb.AttachResponse):
            if response.HasField("ended"):
                return Summary(session.turns, response.ended.tick)
            if not response.HasField("turn"):
                continue  # of a kind that a later version of the contract has
            for seat, turn in session.asked(response.turn):
                output = seat.brain.step(turn)
                seat.answer(turn, await output if inspect.isawaitable(output) else output)
                look = seat.look(turn)
                if look is not None:
                    await call.write(look)
            await call.write(session.answer())
        raise closed()
    finally:
        call.cancel()
