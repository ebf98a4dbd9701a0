import assert from "node:assert/strict";
import { test } from "node:test";
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { RobotDescriptionSchema, SensorKind, type SensorDescriptionSchema } from "../src/gen/baudbot/v1/brain_link_pb";
import { WatchResponseSchema } from "../src/gen/baudbot/v1/observe_pb";
import { readChoice, writeChoice } from "../src/address";
import { DeadReckoning, counted, rolled, wheelSensor } from "../src/model/odometry";
import { composed, relative, wrapped } from "../src/model/pose";
import { agesText, messagesText } from "../src/model/quantities";
import { RobotRecord } from "../src/model/record";
import { Ring, SeriesTable } from "../src/model/ring";
import { columnsOf, partsOf } from "../src/model/sensors";
import { isDriveKey, signals, stickOfAxes, stickOfKeys } from "../src/model/stick";
import { Trail } from "../src/model/trail";
import { brief, clock, count, duration, exactMs, lengthText, roundStep, short } from "../src/model/units";
import { Motion } from "../src/model/motion";
import { Frame } from "../src/net/frames";
import { firstEvery, nextEvery } from "../src/net/rate";
import { paceOf } from "../src/net/orders";
import { lineOf } from "../src/panels/words";

const near = (a: number, b: number, slack = 1e-9) => assert.ok(Math.abs(a - b) <= slack, `${a} is not ${b}`);
const WHEELS = { wheel_radius_m: 0.05, half_track_m: 0.1, counts_per_turn: 100, wraps_at: 65536 };

test("equal counts go straight, opposite ones turn on the spot", () => {
  const start = { x_m: 1, y_m: 2, heading_rad: Math.PI / 2 };
  const on = rolled(start, WHEELS, 100, 100);
  near(on.x_m, 1);
  near(on.y_m, 2 + 2 * Math.PI * 0.05);
  const turned = rolled(start, WHEELS, -100, 100);
  near(turned.x_m, 1);
  near(turned.heading_rad, Math.PI / 2 + (2 * Math.PI * 0.05) / 0.1);
});

test("small steps on a circle come back to its start", () => {
  let pose = { x_m: 0, y_m: 0, heading_rad: 0 };
  const turn_rad = (2 * Math.PI * 0.05 * (200 - 100)) / 100 / 0.2;
  const steps = 1000;
  const share = (2 * Math.PI) / turn_rad / steps;
  for (let i = 0; i < steps; i++) pose = rolled(pose, WHEELS, 100 * share, 200 * share);
  near(pose.x_m, 0, 1e-4);
  near(pose.y_m, 0, 1e-4);
  near(wrapped(pose.heading_rad), 0, 1e-6);
});

test("a counter that wraps goes the shorter way", () => {
  assert.equal(counted(65530, 4, 65536), 10);
  assert.equal(counted(4, 65530, 65536), -10);
  assert.equal(counted(4, 65530, 0), 65526);
});

test("dead reckoning begins at the first true pose, and an odometer says its pose itself", () => {
  const encoders = new DeadReckoning({ kind: "encoders", sensor: 0, wheels: WHEELS });
  encoders.take([500, 500], { x_m: 3, y_m: 4, heading_rad: 0 });
  assert.deepEqual(encoders.pose, { x_m: 3, y_m: 4, heading_rad: 0 });
  encoders.take([600, 600], { x_m: 9, y_m: 9, heading_rad: 9 });
  near(encoders.pose?.x_m ?? NaN, 3 + 2 * Math.PI * 0.05);
  const odometer = new DeadReckoning({ kind: "odometer", sensor: 0 });
  odometer.take([1, 2, 3], { x_m: 0, y_m: 0, heading_rad: 0 });
  assert.deepEqual(odometer.pose, { x_m: 1, y_m: 2, heading_rad: 3 });
});

const WRAPS = { kind: { case: "counter" as const, value: { bits: 16 } } };
const SENSORS: MessageInitShape<typeof SensorDescriptionSchema>[] = [
  { sensor: "laser", kind: SensorKind.LASER, rangeM: 4, components: [{ unit: "m", count: 5 }] },
  {
    sensor: "wheels",
    kind: SensorKind.ENCODERS,
    countsPerTurn: 8,
    components: ["left", "right"].map((name) => ({ name, unit: "1", encoding: WRAPS })),
  },
];
const ROBOT = create(RobotDescriptionSchema, { wheelRadiusM: 0.05, halfTrackM: 0.1, sensors: SENSORS });

