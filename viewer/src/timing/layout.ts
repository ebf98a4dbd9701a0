/** From events to lanes of bars: what is where in the timing diagram, in nanoseconds and rows. */
import type { RobotDescription } from "../gen/baudbot/v1/brain_link_pb";
import { TimelineKind } from "../gen/baudbot/v1/observe_pb";
import type { Happening } from "../model/timeline";
import type { Cycle } from "./cycle";
import { isIdle, kindOf, type Kind } from "./kinds";
import type { WavePart } from "./pins";

export interface Bar {
  event: Happening;
  /** Which of the rows of its lane. */
  row: number;
  /** What its lane does not say. */
  label: string;
  /** Not of the cycle that is looked at. */
  pale: boolean;
  /** What it looks like and what it is in words, if its event does not say so. */
  style?: Kind;
  tip?: string;
}

export interface Lane {
  label: string;
  /** Lanes of a group stand closer together. */
  group: number;
  rows: number;
  bars: Bar[];
  /** Of a pin: its signal. */
  wave?: WavePart[];
}

/** A part of the time axis. */
export interface Window {
  from_ns: number;
  until_ns: number;
}

/** A robot with more sensors than this has one lane for all; so has one whose lanes do not fit into the page. */
const MOST_SENSOR_LANES = 6;
/** Δt that are shown at most. */
export const MOST_STEPS = 200;
/** More rows than this are no help. */
const MOST_ROWS = 4;

/** The lanes of a robot, in the order of the way of a reading to the brain and of its answer to the motors. */
export function lanes(
  robot: RobotDescription,
  all: Happening[],
  window: Window,
  cycle: Cycle | undefined,
  most = MOST_SENSOR_LANES,
  pins?: Lane[],
): Lane[] {
  const shown = all.filter((event) => isIn(event, window));
  const ofKind = (...kinds: TimelineKind[]) => shown.filter((event) => kinds.includes(event.kind));
  // A program of the user's own has no steps that are known; its pins say what it does.
  const lane = (label: string, group: number, events: Happening[], always = pins === undefined) =>
    always || events.length > 0 ? [makeLane(robot, label, group, events, cycle)] : [];
  const K = TimelineKind;
  return [
    ...sensorLanes(robot, ofKind(K.ACQUIRE, K.MEASURE), cycle, most),
    ...(pins ?? []),
    ...lane("framing", 1, ofKind(K.FRAME, K.BLOCK)),
    ...lane("cable up", 2, ofKind(K.UP)),
    ...lane("adapter", 2, ofKind(K.ADAPTER), false),
    ...lane("own cables", 2, ofKind(K.PORT), false),
    ...lane("thinking", 3, ofKind(K.THINK)),
    ...lane("cable down", 4, ofKind(K.DOWN)),
    ...lane("to devices", 4, ofKind(K.PORT_DOWN), false),
    ...lane("obeying", 5, ofKind(K.OBEY)),
    ...lane("actuation", 5, ofKind(K.ACT)),
    ...lane("trouble", 6, ofKind(K.LATE, K.MISSED, K.LOST, K.FAULT), false),
  ];
}

/** Whether something of it is in a window. */
export function isIn(event: Happening, { from_ns, until_ns }: Window): boolean {
  return event.start_ns < until_ns && (event.end_ns > from_ns || event.start_ns >= from_ns);
}

function sensorLanes(robot: RobotDescription, events: Happening[], cycle: Cycle | undefined, most: number): Lane[] {
  const { sensors } = robot;
  if (sensors.length > most) return [makeLane(robot, "acquisition", 0, events, cycle)];
  return sensors.map((sensor, i) => {
    const own = events.filter((event) => event.part === i);
    return makeLane(robot, sensor.sensor, 0, own, cycle);
  });
}

function makeLane(
  robot: RobotDescription,
  label: string,
  group: number,
  events: Happening[],
  cycle: Cycle | undefined,
): Lane {
  const ends: number[] = [];
  const sorted = [...events].sort((a, b) => a.start_ns - b.start_ns || a.end_ns - b.end_ns);
  const bars = sorted.map((event) => {
    const pale = cycle !== undefined && !cycle.events.has(event) && !kindOf(event.kind).trouble;
    const text = barLabel(robot, event);
    return { event, row: rowFor(ends, event), label: text === label ? "" : text, pale };
  });
  return { label, group, rows: Math.max(1, ends.length), bars };
}

/** The first row that is free; what overlaps is in rows below each other, and what finds no place in the last. */
function rowFor(ends: number[], event: Happening): number {
  let row = ends.findIndex((end_ns) => end_ns <= event.start_ns);
  if (row < 0) row = ends.length < MOST_ROWS ? ends.length : MOST_ROWS - 1;
  // Of two marks at one instant, one would hide the other.
  ends[row] = Math.max(ends[row] ?? 0, event.end_ns + (event.end_ns === event.start_ns ? 1 : 0));
  return row;
}

function barLabel(robot: RobotDescription, event: Happening): string {
  const bytes = `${event.bytes} ${event.bytes === 1 ? "byte" : "bytes"}`;
  const K = TimelineKind;
  switch (event.kind) {
    case K.ACQUIRE:
    case K.MEASURE:
      return robot.sensors[event.part ?? -1]?.sensor ?? "";
    case K.UP:
    case K.DOWN:
    case K.PORT:
    case K.PORT_DOWN:
      return bytes;
    case K.THINK:
      return isIdle(event) ? "no news" : "think";
    case K.BLOCK:
      return "wait";
    case K.LATE:
      return "late";
    case K.LOST:
      return `${bytes} lost`;
    case K.MISSED:
      return "skipped";
    default:
      return "";
  }
}

/** What happened, in words. */
export function what(robot: RobotDescription, event: Happening): string {
  const sensor = event.part === undefined ? undefined : robot.sensors[event.part]?.sensor;
  const K = TimelineKind;
  const named =
    [K.ACQUIRE, K.MEASURE, K.PORT, K.PORT_DOWN, K.MISSED].includes(event.kind) && sensor ? `${sensor}: ` : "";
  const bytes = event.bytes > 0 ? `, ${event.bytes} bytes` : "";
  const news = isIdle(event) ? ", without news" : "";
  return `${named}${kindOf(event.kind).words}${bytes}${news}`;
}

/**
 * What part of time is shown: so many Δt from a little before the last cycle began; without a cycle the last ones.
 * With 0 it is as many as that cycle needs.
 */
export function windowFor(cycle: Cycle | undefined, now_ns: number, step_ns: number, steps: number): Window {
  if (!cycle) {
    const count = steps || 3;
    const until_ns = Math.max(count, Math.ceil(now_ns / step_ns)) * step_ns;
    return { from_ns: until_ns - count * step_ns, until_ns };
  }
  const needed = Math.ceil((cycle.end_ns - cycle.begun_ns) / step_ns + 0.1);
  const count = steps || Math.min(MOST_STEPS, Math.max(1, needed));
  const from_ns = cycle.begun_ns - 0.06 * count * step_ns;
  return { from_ns, until_ns: cycle.begun_ns + 1.04 * count * step_ns };
}
