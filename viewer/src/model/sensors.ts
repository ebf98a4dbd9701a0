/** From data sheets to values: which number of a reading is what. */
import {
  SensorKind,
  type Encoding,
  type RobotDescription,
  type SensorDescription,
} from "../gen/baudbot/v1/brain_link_pb";

/** A value of a sensor, or so many of one kind if it is a scan. */
export interface Part {
  /** Such as `odometer.x`; the sensor's name if it has only this one. */
  name: string;
  unit: string;
  /** Where it begins in the reading. */
  first: number;
  count: number;
  /** What it lies in, if that is known. */
  range: [number, number] | undefined;
}

/** The parts of a sensor's reading. */
export function partsOf(sensor: SensorDescription): Part[] {
  let first = 0;
  return sensor.components.map((component) => {
    const count = Math.max(1, component.count);
    const name = component.name === "" ? sensor.sensor : `${sensor.sensor}.${component.name}`;
    const part = {
      name,
      unit: component.unit,
      first,
      count,
      range: rangeOf(sensor, component.unit, component.encoding),
    };
    first += count;
    return part;
  });
}

/** Kinds of sensors whose values are between 0 and 1. */
const SHARES = [SensorKind.IR, SensorKind.WHISKER, SensorKind.BUMPER, SensorKind.FLOOR];

function rangeOf(sensor: SensorDescription, unit: string, encoding: Encoding | undefined): Part["range"] {
  const kind = encoding?.kind;
  if (kind?.case === "level") return [kind.value.min, kind.value.max];
  if (kind?.case === "signed") return [-kind.value.limit, kind.value.limit];
  if (unit === "m" && sensor.rangeM) return [0, sensor.rangeM];
  return SHARES.includes(sensor.kind) ? [0, 1] : undefined;
}

/** Where each sensor's values begin among a robot's `samples`, and how many there are. */
export function columnsOf(robot: RobotDescription): [number, number][] {
  let first = 0;
  return robot.sensors.map((sensor) => {
    const count = partsOf(sensor).reduce((sum, part) => sum + part.count, 0);
    const columns: [number, number] = [first, count];
    first += count;
    return columns;
  });
}
