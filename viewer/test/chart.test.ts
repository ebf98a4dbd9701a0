import assert from "node:assert/strict";
import { test } from "node:test";
import { create, toBinary } from "@bufbuild/protobuf";
import { DescribeWorldResponseSchema, RobotTruthSchema, WatchResponseSchema } from "../src/gen/baudbot/v1/observe_pb";
import { WorldStatusSchema } from "../src/gen/baudbot/v1/world_pb";
import { SeriesTable } from "../src/model/ring";
import { Store } from "../src/model/store";
import { shownRange, shownSpan, ticks } from "../src/model/ticks";
import { Frame } from "../src/net/frames";

/** What a label says. */
const said = (label: string) => Number(label.replaceAll("−", "-"));

test("labels are exactly their ticks, and no two are the same", () => {
  const spans = [1e-7, 3e-4, 0.007, 0.0125, 0.25, 0.3, 1, 2.7, 15, 42, 360, 1e4, 3e6, 7e11];
  const middles = [0, 1e-5, 0.25, 0.3, -0.2987, 1, -17, 3600, 1e5, 1234567, -8e9];
  for (const span of spans)
    for (const middle of middles)
      for (const most of [2, 5, 8, 13]) {
        if (span < 1e-6 * Math.abs(middle)) continue;
        const [min, max] = [middle - span / 2, middle + span / 2];
        const { values, labels } = ticks(min, max, most);
        const what = `${min} to ${max} in ${most}: ${labels.join(" ")}`;
        assert.equal(new Set(labels).size, labels.length, what);
        assert.ok(labels.length <= most + 1 && labels.length >= Math.floor(most / 3), what);
        labels.forEach((label, i) => {
          const off = Math.abs(said(label) - values[i]!);
          assert.ok(off <= 1e-12 * Math.max(Math.abs(values[i]!), 1e-3), `${what}: ${label} is ${values[i]}`);
          assert.ok(values[i]! >= min - 1e-5 * span && values[i]! <= max + 1e-5 * span, what);
          assert.ok(label.length <= 12, what);
        });
      }
});

test("ticks are at round numbers", () => {
  assert.deepEqual(ticks(0.2944, 0.3026, 5).labels, ["0.296", "0.298", "0.300", "0.302"]);
  assert.deepEqual(ticks(-1, 1, 5).labels, ["−1.0", "−0.5", "0", "0.5", "1.0"]);
  assert.deepEqual(ticks(0, 1, 2).labels, ["0", "0.5", "1.0"]);
  assert.deepEqual(ticks(3, 18, 4).labels, ["5", "10", "15"]);
  assert.deepEqual(ticks(0, 2.4e7, 3).labels, ["0", "1e7", "2e7"]);
  assert.deepEqual(ticks(-2e-6, 2e-6, 5).labels, ["−2e−6", "−1e−6", "0", "1e−6", "2e−6"]);
});

test("values that stand still are in the middle of an axis that people can read", () => {
  assert.deepEqual(shownRange(0, 0), [-1, 1]);
  assert.deepEqual(shownRange(-3e-17, 2e-17), [-1, 1], "a zero that was computed");
  const [min, max] = shownRange(0.3, 0.3);
  assert.ok(min > 0.2 && min < 0.3 && max > 0.3 && max < 0.4, `${min} ${max}`);
  const [low, high] = shownRange(12.0, 12.0001);
  assert.ok(high - low > 0.4, "what hardly changes is not blown up");
  assert.deepEqual(shownRange(null, null), [0, 1]);
  assert.equal(shownRange(0, 400)[0], 0);
});

test("the axis of time is as long as was chosen, from the beginning on", () => {
  assert.deepEqual(shownSpan(0, 0, 15), [0, 15]);
  assert.deepEqual(shownSpan(0, 4, 15), [0, 15]);
  assert.deepEqual(shownSpan(0, 40, 15), [25, 40]);
  assert.deepEqual(shownSpan(10, 40, 0), [10, 40]);
  assert.deepEqual(shownSpan(0, 0, 0), [0, 1]);
});

