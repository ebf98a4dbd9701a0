"""What has arrived for a brain, and the time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from .errors import NoReading
from .names import unknown

if TYPE_CHECKING:
    from .body import Body, Sensor
    from .v1 import brain_link_pb2 as pb


class Reading:
    """The last reading of a sensor, as it came over the wire."""

    __slots__ = ("_at_ns", "_message", "sensor")

    def __init__(self, sensor: Sensor, message: pb.Reading, at_ns: int) -> None:
        self.sensor, self._message, self._at_ns = sensor, message, at_ns

    @property
    def value(self) -> float:
        """The first value, in SI units."""
        value: float = self._message.values[0]
        return value

    @property
    def values(self) -> list[float]:
        """All values, component by component, in SI units. A ray that met nothing has -1."""
        return list(self._message.values)

    @property
    def ranges_m(self) -> list[float]:
        """The values as distances: infinite for a ray that met nothing."""
        return [math.inf if value < 0.0 else value for value in self._message.values]

    def __getitem__(self, component: str) -> float:
        """The value of a component by its name, such as `x_m` of an odometer, or the first of its values."""
        value: float = self._message.values[self.sensor.span(component).start]
        return value

    def all_of(self, component: str) -> list[float]:
        """All values of a component, such as the rays of a scan."""
        return list(self._message.values[self.sensor.span(component)])

    @property
    def readable(self) -> bool:
        """New since the last turn; an old reading is repeated with False."""
        return self._message.readable

    @property
    def sequence(self) -> int:
        """Number of the message that brought it; it wraps at 256."""
        return self._message.sequence

    @property
    def sampled_at_s(self) -> float | None:
        """When it was sampled, by the microcontroller's clock; None if the protocol does not say."""
        return self._message.sampled_at_ns / 1e9 if self._message.HasField("sampled_at_ns") else None

    @property
    def age_s(self) -> float | None:
        """How old the sample is; None if the protocol does not say."""
        if not self._message.HasField("sampled_at_ns"):
            return None
        return max(self._at_ns - self._message.sampled_at_ns, 0) / 1e9

    def __repr__(self) -> str:
        age = "age unknown" if self.age_s is None else f"{self.age_s * 1e3:.3f} ms old"
        values = ", ".join(f"{value:.4g}" for value in self._message.values[:4])
        more = ", …" if len(self._message.values) > 4 else ""
        return f"<{self.sensor.name}: {values}{more}; {age}{'' if self.readable else ', not new'}>"


class Turn(Mapping[str, Reading]):
    """A brain's step. As a mapping it has the last reading of each sensor from which one has arrived, by the sensor's name."""

    # Nothing is made of a message before it is asked for: ten robots with five sensors each have fifty readings in a turn.
    __slots__ = ("_arrived", "_message", "_readings", "at_ns", "body", "missed", "tick")

    def __init__(self, body: Body, message: pb.RobotTurn, tick: int) -> None:
        self.body, self._message, self.tick = body, message, tick
        #: The instant of the step, by the laptop's clock, in simulated nanoseconds since the start of the run.
        self.at_ns: int = message.at_ns
        self._readings = message.readings
        self._arrived: dict[str, pb.Reading] | None = None
        #: Sensors whose values were asked for before any had arrived, without a default.
        self.missed: tuple[str, ...] = ()

    @property
    def at_s(self) -> float:
        """The same in seconds."""
        return self.at_ns / 1e9

    @property
    def news(self) -> bool:
        """Whether anything has arrived since the last turn; a message of the robot's may have no new reading."""
        if self._message.has_message:
            return True
        for reading in self._readings:
            if reading.readable:
                return True
        return bool(self._message.raw or self._message.ports)

    @property
    def raw(self) -> bytes:
        """The bytes that arrived on the robot's cable since the last turn, for a `RawBrain`."""
        return self._message.raw

    @property
    def ports(self) -> dict[str, bytes]:
        """The bytes that arrived on the sensors' own cables since the last turn, for a `RawBrain`."""
        names = self.body.sensor_names
        return {names[port.sensor]: port.data for port in self._message.ports}

    def _all(self) -> dict[str, pb.Reading]:
        arrived = self._arrived
        if arrived is None:
            names = self.body.sensor_names
            arrived = self._arrived = {names[one.sensor]: one for one in self._readings}
        return arrived

    def _find(self, sensor: str) -> pb.Reading | None:
        """The last reading of a sensor; None if none has arrived yet, or if there is no such sensor."""
        try:
            # Once something has arrived from all sensors, each reading is at its sensor's place.
            place = self.body.places[sensor]
            reading = self._readings[place]
            if reading.sensor == place:
                return reading
        except (KeyError, IndexError):
            pass
        return self._all().get(sensor)

    def __getitem__(self, sensor: str) -> Reading:
        reading = self._find(sensor)
        if reading is None:
            raise self._missing(sensor)
        return Reading(self.body.sensors[sensor], reading, self.at_ns)

    def get(self, sensor: str, default: Reading | None = None) -> Reading | None:  # type: ignore[override]
        """The last reading of a sensor; `default` if none has arrived yet."""
        reading = self._find(sensor)
        if reading is not None:
            return Reading(self.body.sensors[sensor], reading, self.at_ns)
        if sensor not in self.body.sensors:
            raise self._missing(sensor)
        return default

    def value(self, sensor: str, default: float = math.nan) -> float:
        """The first value of a sensor's last reading; `default` if none has arrived yet. Without a default that is no number, and
        a command that is made of it is refused.
        """
        reading = self._find(sensor)
        if reading is not None:
            first: float = reading.values[0]
            return first
        if sensor not in self.body.sensors:
            raise self._missing(sensor)
        if default != default:
            self.missed += (sensor,)
        return default

    def _missing(self, sensor: str) -> NoReading:
        if sensor in self.body.sensors:
            return NoReading(f"nothing has arrived from sensor `{sensor}` yet; `turn.get` gives None in that case")
        return NoReading(unknown("sensor", sensor, list(self.body.sensors), f" of robot `{self.body.robot}`"))

    def __contains__(self, sensor: object) -> bool:
        return isinstance(sensor, str) and self._find(sensor) is not None

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def __repr__(self) -> str:
        return f"<turn at {self.at_s:.6g} s: {list(self.values())}>"
