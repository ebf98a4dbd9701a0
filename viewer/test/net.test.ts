import assert from "node:assert/strict";
import { test } from "node:test";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { ListWorldsRequestSchema } from "../src/gen/baudbot/v1/control_pb";
import { WatchRequestSchema, WatchResponseSchema } from "../src/gen/baudbot/v1/observe_pb";
import { PageRequestSchema, PageResponseSchema } from "../src/gen/baudbot/v1/page_pb";
import { ask, CallError, Connection, type Socket } from "../src/net/connection";
import { decode, type Frame } from "../src/net/frames";
import { connected, FakeSocket } from "./fake_socket";
import { MockWorld } from "./mock_world";

test("a frame has the same in it however it is decoded", () => {
  const world = new MockWorld("w", 3);
  for (let i = 0; i < 300; i++) world.step();
  const made = toBinary(WatchResponseSchema, world.frame([0, 1], 200n));
  const whole = fromBinary(WatchResponseSchema, made);
  const bytes = toBinary(
    PageResponseSchema,
    create(PageResponseSchema, { call: 7, response: { case: "watch", value: whole } }),
  );
  const incoming = decode(bytes);
  assert.ok("watch" in incoming);
  assert.equal(incoming.call, 7);
  const { watch } = incoming;
  assert.deepEqual(watch.rest, { ...whole, robots: [] });
  whole.robots.forEach((robot, i) => {
    assert.deepEqual(watch.truth(i), robot);
    assert.deepEqual(
      [watch.poses.x_m[i], watch.poses.y_m[i], watch.poses.heading_rad[i]],
      [robot.xM, robot.yM, robot.headingRad],
    );
    assert.equal(watch.poses.collided[i] === 1, robot.collided);
  });
  assert.equal(watch.truth(3), undefined);
});

test("answers find their calls, in whatever order they come", async () => {
  const { connection, socket } = connected();
  const [first, second] = [1, 2].map(() => ask(connection, "listWorlds", create(ListWorldsRequestSchema)));
  const calls = socket.sent.map((bytes) => fromBinary(PageRequestSchema, bytes).call);
  assert.equal(new Set(calls).size, 2);
  socket.hear(calls[1]!, { case: "listWorlds", value: { worlds: [{ world: "b" }] } } as never);
  socket.hear(calls[0]!, { case: "listWorlds", value: { worlds: [{ world: "a" }] } } as never);
  assert.deepEqual([(await first!).worlds[0]?.world, (await second!).worlds[0]?.world], ["a", "b"]);
});

test("a failure has its code and its words", async () => {
  const { connection, socket } = connected();
  const asked = ask(connection, "listWorlds", create(ListWorldsRequestSchema));
  socket.hear(1, { case: "failure", value: { code: "NOT_FOUND", message: "no" } } as never);
  await assert.rejects(asked, (error: CallError) => error.code === "NOT_FOUND" && error.message === "no");
});

test("a stream goes on until it is closed, and then nothing more is heard of it", () => {
  const { connection, socket } = connected();
  const frames: Frame[] = [];
  const value = create(WatchRequestSchema, { world: "w" });
  const call = connection.begin(
    { case: "watch", value },
    { frame: (frame) => frames.push(frame), over: () => assert.fail("it is not over") },
  );
  const world = new MockWorld("w", 3);
  socket.hear(call, { case: "watch", value: world.frame([], 0n) });
  socket.hear(call, { case: "watch", value: world.frame([], 0n) });
  connection.end(call);
  socket.hear(call, { case: "watch", value: world.frame([], 0n) });
  socket.hear(call, { case: "closed", value: {} } as never);
  assert.equal(frames.length, 2);
  assert.equal(fromBinary(PageRequestSchema, socket.sent.at(-1)!).request.case, "close");
});

test("what is under way fails with the connection, and it is opened again", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout", "Date"] });
  const sockets: FakeSocket[] = [];
  const connection = new Connection(() => sockets[sockets.push(new FakeSocket()) - 1] as unknown as Socket);
  connection.open();
  sockets[0]?.onopen?.();
  const asked = ask(connection, "listWorlds", create(ListWorldsRequestSchema));
  sockets[0]?.onclose?.();
  await assert.rejects(asked, (error: CallError) => error.code === "UNAVAILABLE");
  assert.equal(connection.link.state, "waiting");
  t.mock.timers.tick(500);
  sockets[1]?.onclose?.();
  t.mock.timers.tick(999);
  assert.equal(sockets.length, 2, "the second time it waits for longer");
  t.mock.timers.tick(1);
  assert.equal(sockets.length, 3);
});

test("without a connection a call fails at once", async () => {
  const connection = new Connection(() => new FakeSocket() as unknown as Socket);
  await assert.rejects(
    ask(connection, "listWorlds", create(ListWorldsRequestSchema)),
    (error: CallError) => error.code === "UNAVAILABLE",
  );
});