/** A store that looks at a robot whose speed is the tick. */
function looking(stride: number) {
  const store = new Store();
  store.chooseWorld("w", "robot");
  store.setStride(stride);
  const robots = [{ robot: "robot", description: { sensors: [] } }];
  store.describe(create(DescribeWorldResponseSchema, { stepNs: 10_000_000n, robots }));
  const see = (tick: number, first = false) => {
    const truth = toBinary(RobotTruthSchema, create(RobotTruthSchema, { speedMS: tick }));
    const one = () => Float64Array.of(0);
    const poses = { count: 1, x_m: one(), y_m: one(), heading_rad: one(), collided: Uint8Array.of(0) };
    const rest = create(WatchResponseSchema, { tick: BigInt(tick), timeNs: BigInt(tick) * 10_000_000n });
    store.take(new Frame(rest, poses, [truth]), first);
  };
  const speeds = () => [...(store.record?.series.rows(["speed"], 100)[1] ?? [])];
  return { store, see, speeds };
}

test("where frames were missed there is a gap, and where none were there is none", () => {
  const { see, speeds } = looking(4);
  see(2, true);
  for (const tick of [4, 8, 12, 24, 28]) see(tick);
  assert.deepEqual(speeds(), [2, 4, 8, 12, NaN, 24, 28]);
});

test("frames that are asked for more seldom, or more often, are not missed", () => {
  const { store, see, speeds } = looking(4);
  for (const tick of [4, 8]) see(tick);
  store.setStride(20);
  see(10, true);
  for (const tick of [20, 40]) see(tick);
  store.setStride(4);
  see(53, true);
  see(56);
  see(60);
  assert.deepEqual(speeds(), [4, 8, 10, 20, 40, 53, 56, 60]);
  see(72);
  assert.deepEqual(speeds().slice(-2), [NaN, 72]);
});

/** A replay that was looked at from tick 0 to 40, and taken back to 20. */
function takenBack() {
  const { store, see, speeds } = looking(4);
  store.setWorlds([create(WorldStatusSchema, { world: "w", replay: { lastTick: 1000n } })]);
  for (let tick = 0; tick <= 40; tick += 4) see(tick);
  see(20, true);
  return { store, see, speeds };
}

test("time that a replay leaps over is a gap", () => {
  const { see, speeds } = looking(4);
  for (const tick of [4, 8, 12, 400, 404]) see(tick);
  assert.deepEqual(speeds(), [4, 8, 12, NaN, 400, 404]);
});

test("what comes again in a replay is known, and is shown when its time has come", () => {
  const { see, speeds } = takenBack();
  assert.deepEqual(speeds(), [0, 4, 8, 12, 16, 20]);
  see(30, true);
  assert.deepEqual(speeds(), [0, 4, 8, 12, 16, 20, 24, 28, 30]);
  see(90, true);
  assert.deepEqual(speeds(), [0, 4, 8, 12, 16, 20, 24, 28, 30, 32, 36, 40, NaN, 90]);
  see(2, true);
  assert.deepEqual(speeds(), [0, 2]);
  see(200, true);
  assert.deepEqual(speeds().slice(-5), [40, NaN, 90, NaN, 200]);
});

test("a replay that goes on as a live world forgets what would have come", () => {
  const { store, see, speeds } = takenBack();
  store.setWorlds([create(WorldStatusSchema, { world: "w" })]);
  for (const tick of [24, 28, 32]) see(tick);
  assert.deepEqual(speeds(), [0, 4, 8, 12, 16, 20, 24, 28, 32]);
  see(44);
  assert.deepEqual(speeds().slice(-3), [32, NaN, 44]);
});

test("what is kept of the time to come is bounded", () => {
  const table = new SeriesTable(8, 1);
  for (let round = 0; round < 5; round++) {
    for (let i = 0; i < 8; i++) table.push(100 - 10 * round + i, [["a", i]]);
    table.cut(0, true);
  }
  table.push(1000, [["a", 9]]);
  assert.equal(table.length, 8);
  assert.deepEqual([...table.rows(["a"], 8)[1]!], [1, 2, 3, 4, 5, 6, 7, 9]);
});
