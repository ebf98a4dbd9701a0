import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { RobotDescriptionSchema } from "../src/gen/baudbot/v1/brain_link_pb";
import { TimelineKind as K } from "../src/gen/baudbot/v1/observe_pb";
import { LIGHT } from "../src/arena/palette";
import { Timeline, type Happening } from "../src/model/timeline";
import { lastCycle } from "../src/timing/cycle";
import { draw, heightOf } from "../src/timing/draw";
import { lanes, what, windowFor } from "../src/timing/layout";

const us = (from: number, until: number, kind: K, bytes = 0, part?: number): Happening => ({
  start_ns: from * 1000,
  end_ns: until * 1000,
  kind,
  bytes,
  part,
});
const ROBOT = create(RobotDescriptionSchema, { sensors: [{ sensor: "left" }, { sensor: "right" }] });

/** A cycle as in `wander`, in the order in which its events become known. */
function cycle(start_us: number): Happening[] {
  const at = (from: number, until: number, kind: K, bytes = 0, part?: number) =>
    us(start_us + from, start_us + until, kind, bytes, part);
  return [
    at(0, 112, K.ACQUIRE, 0, 0),
    at(112, 224, K.ACQUIRE, 0, 1),
    at(600, 695, K.FRAME, 19),
    at(695, 20_487, K.UP, 19),
    at(20_487, 20_487, K.THINK, 0, 1),
    at(20_487, 28_785, K.DOWN, 8),
    at(21_528, 28_805, K.OBEY),
    at(29_000, 29_000, K.ACT),
  ];
}

test("the last cycle that was answered is followed from its reads to its act", () => {
  const all = [...cycle(0), ...cycle(40_000), us(80_000, 80_112, K.ACQUIRE, 0, 0), us(80_600, 80_695, K.FRAME, 19)];
  const found = lastCycle(all);
  assert.ok(found);
  // It begins with its message, less what the reads took.
  assert.equal(found.begun_ns, (40_600 - 224) * 1000);
  assert.equal(found.obeyed_ns, 68_805_000);
  assert.equal(found.end_ns, 69_000_000);
  assert.equal(found.events.size, 8);
});

test("messages that queue for the wire keep their order", () => {
  const frames = [0, 2, 4].map((at) => us(at, at + 1, K.FRAME, 9));
  const ups = [1, 10, 20].map((at) => us(at, at + 9, K.UP, 9));
  const answers = [us(29, 29, K.THINK, 0, 1), us(29, 35, K.DOWN, 8), us(30, 36, K.OBEY)];
  const found = lastCycle([...frames, ...ups, ...answers]);
  assert.ok(found?.events.has(ups[2]!) && !found.events.has(ups[1]!));
});

test("what nobody answered is no cycle", () => {
  assert.equal(lastCycle(cycle(0).filter((event) => event.kind !== K.THINK)), undefined);
  assert.equal(lastCycle([]), undefined);
});

test("what a later step wrote does not answer a message that the brain left unanswered", () => {
  const silent = cycle(0).filter((event) => event.kind !== K.DOWN && event.kind !== K.OBEY && event.kind !== K.ACT);
  assert.equal(lastCycle([...silent, us(60_000, 68_000, K.DOWN, 8), us(60_500, 68_100, K.OBEY)]), undefined);
  const late = us(30_000, 45_000, K.THINK, 0, 1);
  const answer = [us(45_000, 53_000, K.DOWN, 8), us(46_000, 53_100, K.OBEY)];
  const found = lastCycle([...silent.filter((event) => event.kind !== K.THINK), late, ...answer]);
  assert.ok(found?.events.has(late) && found?.events.has(answer[0]!));
  assert.equal(found?.obeyed_ns, 53_100_000);
});

test("lanes go from the sensors to the motors, and other cycles are pale", () => {
  const all = [...cycle(0), ...cycle(20_000), us(30_000, 30_000, K.LATE)];
  const found = lastCycle(all);
  const made = lanes(ROBOT, all, { from_ns: 0, until_ns: 60_000_000 }, found);
  assert.deepEqual(
    made.map((lane) => lane.label),
    ["left", "right", "framing", "cable up", "thinking", "cable down", "obeying", "actuation", "trouble"],
  );
  const up = made.find((lane) => lane.label === "cable up");
  assert.deepEqual(
    up?.bars.map((bar) => [bar.pale, bar.label, bar.row]),
    [
      [true, "19 bytes", 0],
      [false, "19 bytes", 0],
    ],
  );
  assert.equal(made.at(-1)?.bars[0]?.pale, false, "trouble is never pale");
  assert.deepEqual(lanes(ROBOT, all, { from_ns: 0, until_ns: 60_000_000 }, found, 1)[0]?.label, "acquisition");
});

test("what overlaps is in rows below each other, and rows are few", () => {
  const downs = Array.from({ length: 9 }, (_, i) => us(i, 1000, K.DOWN, 8));
  const lane = lanes(ROBOT, downs, { from_ns: 0, until_ns: 1e7 }, undefined).find(
    (lane) => lane.label === "cable down",
  );
  assert.equal(lane?.rows, 4);
  assert.equal(lane?.bars.length, 9);
});

test("the window is as long as the cycle, or as people want it", () => {
  const found = lastCycle(cycle(0));
  const auto = windowFor(found, 40e6, 10e6, 0);
  assert.ok(auto.from_ns < found!.begun_ns && auto.until_ns > found!.end_ns);
  const one = windowFor(found, 40e6, 10e6, 1);
  assert.ok(one.until_ns - one.from_ns < 12e6);
  assert.deepEqual(windowFor(undefined, 41e6, 10e6, 3), { from_ns: 20e6, until_ns: 50e6 });
});

