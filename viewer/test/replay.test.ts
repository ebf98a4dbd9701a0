import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { RobotDescriptionSchema } from "../src/gen/baudbot/v1/brain_link_pb";
import { ReplayEventKind as Kind, ReplayEventSchema } from "../src/gen/baudbot/v1/control_pb";
import { DescribeWorldResponseSchema, TimelineKind, type TimelineEvent } from "../src/gen/baudbot/v1/observe_pb";
import { WatchResponseSchema } from "../src/gen/baudbot/v1/observe_pb";
import { WorldStatusSchema } from "../src/gen/baudbot/v1/world_pb";
import { isLit } from "../src/arena/lamps";
import { eventFrom, markAt, marksOf, within, wordsAt } from "../src/model/replay";
import { Ring, SeriesTable } from "../src/model/ring";
import { RobotRecord } from "../src/model/record";
import { Store } from "../src/model/store";
import { Timeline } from "../src/model/timeline";
import { Trail } from "../src/model/trail";
import { bytesText } from "../src/model/units";
import { decodeFrame, type Frame } from "../src/net/frames";
import { SeekQueue } from "../src/net/seek";
import { isMcap } from "../src/panels/words";
import { toBinary } from "@bufbuild/protobuf";
import { MockWorld } from "./mock_world";

const event = (tick: bigint, text = "", kind = Kind.COLLISION) => create(ReplayEventSchema, { tick, text, kind });
const EVENTS = [event(0n, "a"), event(50n, "b"), event(50n, "c"), event(90n, "d", Kind.ENDING)];

test("one seek is under way, and of the wishes behind it the newest wins", async () => {
  const asked: bigint[] = [];
  const answers: (() => void)[] = [];
  const queue = new SeekQueue((tick) => {
    asked.push(tick);
    return new Promise((resolve) => answers.push(resolve));
  });
  const done = [1n, 2n, 3n, 4n].map((tick) => queue.want(tick));
  assert.deepEqual([asked, queue.wished], [[1n], 4n]);
  answers[0]?.();
  await new Promise((resolve) => setTimeout(resolve));
  assert.deepEqual(asked, [1n, 4n]);
  answers[1]?.();
  await Promise.all(done);
  assert.equal(queue.wished, undefined);
});

test("a seek that fails is told, and the next one is tried", async () => {
  const asked: bigint[] = [];
  const errors: unknown[] = [];
  const queue = new SeekQueue(
    async (tick) => {
      asked.push(tick);
      if (tick === 1n) throw new Error("no");
    },
    (error) => errors.push(error),
  );
  await Promise.all([queue.want(1n), queue.want(2n), queue.want(3n)]);
  assert.deepEqual([asked, errors.length, queue.wished], [[1n, 3n], 1, undefined]);
});

test("nothing is asked for any more once it is dropped", async () => {
  let answer = () => {};
  const asked: bigint[] = [];
  const queue = new SeekQueue((tick) => {
    asked.push(tick);
    return new Promise((resolve) => (answer = resolve));
  });
  const done = queue.want(1n);
  void queue.want(2n);
  queue.drop();
  answer();
  await done;
  assert.deepEqual(asked, [1n]);
});

test("events are gone through in both directions, those of a tick together", () => {
  assert.equal(eventFrom(EVENTS, 0n, 1)?.text, "b");
  assert.equal(eventFrom(EVENTS, 50n, 1)?.text, "d");
  assert.equal(eventFrom(EVENTS, 90n, 1), undefined);
  assert.equal(eventFrom(EVENTS, 50n, -1)?.text, "a");
  assert.equal(eventFrom(EVENTS, 49n, -1)?.text, "a");
  assert.equal(eventFrom(EVENTS, 0n, -1), undefined);
  assert.equal(wordsAt(EVENTS, 50n), "b; c");
  assert.equal(wordsAt(EVENTS, 51n), "");
  assert.deepEqual(
    [5n, 50n, 500n].map((tick) => within(tick, { first: 10n, last: 90n })),
    [10n, 50n, 90n],
  );
});

test("marks stand where their ticks are, and a crowd of them is few", () => {
  const marks = marksOf(EVENTS, { first: 0n, last: 100n }, 8, 200);
  assert.deepEqual(
    marks.map(({ x, event }) => [x, event.text]),
    [
      [8, "a"],
      [108, "b"],
      [188, "d"],
    ],
  );
  assert.equal(markAt(marks, 112, 9)?.event.text, "b");
  assert.equal(markAt(marks, 130, 9), undefined);
  const crowd = Array.from({ length: 10_000 }, (_, i) => event(BigInt(i)));
  assert.ok(marksOf(crowd, { first: 0n, last: 10_000n }, 0, 400).length <= 201);
});

test("a ring and a table are cut where the world went back to", () => {
  const ring = new Ring(3);
  for (const value of [1, 2, 3, 4]) ring.push(value);
  ring.drop(2);
  assert.deepEqual([ring.length, ring.last()], [1, 2]);
  ring.push(9);
  assert.deepEqual([ring.at(0), ring.at(1)], [2, 9]);
  ring.drop(9);
  assert.equal(ring.length, 0);
  const table = new SeriesTable(3, 1);
  for (let i = 0; i < 5; i++) table.push(i, [["a", 10 * i]]);
  table.cut(3);
  table.push(3, [["a", 99]]);
  assert.deepEqual(
    table.rows(["a"], 9).map((row) => [...row]),
    [
      [2, 3],
      [20, 99],
    ],
  );
});

