/**
 * Dead reckoning: where a robot would believe itself to be if it had nothing but its wheels. It is computed here from
 * readings that have reached the brain's end of the cable; neither server nor brain has a part in it.
 *
 * Differential drive, Eqs. (2.1) ff. of the notes: with the ways s_l, s_r of the wheels and half their distance b
 *
 *     s = (s_l + s_r) / 2,  Δφ = (s_r - s_l) / (2 b),  along the middle heading φ + Δφ/2
 */
import { SensorKind, type RobotDescription, type SensorDescription } from "../gen/baudbot/v1/brain_link_pb";
import type { Pose } from "./pose";

/** What of a data sheet dead reckoning needs. */
export interface Wheels {
  wheel_radius_m: number;
  half_track_m: number;
  counts_per_turn: number;
  /** A counter begins again at this number; 0 if it does not wrap. */
  wraps_at: number;
}

/** The pose after the wheels went so many counts on. */
export function rolled(pose: Pose, wheels: Wheels, left_counts: number, right_counts: number): Pose {
  const way_m = (2 * Math.PI * wheels.wheel_radius_m) / wheels.counts_per_turn;
  const [left_m, right_m] = [left_counts * way_m, right_counts * way_m];
  const turn_rad = (right_m - left_m) / (2 * wheels.half_track_m);
  const middle_rad = pose.heading_rad + turn_rad / 2;
  const forward_m = (left_m + right_m) / 2;
  return {
    x_m: pose.x_m + forward_m * Math.cos(middle_rad),
    y_m: pose.y_m + forward_m * Math.sin(middle_rad),
    heading_rad: pose.heading_rad + turn_rad,
  };
}

/** How far a counter went on, the shorter way round if it wraps. */
export function counted(before: number, now: number, wraps_at: number): number {
  const difference = now - before;
  return wraps_at > 0 ? difference - wraps_at * Math.round(difference / wraps_at) : difference;
}

/** A sensor that tells how the wheels turned, and where its reading is among the sensors. */
export type WheelSensor = { kind: "odometer"; sensor: number } | { kind: "encoders"; sensor: number; wheels: Wheels };

/** The best sensor for it that a robot has, if any: an odometer, which does the sums itself, or else encoders. */
export function wheelSensor(robot: RobotDescription): WheelSensor | undefined {
  const odometer = robot.sensors.findIndex((sensor) => sensor.kind === SensorKind.ODOMETER);
  if (odometer >= 0) return { kind: "odometer", sensor: odometer };
  const encoders = robot.sensors.findIndex((sensor) => sensor.kind === SensorKind.ENCODERS && sensor.countsPerTurn);
  const description = robot.sensors[encoders];
  if (!description || !(robot.halfTrackM > 0)) return undefined;
  return { kind: "encoders", sensor: encoders, wheels: wheelsOf(robot, description) };
}

function wheelsOf(robot: RobotDescription, encoders: SensorDescription): Wheels {
  const encoding = encoders.components[0]?.encoding?.kind;
  return {
    wheel_radius_m: robot.wheelRadiusM,
    half_track_m: robot.halfTrackM,
    counts_per_turn: encoders.countsPerTurn ?? 1,
    wraps_at: encoding?.case === "counter" ? 2 ** encoding.value.bits : 0,
  };
}

/** How far dead reckoning has got. */
export interface Reckoned {
  pose: Pose;
  counts: [number, number] | undefined;
}

/** Follows a robot's wheels from a true pose on. */
export class DeadReckoning {
  pose: Pose | undefined;
  private counts: [number, number] | undefined;

  constructor(readonly source: WheelSensor) {}

  /** How far it is, to go back to. */
  get reckoned(): Reckoned | undefined {
    return this.pose && { pose: this.pose, counts: this.counts };
  }

  /** Goes on from there; from nothing it starts over. */
  goOn(from: Reckoned | undefined): void {
    this.pose = from?.pose;
    this.counts = from?.counts;
  }

  /** A reading has come; `true_pose` is where the robot was when it was taken, if that is known. */
  take(values: readonly number[], true_pose: Pose): void {
    const [first, second, third] = values;
    if (first === undefined || second === undefined) return;
    if (this.source.kind === "odometer") {
      this.pose = { x_m: first, y_m: second, heading_rad: third ?? 0 };
      return;
    }
    if (this.pose && this.counts) {
      const { wheels } = this.source;
      const left = counted(this.counts[0], first, wheels.wraps_at);
      const right = counted(this.counts[1], second, wheels.wraps_at);
      this.pose = rolled(this.pose, wheels, left, right);
    } else {
      this.pose = { ...true_pose };
    }
    this.counts = [first, second];
  }
}