test("the data sheet says which sensor counts, and where its values are", () => {
  assert.deepEqual(wheelSensor(ROBOT), {
    kind: "encoders",
    sensor: 1,
    wheels: { wheel_radius_m: 0.05, half_track_m: 0.1, counts_per_turn: 8, wraps_at: 65536 },
  });
  assert.deepEqual(columnsOf(ROBOT), [
    [0, 5],
    [5, 2],
  ]);
  assert.deepEqual(
    partsOf(ROBOT.sensors[1]!).map((part) => part.name),
    ["wheels.left", "wheels.right"],
  );
  assert.deepEqual(partsOf(ROBOT.sensors[0]!)[0]?.range, [0, 4]);
});

test("poses are composed and seen from each other", () => {
  const a = { x_m: 1, y_m: 2, heading_rad: 0.7 };
  const b = { x_m: -3, y_m: 0.5, heading_rad: -2 };
  const back = composed(a, relative(a, b));
  near(back.x_m, b.x_m);
  near(back.y_m, b.y_m);
  near(back.heading_rad, b.heading_rad);
});

test("angles are wrapped into (-π, π]", () => {
  near(wrapped(3 * Math.PI), Math.PI);
  near(wrapped(-Math.PI), Math.PI);
  near(wrapped(0.5 - 4 * Math.PI), 0.5);
});

test("a ring keeps the newest values", () => {
  const ring = new Ring(3);
  for (const value of [1, 2, 3, 4, 5]) ring.push(value);
  assert.deepEqual([ring.at(0), ring.at(1), ring.at(2), ring.last()], [3, 4, 5, 5]);
  assert.ok(Number.isNaN(ring.at(3)));
  assert.ok(Number.isNaN(new Ring(3).last()));
});

test("a series that comes later has no values before, and one that stays away has gaps", () => {
  const table = new SeriesTable(4, 2);
  table.push(0, [["a", 1]]);
  table.push(1, [
    ["a", 2],
    ["b", 20],
  ]);
  table.push(2, [
    ["b", 30],
    ["c", 99],
  ]);
  const [times, a, b, c] = table.rows(["a", "b", "c"], 10).map((row) => [...row]);
  assert.deepEqual(times, [0, 1, 2]);
  assert.deepEqual(a, [1, 2, NaN]);
  assert.deepEqual(b, [NaN, 20, 30]);
  assert.deepEqual(c, [NaN, NaN, NaN], "there is no room for a third series");
});

test("a table that is full goes round", () => {
  const table = new SeriesTable(3, 1);
  for (let i = 0; i < 8; i++) table.push(i, [["a", 10 * i]]);
  assert.deepEqual(
    table.rows(["a"], 2).map((row) => [...row]),
    [
      [6, 7],
      [60, 70],
    ],
  );
  assert.equal(table.length, 3);
});

test("a trail leaves out what is hardly away, and forgets its beginning", () => {
  const trail = new Trail(3);
  for (const x of [0, 0.01, 1, 2, 3]) trail.add(x, 0, 0.1);
  assert.deepEqual([trail.length, trail.at(0), trail.at(2)], [3, [1, 0], [3, 0]]);
});

function frame(x_m: number, heading_rad: number): Frame {
  const one = (value: number) => Float64Array.of(value);
  return new Frame(
    create(WatchResponseSchema),
    { count: 1, x_m: one(x_m), y_m: one(0), heading_rad: one(heading_rad), collided: Uint8Array.of(0) },
    [],
  );
}

test("between two frames a robot is on its way, turning the shorter way", () => {
  const motion = new Motion();
  motion.take(frame(0, 3), 1000);
  motion.take(frame(1, -3), 1050);
  const half = motion.pose(0, 1050 + 25);
  assert.ok(half && half.x_m > 0.2 && half.x_m < 0.8, `${half?.x_m}`);
  assert.ok(Math.abs(wrapped(half.heading_rad - Math.PI)) < 0.15, `${half.heading_rad}`);
  assert.equal(motion.pose(0, 2000)?.x_m, 1);
  assert.ok(motion.settled(2000));
});

test("a line is found in what the server objects to", () => {
  assert.equal(lineOf("TOML parse error at line 12, column 3\nexpected `=`"), 12);
  assert.equal(lineOf("Line: 7 is odd"), 7);
  assert.equal(lineOf("robots[2].sensors.front.range_m: must be positive, is -1"), 0);
  assert.equal(lineOf("outline 5 is not closed"), 0);
});

test("what is chosen is in the address", () => {
  assert.deepEqual(readChoice(writeChoice({ world: "a b", robot: "r&d" })), { world: "a b", robot: "r&d" });
  assert.deepEqual(readChoice(""), { world: "", robot: "" });
  assert.equal(writeChoice({ world: "", robot: "x" }), "");
});