test("a trail is cut, also where the robot stood, and goes over no leap", () => {
  const trail = new Trail(8);
  for (const [tick, x] of [
    [0, 0],
    [10, 1],
    [20, 1],
    [30, 1],
    [40, 2],
  ] as const)
    trail.add(x, 0, 0.1, tick, 15);
  trail.cut(25);
  assert.deepEqual([trail.length, trail.at(1)], [2, [1, 0]]);
  trail.add(1.5, 0, 0.1, 35, 15);
  assert.equal(trail.isJump(2), false, "it stood there until tick 25");
  trail.add(9, 9, 0.1, 90, 15);
  assert.deepEqual([trail.isJump(3), trail.isJump(1)], [true, false]);
  trail.cut(-1);
  assert.equal(trail.length, 0);
});

test("bars that begin later go, and what is told again is there once", () => {
  const timeline = new Timeline();
  const bar = (start: bigint, end: bigint) =>
    ({ startNs: start, endNs: end, kind: TimelineKind.UP, bytes: 9 }) as TimelineEvent;
  timeline.take([bar(0n, 10n), bar(10n, 30n), bar(30n, 40n)], true);
  timeline.cut(20);
  assert.equal(timeline.happenings.length, 2);
  timeline.take([bar(10n, 30n), bar(25n, 35n)], false);
  assert.deepEqual(
    timeline.happenings.map(({ start_ns }) => start_ns),
    [0, 10, 25],
  );
});

function frameOf(world: MockWorld): Frame {
  const value = create(WatchResponseSchema, world.frame([0], world.tick > 20n ? world.tick - 20n : 0n));
  return decodeFrame(toBinary(WatchResponseSchema, value));
}

/** A store that looks at the made-up world, and what takes it to a tick. */
function looking(isReplay: boolean): { store: Store; to: (tick: bigint) => void } {
  const store = new Store();
  const world = new MockWorld("w", 3);
  const replay = isReplay ? { firstTick: 0n, lastTick: 1000n } : undefined;
  store.setWorlds([create(WorldStatusSchema, { world: "w", stepNs: 10_000_000n, replay })]);
  store.chooseWorld("w", "alice");
  store.describe(create(DescribeWorldResponseSchema, world.description));
  store.stride = 5;
  const to = (tick: bigint) => {
    if (tick < world.tick) world.reset();
    while (world.tick < tick) world.step();
    store.take(frameOf(world), false);
  };
  return { store, to };
}

test("a replay that goes back keeps what was before, and forgets what was later", () => {
  const { store, to } = looking(true);
  for (let tick = 5n; tick <= 400n; tick += 5n) to(tick);
  const { record } = store;
  const [long, rows] = [store.trails.all[0]?.length ?? 0, record?.series.length ?? 0];
  to(200n);
  assert.equal(store.record, record, "panels hold on to it");
  const trail = store.trails.all[0];
  assert.ok(trail && trail.length > 3 && trail.length < long);
  assert.equal(record?.series.length, rows / 2);
  assert.ok(record?.timeline.happenings.every(({ start_ns }) => start_ns <= 2e9));
  assert.ok((record?.ghostTrail.length ?? 0) > 1, "dead reckoning goes on from where it was");
  assert.ok(store.motion.settled(performance.now()), "it does not glide there");
  to(205n);
  assert.ok([...Array(trail.length).keys()].every((i) => !trail.isJump(i)));
});

test("no line goes over a leap forwards, and dead reckoning starts over", () => {
  const { store, to } = looking(true);
  for (let tick = 5n; tick <= 100n; tick += 5n) to(tick);
  to(600n);
  const trail = store.trails.all[0];
  assert.equal(trail?.isJump(trail.length - 1), true);
  const [ghost, pose] = [store.record?.ghost?.pose, store.frame?.poses];
  assert.ok(ghost && pose && Math.hypot(ghost.x_m - (pose.x_m[0] ?? 0), ghost.y_m - (pose.y_m[0] ?? 0)) < 0.05);
});

test("a live world that was reset starts over", () => {
  const { store, to } = looking(false);
  for (let tick = 5n; tick <= 300n; tick += 5n) to(tick);
  const { record } = store;
  to(5n);
  assert.equal(store.record, record);
  assert.deepEqual([store.trails.all[0]?.length, record?.series.length, record?.ghostTrail.length], [1, 1, 0]);
});

test("a record without wheel sensors is cut, too", () => {
  const record = new RobotRecord(0, create(RobotDescriptionSchema, {}), 0.1);
  const world = new MockWorld("w", 3);
  for (let i = 0; i < 30; i++) {
    world.step();
    record.take(frameOf(world), undefined, false);
  }
  record.cut(10, 1e8);
  assert.equal(record.series.length, 9);
});

test("a lamp that blinks is lit from the start of its period on", () => {
  const lamp = { periodNs: 100n, litNs: 30n } as Parameters<typeof isLit>[0];
  assert.deepEqual(
    [0n, 29n, 30n, 99n, 100n].map((at) => isLit(lamp, at)),
    [true, true, false, false, true],
  );
  assert.ok(isLit({} as Parameters<typeof isLit>[0], 7n));
});

test("files are told by their first bytes, and their lengths are short", () => {
  assert.ok(isMcap(Uint8Array.of(0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a, 1)));
  assert.ok(!isMcap(new TextEncoder().encode('name = "x"')));
  assert.deepEqual([999, 12_345, 1_234_567, 5e9].map(bytesText), ["999 B", "12.3 kB", "1.23 MB", "5.00 GB"]);
});
