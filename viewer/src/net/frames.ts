/** Frames of a Watch, decoded as far as all are looked at: poses. The rest of a robot is decoded when asked for. */
import { fromBinary } from "@bufbuild/protobuf";
import {
  RobotTruthSchema,
  WatchResponseSchema,
  type RobotTruth,
  type WatchResponse,
} from "../gen/baudbot/v1/observe_pb";
import { Cursor } from "./cursor";

/** Where all robots are, in the order of DescribeWorld. */
export interface Poses {
  count: number;
  x_m: Float64Array;
  y_m: Float64Array;
  heading_rad: Float64Array;
  /** 1 if it ran into something in the last tick. */
  collided: Uint8Array;
}

/** The truth at an instant. */
export class Frame {
  private readonly truths: (RobotTruth | undefined)[] = [];

  constructor(
    /** All but its robots. */
    readonly rest: WatchResponse,
    readonly poses: Poses,
    private readonly robots: Uint8Array[],
  ) {}

  get tick(): bigint {
    return this.rest.tick;
  }

  get timeNs(): bigint {
    return this.rest.timeNs;
  }

  /** All about one robot. */
  truth(robot: number): RobotTruth | undefined {
    const bytes = this.robots[robot];
    return (this.truths[robot] ??= bytes && fromBinary(RobotTruthSchema, bytes));
  }
}

/** A frame from a serialised WatchResponse. */
export function decodeFrame(bytes: Uint8Array): Frame {
  const cursor = new Cursor(bytes);
  const robots: Uint8Array[] = [];
  const others: Uint8Array[] = [];
  while (!cursor.done) {
    const start = cursor.offset;
    const tag = cursor.varint();
    if (tag >>> 3 === WatchResponseSchema.field.robots.number) robots.push(cursor.chunk());
    else {
      cursor.skip(tag & 7);
      others.push(bytes.subarray(start, cursor.offset));
    }
  }
  return new Frame(fromBinary(WatchResponseSchema, joined(others)), decodePoses(robots), robots);
}

function joined(parts: Uint8Array[]): Uint8Array {
  const whole = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}

function decodePoses(robots: Uint8Array[]): Poses {
  const count = robots.length;
  const poses: Poses = {
    count,
    x_m: new Float64Array(count),
    y_m: new Float64Array(count),
    heading_rad: new Float64Array(count),
    collided: new Uint8Array(count),
  };
  robots.forEach((bytes, robot) => decodePose(poses, robot, bytes));
  return poses;
}

const FIELD = RobotTruthSchema.field;

function decodePose(poses: Poses, robot: number, bytes: Uint8Array): void {
  const cursor = new Cursor(bytes);
  while (!cursor.done) {
    const tag = cursor.varint();
    const field = tag >>> 3;
    if (field === FIELD.xM.number) poses.x_m[robot] = cursor.double();
    else if (field === FIELD.yM.number) poses.y_m[robot] = cursor.double();
    else if (field === FIELD.headingRad.number) poses.heading_rad[robot] = cursor.double();
    else if (field === FIELD.collided.number) poses.collided[robot] = cursor.varint();
    else cursor.skip(tag & 7);
  }
}