test("an event is told in words", () => {
  assert.equal(what(ROBOT, us(0, 1, K.ACQUIRE, 0, 1)), "right: a sensor is read");
  assert.equal(what(ROBOT, us(0, 1, K.UP, 19)), "readings on the wire, 19 bytes");
  assert.equal(what(ROBOT, us(0, 1, K.THINK, 0, 0)), "the brain thinks, without news");
});

test("a timeline is bounded, and a new Watch does not repeat it", () => {
  const timeline = new Timeline();
  const event = { startNs: 1n, endNs: 2n, kind: K.UP, part: undefined, bytes: 1 } as never;
  for (let i = 0; i < 100; i++) timeline.take(Array(200).fill(event), false);
  assert.ok(timeline.happenings.length <= 6000, `${timeline.happenings.length}`);
  timeline.take([event], true);
  assert.equal(timeline.happenings.length, 1);
});

/** A canvas that only notes what is written and which diamonds are drawn; a character is six pixels wide. */
function paper() {
  const texts: { text: string; left: number; right: number; y: number }[] = [];
  const marks: { x: number; y: number }[] = [];
  const state: Record<string, unknown> = { textAlign: "left" };
  let path: [number, number][] = [];
  const draw = {
    measureText: (text: string) => ({ width: 6 * text.length }),
    fillText(text: string, x: number, y: number) {
      const width = 6 * text.length;
      const left = state.textAlign === "center" ? x - width / 2 : state.textAlign === "right" ? x - width : x;
      texts.push({ text, left, right: left + width, y });
    },
    beginPath: () => (path = []),
    moveTo: (x: number, y: number) => path.push([x, y]),
    lineTo: (x: number, y: number) => path.push([x, y]),
    closePath: () => marks.push({ x: path[0]![0], y: path[1]![1] }),
  } as Record<string, unknown>;
  const context = new Proxy(draw, {
    get: (_, name: string) => draw[name] ?? state[name] ?? (() => {}),
    set: (_, name: string, value) => ((state[name] = value), true),
  });
  return { context: context as unknown as CanvasRenderingContext2D, texts, marks };
}

/** As at 2400 baud: a brain that is asked in vain again and again, and sensors that are left out together. */
function slow(): Happening[] {
  const idle = Array.from({ length: 40 }, (_, i) => us(9_000 * i, 9_000 * i, K.THINK, 0, 0));
  const missed = Array.from({ length: 25 }, (_, i) => {
    const at = 80_000 * Math.floor(i / 5) + 112 * (i % 5);
    return us(at, at, K.MISSED, 0, i % 2);
  });
  return [...idle, ...missed, us(300_000, 300_000, K.LATE), ...cycle(100_000)].sort((a, b) => a.start_ns - b.start_ns);
}

function drawn(width: number, until_ms: number) {
  const { context, texts, marks } = paper();
  const all = slow();
  const window = { from_ns: 0, until_ns: until_ms * 1e6 };
  const found = lastCycle(all);
  const shown = lanes(ROBOT, all, window, found);
  const row = 14;
  const height = heightOf(shown, row);
  const [step_ns, deadline_ns] = [10e6, 10e6];
  draw({ context, width, height, theme: LIGHT, window, lanes: shown, cycle: found, step_ns, deadline_ns, row });
  return { texts, marks };
}

test("no label is written over another one, nor over a mark", () => {
  for (const width of [360, 480, 590, 980, 1400])
    for (const until_ms of [40, 90, 200, 400]) {
      const { texts, marks } = drawn(width, until_ms);
      const what = `${width} pixels, ${until_ms} ms`;
      for (const [i, a] of texts.entries())
        for (const b of texts.slice(i + 1)) {
          if (Math.abs(a.y - b.y) > 8) continue;
          assert.ok(a.right <= b.left || b.right <= a.left, `${what}: ${JSON.stringify([a, b])}`);
        }
      for (const { text, left, right, y } of texts)
        for (const mark of marks) {
          if (Math.abs(mark.y - (y - 4)) > 3) continue;
          assert.ok(mark.x + 4 <= left || mark.x - 4 >= right, `${what}: ${text} at ${left} over a mark at ${mark.x}`);
        }
    }
});

test("sensors that are left out together are told together", () => {
  const { texts } = drawn(980, 200);
  assert.equal(texts.filter(({ text }) => text === "5 × skipped").length, 3);
  assert.equal(texts.filter(({ text }) => text === "skipped").length, 0);
});

test("the names of lanes are whole where there is room", () => {
  for (const width of [360, 980]) {
    const { texts } = drawn(width, 200);
    for (const name of ["cable down", "actuation"])
      assert.ok(
        texts.some(({ text }) => text === name),
        `${width}: ${texts.map(({ text }) => text).join(", ")}`,
      );
  }
});

test("a cycle of half a second is shown whole", () => {
  const long = [
    us(0, 112, K.ACQUIRE, 0, 0),
    us(600, 695, K.FRAME, 19),
    us(695, 400_000, K.UP, 19),
    us(400_000, 400_000, K.THINK, 0, 1),
    us(400_000, 480_000, K.DOWN, 8),
    us(470_000, 481_000, K.OBEY),
  ];
  const found = lastCycle(long);
  const { until_ns } = windowFor(found, 500e6, 10e6, 0);
  assert.ok(found && until_ns > found.end_ns, `${until_ns}`);
});
