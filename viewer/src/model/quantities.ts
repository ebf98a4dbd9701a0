/** What of a robot is a number that changes: what the charts can show. */
import type { Belief, RobotDescription } from "../gen/baudbot/v1/brain_link_pb";
import type { RobotDetail, RobotTruth } from "../gen/baudbot/v1/observe_pb";
import { count, duration, fixed, numberOf } from "./units";
import { columnsOf, partsOf } from "./sensors";

export type Values = Map<string, number>;

/** What the values of a frame are computed from. */
export interface Snapshot {
  time_ns: bigint;
  truth: RobotTruth | undefined;
  detail: RobotDetail | undefined;
  belief: Belief | undefined;
}

/** What had gone over the link at an instant. */
export interface Sent {
  time_ns: bigint;
  up: bigint;
  down: bigint;
}

/** What has gone over the link by now, if that is known. */
export function sentBy(now: Snapshot): Sent | undefined {
  const detail = now.detail;
  return detail && { time_ns: now.time_ns, up: detail.uplink?.bytes ?? 0n, down: detail.downlink?.bytes ?? 0n };
}

/** All values of a frame; rates are those since `before`. */
export function quantities(description: RobotDescription, now: Snapshot, before: Sent | undefined): Values {
  const values: Values = new Map();
  if (now.truth) truthValues(values, now.truth, description);
  description.sensors.forEach((sensor, i) => {
    for (const [name, value] of sensorValues(description, i, now)) values.set(`sensor:${name}`, value);
    const ages = agesOf(now, i);
    if (!ages) return;
    values.set(`age:${sensor.sensor}`, ages.most_ns / 1e6).set(`least-age:${sensor.sensor}`, ages.least_ns / 1e6);
  });
  for (const utility of now.belief?.utilities.slice(0, 32) ?? []) values.set(`utility:${utility.name}`, utility.value);
  if (now.detail) detailValues(values, now.detail);
  const sent = sentBy(now);
  if (sent && before) rateValues(values, sent, before);
  return values;
}

function truthValues(values: Values, truth: RobotTruth, description: RobotDescription): void {
  values.set("pose:x", truth.xM).set("pose:y", truth.yM).set("pose:heading", truth.headingRad);
  values.set("speed", truth.speedMS).set("turn", truth.turnRateRadS);
  values.set("signal:left", truth.leftSignal).set("signal:right", truth.rightSignal);
  if (truth.battery) {
    values.set("battery:charge", truth.battery.charge).set("battery:voltage", truth.battery.voltageV);
    values.set("battery:current", truth.battery.currentA);
  }
  truth.actuators.forEach((actuator, i) => {
    values.set(`actuator:${description.actuators[i]?.actuator ?? i}`, actuator.signal);
  });
}

/** The single values of a sensor as its brain has them, or else as they were sampled; of a scan its least. */
function sensorValues(description: RobotDescription, i: number, now: Snapshot): [string, number][] {
  const sensor = description.sensors[i];
  const reading = readingOf(description, i, now);
  if (!sensor || reading.length === 0) return [];
  return partsOf(sensor).map((part) => {
    const values = reading.slice(part.first, part.first + part.count);
    return [part.name, part.count === 1 ? (values[0] ?? NaN) : leastOf(values)];
  });
}

/** What has reached the brain; before anything has, or without details, the last sample. */
export function readingOf(description: RobotDescription, i: number, now: Snapshot): readonly number[] {
  const reading = now.detail?.sensors[i]?.values;
  if (reading && reading.length > 0) return reading;
  if (now.detail) return [];
  const [first, count] = columnsOf(description)[i] ?? [0, 0];
  return now.truth?.samples.slice(first, first + count) ?? [];
}

/** The least distance of a scan; NaN if it meets nothing. */
function leastOf(values: readonly number[]): number {
  const met = values.filter((value) => value >= 0);
  return met.length > 0 ? Math.min(...met) : NaN;
}

/** The least and the most of some ages, in nanoseconds. */
export interface Ages {
  least_ns: number;
  most_ns: number;
}

