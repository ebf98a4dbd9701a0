import assert from "node:assert/strict";
import { test } from "node:test";
import { fromBinary, toBinary } from "@bufbuild/protobuf";
import { ControlService } from "../src/gen/baudbot/v1/control_pb";
import { ObserveService, WatchResponseSchema } from "../src/gen/baudbot/v1/observe_pb";
import { ask, CallError, Connection, type Socket } from "../src/net/connection";
import { decodeFrame, type Frame } from "../src/net/frames";
import { connected, FakeSocket } from "./fake_socket";
import { MockWorld } from "./mock_world";

test("a frame has the same in it however it is decoded", () => {
  const world = new MockWorld("w", 3);
  for (let i = 0; i < 300; i++) world.step();
  const made = toBinary(WatchResponseSchema, world.frame([0, 1], 200n));
  const whole = fromBinary(WatchResponseSchema, made);
  const watch = decodeFrame(made);
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
  const [first, second] = [1, 2].map(() => ask(connection, ControlService.method.listWorlds, {}));
  const calls = socket.requests().map(({ call }) => call);
  assert.equal(new Set(calls).size, 2);
  socket.hear(calls[1]!, { case: "listWorlds", value: { worlds: [{ world: "b" }] } });
  socket.hear(calls[0]!, { case: "listWorlds", value: { worlds: [{ world: "a" }] } });
  assert.deepEqual([(await first!).worlds[0]?.world, (await second!).worlds[0]?.world], ["a", "b"]);
});

test("a failure has its code and its words", async () => {
  const { connection, socket } = connected();
  const asked = ask(connection, ControlService.method.listWorlds, {});
  socket.hear(1, { case: "failure", value: { code: "NOT_FOUND", message: "no" } });
  await assert.rejects(asked, (error: CallError) => error.code === "NOT_FOUND" && error.message === "no");
});

test("a stream goes on until it is closed, and then nothing more is heard of it", () => {
  const { connection, socket } = connected();
  const frames: Frame[] = [];
  const call = connection.begin(
    ObserveService.method.watch,
    { world: "w" },
    { message: (bytes) => frames.push(decodeFrame(bytes)), over: () => assert.fail("it is not over") },
  );
  const world = new MockWorld("w", 3);
  socket.hear(call, { case: "watch", value: world.frame([], 0n) });
  socket.hear(call, { case: "watch", value: world.frame([], 0n) });
  connection.end(call);
  socket.hear(call, { case: "watch", value: world.frame([], 0n) });
  socket.hear(call, { case: "closed" });
  assert.equal(frames.length, 2);
  assert.equal(socket.requests().at(-1)?.request.case, "close");
});

test("what is under way fails with the connection, and it is opened again", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout", "Date"] });
  const sockets: FakeSocket[] = [];
  const connection = new Connection(() => sockets[sockets.push(new FakeSocket()) - 1] as unknown as Socket);
  connection.open();
  sockets[0]?.onopen?.();
  const asked = ask(connection, ControlService.method.listWorlds, {});
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
    ask(connection, ControlService.method.listWorlds, {}),
    (error: CallError) => error.code === "UNAVAILABLE",
  );
});
