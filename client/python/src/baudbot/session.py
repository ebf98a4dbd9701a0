"""An attached stream without its transport: who is asked in a turn, and the answer to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from .body import Body
from .brain import Brain
from .commands import Command, Poll
from .errors import Error
from .turn import Turn
from .v1 import brain_link_pb2 as pb

#: How often people see a brain's beliefs, in simulated time.
_LOOKS_EVERY_NS = 50_000_000
_NEVER_NS = 1 << 63

#: Makes a robot's brain.
Make = Callable[[Body], Brain]


class Seat:
    """A robot of the stream and its brain."""

    __slots__ = ("_look_ns", "_part", "_patience_ns", "body", "brain", "deadline_ns", "place", "tick")

    def __init__(self, place: int, body: Body, brain: Brain) -> None:
        self.place, self.body, self.brain = place, body, brain
        # In which it stepped last.
        self.tick = -1
        if brain.every_tick:
            self._patience_ns = 0
        else:
            self._patience_ns = _NEVER_NS if brain.patience_s is None else round(brain.patience_s * 1e9)
        # What the brain waits for ends then; 0: it is asked at each turn.
        self.deadline_ns = 0
        self._look_ns = 0
        self._part = pb.RobotStep()

    def is_asked(self, turn: Turn) -> bool:
        """A server may ask brains that wait, too, and in paces other than lockstep it does."""
        return turn.at_ns >= self.deadline_ns or turn.news

    def forget(self) -> None:
        """The world went back in time, and what was waited for there means nothing here."""
        self.deadline_ns, self._look_ns = 0, 0

    def begin(self, part: pb.RobotStep) -> None:
        """Its part of the answer is written here."""
        self._part = part
        if self.place:
            part.robot = self.place

    def answer(self, turn: Turn, output: object) -> None:
        """Writes what the brain has decided. Anything that is not an `Output` is refused."""
        part = self._part
        if isinstance(output, Command):
            self._command(part, output, turn)
        elif isinstance(output, bytes) and self.brain.raw:
            part.raw = output
        elif isinstance(output, Poll):
            part.poll.SetInParent()
        elif output is None:
            # A trainer may say it after something else, which was refused because of another world.
            part.ClearField("output")
        else:
            # Also a coroutine, of which only `baudbot.aio` takes the result.
            expected = "bytes" if self.brain.raw else "drive(left, right), poll() or None"
            raise Error(f"{type(self.brain).__name__}.step must return {expected}, returned {output!r}")
        self.deadline_ns = turn.at_ns + self._patience_ns if self._patience_ns else 0
        self.wait()

    def _command(self, part: pb.RobotStep, output: Command, turn: Turn) -> None:
        left, right, others, thinking_s, operations = output
        if turn.missed and any(signal != signal for signal in (left, right, *(others or ()))):
            raise Error(self._unknown(turn.missed))
        command = part.command
        try:
            command.left_signal = left
            command.right_signal = right
            if others:
                command.other_signals[:] = others
        except TypeError:
            raise Error(f"{type(self.brain).__name__}.step: signals must be numbers, got {output!r}") from None
        if thinking_s is None and operations is None:
            return
        if not self.brain.tells_thinking:
            raise Error(f"{type(self.brain).__name__} says how long it has thought; set `tells_thinking = True` in the class")
        if thinking_s is not None:
            part.thinking_ns = round(thinking_s * 1e9)
        if operations is not None:
            part.operations = operations

    def _unknown(self, sensors: Sequence[str]) -> str:
        named = " and ".join(f"`{sensor}`" for sensor in dict.fromkeys(sensors))
        return (
            f"{type(self.brain).__name__}.step: a signal is no number, as nothing has arrived from {named} yet; say what to take "
            f'until then, as in turn.value("{sensors[0]}", 0.0)'
        )

    def wait(self) -> None:
        """Says what the brain waits for."""
        if self.deadline_ns >= _NEVER_NS:
            self._part.until_message.SetInParent()
        elif self.deadline_ns:
            self._part.until_message.at_latest_ns = self.deadline_ns

    def look(self, turn: Turn) -> pb.AttachRequest | None:
        """What people see of it now, if they look at this instant."""
        if turn.at_ns < self._look_ns:
            return None
        self._look_ns = turn.at_ns + _LOOKS_EVERY_NS
        belief = self.brain.belief()
        if belief is None:
            return None
        return pb.AttachRequest(annotate=pb.Annotate(robot=self.place, belief=belief.message()))


class Session:
    """The robots of a stream, and how its turns are answered."""

    def __init__(self, welcome: pb.Welcome, make: Make) -> None:
        bodies = [Body.of(robot, welcome.step_ns) for robot in welcome.robots]
        self._make = make
        self.seats = [Seat(place, body, make(body)) for place, body in enumerate(bodies)]
        #: Turns in which a brain was asked, and the tick of the last.
        self.turns, self.tick = 0, -1
        self._request = pb.AttachRequest()
        for seat in self.seats:
            seat.brain.start()

    def asked(self, turn: pb.Turn) -> Iterator[tuple[Seat, Turn]]:
        """The robots that are asked in this turn. Each must be answered before the next is taken."""
        self.tick = turn.tick
        self._request = pb.AttachRequest()
        step = self._request.step
        step.turn = turn.turn
        for part in turn.robots:
            seat = self.seats[part.robot]
            if turn.tick <= seat.tick:
                self._renew(seat)
            seat.tick = turn.tick
            seat.begin(step.robots.add())
            arrived = Turn(seat.body, part, turn.tick)
            if seat.is_asked(arrived):
                self.turns += 1
                yield seat, arrived
            else:
                seat.wait()

    def _renew(self, seat: Seat) -> None:
        """The world went back in time, as by a reset: this is another run, and has a new brain. A robot steps once in a tick."""
        seat.brain = self._make(seat.body)
        seat.brain.start()
        seat.forget()

    def answer(self) -> pb.AttachRequest:
        """The answer to the turn whose robots have been asked."""
        return self._request


def hello(world: str, robots: Sequence[str], brain: type[Brain], name: str) -> pb.AttachRequest:
    """The first request."""
    message = pb.Hello(
        world=world,
        robots=robots,
        mode=pb.PORT_MODE_RAW if brain.raw else pb.PORT_MODE_MESSAGES,
        brain="".join(c if c.isprintable() else "?" for c in name)[:64],
        thinks_as_scenario=not brain.tells_thinking,
        stop_when_gone=brain.stop_when_gone,
    )
    if brain.memory_bytes is not None:
        message.memory_bytes = brain.memory_bytes
    return pb.AttachRequest(hello=message)
