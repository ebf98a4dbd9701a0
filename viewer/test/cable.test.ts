import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { CableDirection, WatchCableResponseSchema, type WatchCableResponse } from "../src/gen/baudbot/v1/observe_pb";
import { CableLog, hexOf, instantOf, MOST_ROWS } from "../src/model/cable_log";
import { CableWatch } from "../src/net/cable_watch";
import { connected } from "./fake_socket";

const QUESTION = { direction: CableDirection.DOWN, fromNs: 1_000_000n, toNs: 2_041_667n, text: "N: ask proximity" };

const response = (count: number, more: Partial<{ missedItems: bigint; restarted: boolean }> = {}) =>
  create(WatchCableResponseSchema, {
    items: Array.from({ length: count }, () => ({
      ...QUESTION,
      data: Uint8Array.of(0x4e, 0x0d),
      size: 2,
      understood: true,
    })),
    ...more,
  });

test("a row has its instant, its way, its bytes and what they mean", () => {
  const log = new CableLog();
  log.take(response(1));
  const row = log.rows[0];
  assert.ok(row);
  assert.deepEqual([instantOf(row), row.isDown, row.hex, row.text], ["2.042", true, "4e 0d", "N: ask proximity"]);
  assert.equal(row.age_ns, undefined);
  assert.equal(hexOf(new Uint8Array(4096), 9000), `${Array(48).fill("00").join(" ")} + 8952`);
});

test("the newest rows are kept, and what was missed is told", () => {
  const log = new CableLog();
  for (let i = 0; i < 8; i++) log.take(response(100, { missedItems: 7n }));
  assert.deepEqual([log.rows.length, log.rows.at(-1)?.number, log.missed], [MOST_ROWS, 800, 7]);
  log.clear();
  assert.deepEqual([log.rows.length, log.missed], [0, 7]);
});

test("a list that stands still counts what passes by", () => {
  const log = new CableLog();
  log.take(response(2));
  log.setPaused(true);
  log.take(response(3));
  assert.deepEqual([log.rows.length, log.passed], [2, 3]);
  log.setPaused(false);
  log.take(response(1));
  assert.deepEqual([log.rows.length, log.passed], [3, 0]);
});

test("what was before a reset is no past of what comes", () => {
  const log = new CableLog();
  log.take(response(2));
  log.take(response(1, { restarted: true }));
  assert.equal(log.rows.length, 1);
});

test("a cable is watched only while somebody looks, and again when the connection is back", () => {
  const { connection, socket } = connected();
  const heard: WatchCableResponse[] = [];
  const watch = new CableWatch(
    connection,
    (news) => heard.push(news),
    () => {},
  );
  assert.equal(socket.sent.length, 0);
  watch.open({ world: "w", robot: "k", sensor: "" });
  const [asked] = socket.requests();
  assert.ok(asked?.request.case === "watchCable");
  assert.deepEqual([asked.request.value.world, asked.request.value.robot, asked.request.value.sensor], ["w", "k", ""]);
  assert.equal(watch.state, "asked");
  socket.hear(asked.call, { case: "watchCable", value: response(1) });
  assert.deepEqual([watch.state, heard.length], ["open", 1]);

  watch.open({ world: "w", robot: "k", sensor: "laser" });
  socket.hear(asked.call, { case: "watchCable", value: response(1) });
  assert.equal(heard.length, 1, "nothing more is heard of the first cable");
  const second = socket.requests().at(-1);
  assert.ok(second);
  socket.hear(second.call, { case: "failure", value: { code: "UNAVAILABLE", message: "gone" } });
  assert.equal(String(watch.state), "Error: gone");
  watch.again();
  assert.equal(socket.requests().at(-1)?.request.case, "watchCable");
  watch.close();
  assert.equal(socket.requests().at(-1)?.request.case, "close");
  const asks = socket.sent.length;
  watch.again();
  assert.equal(socket.sent.length, asks, "nobody looks");
});