/**
 * How old a sensor's reading was at least and at most since the frame before, all instants in between counted: frames come in step
 * with readings, so that at the frames alone a reading would always seem to be of the same age.
 */
export function agesOf(now: Snapshot, sensor: number): Ages | undefined {
  const detail = now.detail?.sensors[sensor];
  if (detail?.leastAgeNs === undefined || detail.mostAgeNs === undefined) return undefined;
  return { least_ns: numberOf(detail.leastAgeNs), most_ns: numberOf(detail.mostAgeNs) };
}

/** Both together. */
export function joined(some: Ages | undefined, others: Ages | undefined): Ages | undefined {
  if (!some || !others) return some ?? others;
  return { least_ns: Math.min(some.least_ns, others.least_ns), most_ns: Math.max(some.most_ns, others.most_ns) };
}

/** The least and the most, such as `20.4–40.4 ms`. */
export function agesText({ least_ns, most_ns }: Ages): string {
  const [least, most] = [duration(least_ns), duration(most_ns)];
  if (least === most) return most;
  const unit = most.slice(most.indexOf(" "));
  return least.endsWith(unit) ? `${least.slice(0, -unit.length)}–${most}` : `${least} – ${most}`;
}

/** How many messages went over the link, and what is the matter if the brain writes more of them than it reads. */
export function messagesText(up: bigint, down: bigint): string {
  const text = `${count(up)} messages up, ${count(down)} down`;
  const times = numberOf(down) / Math.max(1, numberOf(up));
  if (numberOf(up) < ENOUGH || times < OFTEN) return text;
  return `${text}: the brain wrote ${fixed(times, 1)} times as often as it read; commands without news delay those that have some`;
}

/** Of so many messages it is no matter of chance. */
const ENOUGH = 50;
/** Brains that repeat their commands now and then write less than that. */
const OFTEN = 1.5;

function detailValues(values: Values, detail: RobotDetail): void {
  values
    .set("waiting:up", numberOf(detail.uplinkWaitingBytes))
    .set("waiting:down", numberOf(detail.downlinkWaitingBytes));
  const cycles = detail.cycles;
  if (cycles) values.set("cycles:late", numberOf(cycles.late)).set("cycles:kept", numberOf(cycles.kept));
}

function rateValues(values: Values, now: Sent, before: Sent): void {
  const span_s = numberOf(now.time_ns - before.time_ns) / 1e9;
  if (span_s <= 0) return;
  values.set("rate:up", numberOf(now.up - before.up) / span_s);
  values.set("rate:down", numberOf(now.down - before.down) / span_s);
}

/** What a key is called in a chart. */
export function labelOf(key: string): string {
  const [group, name] = split(key);
  const labels: Record<string, string> = {
    speed: "speed",
    turn: "turn rate",
    pose: name === "heading" ? "heading" : name,
    signal: `${name} signal`,
    age: `age of ${name}, at most`,
    "least-age": `age of ${name}, at least`,
    rate: `bytes ${name}`,
    waiting: `waiting ${name}`,
    cycles: `${name} cycles`,
    utility: `utility ${name}`,
    battery: `battery ${name}`,
  };
  return labels[group] ?? name;
}

/** The unit of a key's values. */
export function unitOf(key: string, robot: RobotDescription | undefined): string {
  const [group, name] = split(key);
  if (group === "sensor") {
    const parts = robot?.sensors.flatMap(partsOf) ?? [];
    return parts.find((part) => part.name === name)?.unit ?? "";
  }
  const units: Record<string, string> = {
    speed: "m/s",
    turn: "rad/s",
    pose: name === "heading" ? "rad" : "m",
    signal: "1",
    age: "ms",
    "least-age": "ms",
    rate: "B/s",
    waiting: "B",
    cycles: "cycles",
    utility: "1",
    battery: { charge: "1", voltage: "V", current: "A" }[name] ?? "",
  };
  return units[group] ?? "1";
}

function split(key: string): [string, string] {
  const colon = key.indexOf(":");
  return colon < 0 ? [key, ""] : [key.slice(0, colon), key.slice(colon + 1)];
}
