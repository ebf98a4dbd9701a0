import assert from "node:assert/strict";
import { test, type TestContext } from "node:test";
import { create, toBinary } from "@bufbuild/protobuf";
import { DescribeWorldResponseSchema, WatchResponseSchema } from "../src/gen/baudbot/v1/observe_pb";
import { fillRuns } from "../src/model/coverage";
import { Store } from "../src/model/store";
import { Connection, type Socket } from "../src/net/connection";
import { decodeFrame } from "../src/net/frames";
import { Surveyor } from "../src/net/surveyor";
import { MockFloor } from "./mock_floor";
import { requestFrom, responseTo, type Reply } from "./calls";
import { MockWorld } from "./mock_world";

const filled = (runs: number[], cells = 8) => {
  const all = new Uint32Array(cells);
  fillRuns(all, runs, 7);
  return [...all];
};

test("runs are cells that are not in a set and cells that are, in turn", () => {
  assert.deepEqual(filled([2, 3, 1, 2]), [0, 0, 7, 7, 7, 0, 7, 7]);
  assert.deepEqual(filled([0, 1, 7]), [7, 0, 0, 0, 0, 0, 0, 0]);
  assert.deepEqual(filled([0, 8]), Array(8).fill(7));
  assert.deepEqual(filled([8]), Array(8).fill(0));
  assert.deepEqual(filled([]), Array(8).fill(0), "what is not counted is an empty list");
  assert.deepEqual(filled([6, 4_000_000_000, 1, 1]), [0, 0, 0, 0, 0, 0, 7, 7], "nothing is beyond the end");
});

test("the later of two sets lies over the other", () => {
  const cells = new Uint32Array(4);
  fillRuns(cells, [0, 3, 1], 1);
  fillRuns(cells, [1, 1, 2], 2);
  assert.deepEqual([...cells], [1, 2, 1, 0]);
});

test("the mock tells its cells as runs", () => {
  const floor = new MockFloor();
  floor.mark(floor.covered, -2.95, -1.95, 0.06);
  floor.mark(floor.covered, 2.95, 1.95, 0.06);
  assert.deepEqual(floor.map(5n).covered, [0, 1, 60 * 40 - 2, 1]);
  assert.deepEqual(floor.map(5n).sensed, [60 * 40]);
});

/** A page before a made-up world, whose timers and clock go on by `pass` only. */
function surveying(t: TestContext, { counts = true, isShown = (): boolean => true } = {}) {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  let now_ms = 0;
  t.mock.method(performance, "now", () => now_ms);
  const pass = (ms: number) => {
    now_ms += ms;
    t.mock.timers.tick(ms);
  };
  const sent: Uint8Array[] = [];
  const socket = { send: (bytes: Uint8Array) => sent.push(bytes) } as unknown as Socket;
  const connection = new Connection(() => socket);
  connection.open();
  socket.onopen?.(undefined as never);
  const store = new Store();
  store.chooseWorld("w");
  store.describe(create(DescribeWorldResponseSchema, new MockWorld("w", 3).description));
  const surveyor = new Surveyor(connection, store, isShown);
  const world = new MockWorld("w", 3, counts);
  const respond = async (call: number, reply: Reply) => {
    socket.onmessage?.({ data: responseTo(call, reply).slice().buffer } as MessageEvent);
    // What awaits the answer goes on.
    await new Promise((resolve) => setImmediate(resolve));
  };
  const frame = (ticks: number) => {
    for (let i = 0; i < ticks; i++) world.step();
    store.take(decodeFrame(toBinary(WatchResponseSchema, world.frame([], 0n))), false);
  };
  const answer = () => {
    const { call, request } = requestFrom(sent.at(-1) ?? new Uint8Array());
    assert.equal(request.case, "getCoverage");
    return respond(call, { case: "getCoverage", value: world.floor.map(world.tick) });
  };
  const fail = () => {
    const { call } = requestFrom(sent.at(-1) ?? new Uint8Array());
    return respond(call, { case: "failure", value: { code: "INTERNAL", message: "no" } });
  };
  return { sent, store, surveyor, world, frame, answer, fail, pass };
}

test("the map is asked for once a second, with one request under way", async (t) => {
  const { sent, store, frame, answer, pass } = surveying(t);
  frame(1);
  pass(0);
  assert.equal(sent.length, 1);
  for (let i = 0; i < 50; i++) {
    frame(1);
    pass(100);
  }
  assert.equal(sent.length, 1, "nobody has answered");
  await answer();
  assert.equal(store.coverage?.tick, 51n);
  frame(1);
  pass(500);
  assert.equal(sent.length, 1, "it is not time yet");
  frame(1);
  pass(500);
  assert.equal(sent.length, 2);
});

test("a world that stands is asked once, and again when it is elsewhere", async (t) => {
  const { sent, frame, answer, pass, world } = surveying(t);
  frame(10);
  pass(0);
  await answer();
  frame(0);
  pass(5000);
  assert.equal(sent.length, 1, "nothing can have changed");
  world.reset();
  frame(3);
  pass(200);
  assert.equal(sent.length, 2, "what is shown is not of this run: it does not take a second");
});

test("a map that failed is asked for again", async (t) => {
  const { sent, frame, fail, pass } = surveying(t);
  frame(1);
  pass(0);
  await fail();
  assert.equal(sent.length, 1);
  pass(1000);
  assert.equal(sent.length, 2);
});

test("nobody asks for what is not counted, or not shown", async (t) => {
  const none = surveying(t, { counts: false });
  none.frame(1);
  none.pass(5000);
  assert.equal(none.sent.length, 0);
  t.mock.timers.reset();
  let isShown = false;
  const hidden = surveying(t, { isShown: () => isShown });
  hidden.frame(1);
  hidden.pass(5000);
  assert.equal(hidden.sent.length, 0);
  isShown = true;
  hidden.surveyor.look();
  hidden.pass(0);
  assert.equal(hidden.sent.length, 1);
});

test("who makes a film gets the map of each picture, and nobody else asks meanwhile", async (t) => {
  const { sent, store, surveyor, frame, answer, pass } = surveying(t);
  store.filmStride = 1;
  frame(1);
  pass(5000);
  assert.equal(sent.length, 0);
  const first = surveyor.survey();
  const second = surveyor.survey();
  assert.equal(sent.length, 1);
  await answer();
  await first;
  assert.equal(sent.length, 2, "what was under way may have been of the tick before");
  frame(5);
  await answer();
  await second;
  assert.equal(store.coverage?.tick, 6n);
});

test("a map of a world that nobody looks at any more is not shown", async (t) => {
  const { store, frame, answer, pass } = surveying(t);
  frame(1);
  pass(0);
  store.chooseWorld("other");
  await answer();
  assert.equal(store.coverage, undefined);
});
