import assert from "node:assert/strict";
import { test } from "node:test";
import { setImmediate as others } from "node:timers/promises";
import { Store } from "../src/model/store";
import { Orders, paceOf } from "../src/net/orders";
import { Watcher } from "../src/net/watcher";
import { connected } from "./fake_socket";

test("of steps that are asked for while one is under way none is lost, and none is refused", async (t) => {
  t.mock.timers.enable({ apis: ["setInterval"] }); // the watcher's
  const { connection, socket } = connected();
  const store = new Store();
  store.world = "w";
  const orders = new Orders(connection, store, new Watcher(connection, store));
  const status = { world: "w", pace: paceOf("stepped"), robots: [] };
  const asked = () => socket.requests().flatMap(({ request }) => (request.case === "stepWorld" ? [request.value] : []));
  const answer = async () => {
    const { call, request } = socket.requests().at(-1)!;
    socket.hear(call, { case: request.case, value: { status } } as never);
    await others();
  };

  const all = [orders.step(1), orders.step(10), orders.step(1)];
  assert.equal(socket.requests().at(-1)?.request.case, "setPace");
  await answer();
  void orders.step(5);
  assert.deepEqual(
    asked().map(({ ticks }) => ticks),
    [12n],
    "one request at a time",
  );
  await answer();
  assert.deepEqual(
    asked().map(({ ticks }) => ticks),
    [12n, 5n],
  );
  await answer();
  await Promise.all(all);
  // A world that is asked for no more starts over.
  void orders.step(2);
  await others();
  assert.equal(asked().at(-1)?.ticks, 2n);
});

test("a server that does not show its worlds is not one without worlds", async (t) => {
  t.mock.timers.enable({ apis: ["setInterval"] }); // the watcher's
  const { connection, socket } = connected();
  const store = new Store();
  const orders = new Orders(connection, store, new Watcher(connection, store));
  const asked = orders.list();
  const { call } = socket.requests().at(-1)!;
  socket.hear(call, { case: "failure", value: { code: "PERMISSION_DENIED", message: "no right" } } as never);
  assert.equal(await asked, false);
  assert.equal(store.hidden, "no right");
  store.setWorlds([]);
  assert.equal(store.hidden, "", "the next token may");
});
