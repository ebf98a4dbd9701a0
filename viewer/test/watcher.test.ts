import assert from "node:assert/strict";
import { test } from "node:test";
import { setImmediate as others } from "node:timers/promises";
import { Store } from "../src/model/store";
import { Watcher } from "../src/net/watcher";
import { connected } from "./fake_socket";
import { MockWorld } from "./mock_world";

test("a world that was reset is described again, and drawn anew only if its description has changed", async (t) => {
  t.mock.timers.enable({ apis: ["setInterval", "setTimeout"] });
  const { connection, socket } = connected();
  const store = new Store();
  store.world = "w";
  const watcher = new Watcher(connection, store);
  let drawn = 0;
  store.on("world", () => drawn++);
  const calls = (kind: string) => socket.requests().filter(({ request }) => request.case === kind);
  const describe = async (scenario: string) => {
    const value = { scenario, stepNs: 10_000_000n };
    socket.hear(calls("describeWorld").at(-1)!.call, { case: "describeWorld", value });
    await others();
  };
  const world = new MockWorld("w", 1);
  const frame = (tick: bigint) => {
    const value = { ...world.frame([], 0n), tick, timeNs: tick * 10_000_000n };
    socket.hear(calls("watch").at(-1)!.call, { case: "watch", value });
  };
  const counts = () => [calls("describeWorld").length, drawn];

  void watcher.begin();
  await describe("as it was made");
  frame(5n);
  frame(6n);
  assert.deepEqual(counts(), [1, 1]);
  frame(0n);
  assert.deepEqual(counts(), [2, 1], "it is asked at once");
  await describe("as it was made");
  assert.deepEqual(counts(), [2, 1], "nothing has changed");

  // A trainer resets it again and again.
  for (const tick of [3n, 0n, 2n, 1n]) frame(tick);
  assert.deepEqual(counts(), [2, 1], "not yet");
  t.mock.timers.tick(1000);
  await others();
  assert.deepEqual(counts(), [3, 1], "once for all of them");
  const watches = calls("watch").length;
  await describe("with other walls");
  assert.deepEqual([counts(), store.description?.scenario], [[3, 2], "with other walls"]);
  assert.equal(calls("watch").length, watches + 1, "frames of what is drawn anew");

  // An answer about a world that nobody looks at any more changes nothing.
  t.mock.timers.tick(1000);
  await others();
  frame(4n);
  frame(0n);
  store.chooseWorld("another");
  await describe("too late");
  assert.equal(store.description, undefined);
});
