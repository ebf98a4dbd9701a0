"""What a brain may know of its robot: the data sheet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .errors import NoReading
from .names import unknown
from .v1 import brain_link_pb2 as pb


def kind_name(enum: type, value: int, prefix: str) -> str:
    """The name as in scenario files: `line-camera` of `SENSOR_KIND_LINE_CAMERA`."""
    known: str = enum.Name(value) if value in enum.values() else "UNSPECIFIED"  # type: ignore[attr-defined]
    return known.removeprefix(prefix).lower().replace("_", "-")


@dataclass(frozen=True, slots=True)
class Component:
    """A part of a reading: one value, or as many as a scan has rays."""

    #: Its name; empty if the sensor has only this one.
    name: str
    #: SI unit; `1` for a ratio.
    unit: str
    #: How many values it has.
    count: int


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor as its maker's data sheet has it."""

    name: str
    #: As in scenario files: `ir`, `sonar`, `laser`, `line-camera`, …
    kind: str
    components: tuple[Component, ...]
    #: Time between two samples.
    period_s: float
    #: Where it sits in the robot's frame, forwards and to the left of its centre.
    x_m: float
    y_m: float
    #: Where it looks, counter-clockwise from the robot's heading.
    heading_rad: float
    #: How far its rays rise above the floor's plane; None if they are level.
    elevation_rad: float | None
    #: None if it has no range.
    range_m: float | None
    #: The angle from the first of its rays to the last; None if it has no rays.
    opening_rad: float | None
    #: All of it, as the contract has it.
    description: pb.SensorDescription = field(repr=False)

    @classmethod
    def of(cls, description: pb.SensorDescription) -> Sensor:
        """A sensor as the server describes it."""
        mount = description.mount
        return cls(
            name=description.sensor,
            kind=kind_name(pb.SensorKind, description.kind, "SENSOR_KIND_"),
            components=tuple(Component(c.name, c.unit, max(c.count, 1)) for c in description.components),
            period_s=description.period_ns / 1e9,
            x_m=mount.x_m,
            y_m=mount.y_m,
            heading_rad=mount.heading_rad,
            elevation_rad=mount.elevation_rad if mount.HasField("elevation_rad") else None,
            range_m=description.range_m if description.HasField("range_m") else None,
            opening_rad=description.opening_rad if description.HasField("opening_rad") else None,
            description=description,
        )

    def span(self, component: str) -> slice:
        """Which of a reading's values are this component's."""
        start = 0
        for part in self.components:
            if part.name == component:
                return slice(start, start + part.count)
            start += part.count
        names = [part.name for part in self.components if part.name]
        raise NoReading(unknown("component", component, names, f" of sensor `{self.name}`"))


@dataclass(frozen=True, slots=True)
class Body:
    """A robot as its maker's data sheet has it."""

    #: The robot's name.
    robot: str
    #: Of its disc.
    radius_m: float
    #: Half the distance between its wheels.
    half_track_m: float
    wheel_radius_m: float
    #: Largest size of a motor signal; None if there is none.
    signal_limit: float | None
    #: What turns the wheels: `dc`, `velocity`, `servo` or `stepper`.
    motors: str
    #: By their names, in the order of the wire.
    sensors: Mapping[str, Sensor]
    #: Their names in that order.
    sensor_names: tuple[str, ...]
    #: The index of each in that order.
    places: Mapping[str, int] = field(repr=False)
    #: Names of the actuators besides the wheels, in the order of the wire.
    actuators: tuple[str, ...]
    #: Whether the brain is the microcontroller's program, without a cable.
    onboard: bool
    #: Length of a tick of the world.
    step_s: float
    #: All of it, as the contract has it.
    description: pb.RobotDescription = field(repr=False)

    @classmethod
    def of(cls, description: pb.RobotDescription, step_ns: int) -> Body:
        """A robot as the server describes it."""
        return cls(
            robot=description.robot,
            radius_m=description.radius_m,
            half_track_m=description.half_track_m,
            wheel_radius_m=description.wheel_radius_m,
            signal_limit=description.signal_limit if description.HasField("signal_limit") else None,
            motors=kind_name(pb.MotorKind, description.motor_kind, "MOTOR_KIND_"),
            sensors={sensor.sensor: Sensor.of(sensor) for sensor in description.sensors},
            sensor_names=tuple(sensor.sensor for sensor in description.sensors),
            places={sensor.sensor: place for place, sensor in enumerate(description.sensors)},
            actuators=tuple(actuator.actuator for actuator in description.actuators),
            onboard=description.onboard,
            step_s=step_ns / 1e9,
            description=description,
        )

    def of_kind(self, kind: str) -> list[Sensor]:
        """The sensors of a kind, such as `ir`."""
        return [sensor for sensor in self.sensors.values() if sensor.kind == kind]