test("sticks become signals within the limit", () => {
  assert.deepEqual(signals({ forward: 1, left: 0 }, 1, 0.8), { left: 0.8, right: 0.8 });
  const { left, right } = signals({ forward: 1, left: 1 }, 1, 1);
  near(right, 1);
  assert.ok(left < right && left > 0);
  assert.deepEqual(stickOfKeys(["w", "ArrowUp", "a"]), { forward: 1, left: 1 });
  assert.deepEqual(stickOfKeys(["w", "s"]), { forward: 0, left: 0 });
  assert.deepEqual(stickOfAxes([0.05, -1]), { forward: 1, left: 0 });
  assert.ok(isDriveKey("W") && !isDriveKey("x"));
});

test("frames are asked for as often as is looked at", () => {
  assert.equal(firstEvery(paceOf("realTime"), 0.01), 4);
  assert.equal(firstEvery(paceOf("scaled", 10), 0.01), 40);
  assert.equal(firstEvery(paceOf("stepped"), 0.01), 1);
  assert.equal(nextEvery(4, paceOf("free"), { ticks_per_s: 5000, load: 0.1 }), 200);
  assert.equal(nextEvery(4, paceOf("realTime"), { ticks_per_s: 110, load: 0.1 }), 4, "it stays if it is about right");
  assert.equal(nextEvery(4, paceOf("realTime"), { ticks_per_s: 100, load: 0.8 }), 8, "less of what takes too long");
  assert.equal(nextEvery(8, paceOf("realTime"), { ticks_per_s: 100, load: 0.4 }), 8, "and it stays so");
  assert.equal(nextEvery(4, paceOf("realTime"), { ticks_per_s: 0, load: 0 }), 4);
});

test("numbers are short and have their units", () => {
  assert.deepEqual(
    [short(0), short(-0.1234), short(12.345), short(1234), short(NaN)],
    ["0.00", "−0.12", "12.3", "1234", "–"],
  );
  assert.deepEqual([duration(20_039_000), duration(112_000), duration(2.5e9)], ["20.0 ms", "112 µs", "2.50 s"]);
  assert.deepEqual([short(-2.6e-21), duration(0)], ["0.00", "0 ms"]);
  assert.deepEqual([0.005, 0.2, 5, 20_000].map(lengthText), ["5 mm", "0.2 m", "5 m", "20 km"]);
  assert.equal(exactMs(20_487_001), "20.487001");
  assert.equal(count(1234567n), "1\u202f234\u202f567");
  assert.deepEqual([clock(1.5), clock(75.25), clock(3725)], ["1.500 s", "1:15.25", "1:02:05.00"]);
  assert.deepEqual([0.3, 1, 1.1, 3, 7, 60].map(roundStep), [0.5, 1, 2, 5, 10, 100]);
});

test("the ages that are shown are those of all frames since somebody looked", () => {
  const description = create(RobotDescriptionSchema, { sensors: [{ sensor: "ir", kind: SensorKind.IR }] });
  const record = new RobotRecord(0, description, 0.1);
  const at = (tick: number, ages?: [number, number]) => {
    const [leastAgeNs, mostAgeNs] = ages?.map((ms) => BigInt(Math.round(ms * 1e6))) ?? [];
    const details = [{ robot: 0, sensors: [{ values: [0.5], leastAgeNs, mostAgeNs }] }];
    const rest = create(WatchResponseSchema, { tick: BigInt(tick), timeNs: BigInt(tick) * 10_000_000n, details });
    const poses = { count: 0, x_m: new Float64Array(), y_m: new Float64Array(), heading_rad: new Float64Array() };
    record.take(new Frame(rest, { ...poses, collided: new Uint8Array() }, []), undefined, tick === 0);
  };
  at(0);
  assert.equal(record.takeAges(0), undefined);
  at(4, [20.4, 30]);
  at(8, [25, 40.4]);
  const ages = record.takeAges(0);
  assert.deepEqual(ages, { least_ns: 20.4e6, most_ns: 40.4e6 });
  assert.equal(agesText(ages!), "20.4–40.4 ms");
  assert.equal(record.takeAges(0), undefined, "no frame has come since");
  assert.equal(record.values.get("age:ir"), 40.4);
  assert.equal(record.values.get("least-age:ir"), 25);
  assert.equal(agesText({ least_ns: 0.5e6, most_ns: 1.5e6 }), "500 µs – 1.50 ms");
  assert.equal(agesText({ least_ns: 30e6, most_ns: 30.001e6 }), "30.0 ms");
});

test("a brain that writes more often than it reads is told of", () => {
  assert.equal(messagesText(594n, 594n), "594 messages up, 594 down");
  assert.match(messagesText(590n, 1179n), /the brain wrote 2(\.0)? times as often as it read/);
  assert.equal(messagesText(3n, 9n), "3 messages up, 9 down");
});

test("what others say is cut", () => {
  assert.equal(brief("abc", 3), "abc");
  assert.equal(brief("🦀".repeat(3000), 200), `${"🦀".repeat(200)}…`);
});
