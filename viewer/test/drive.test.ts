import assert from "node:assert/strict";
import { test } from "node:test";
import type { Hello, Step } from "../src/gen/baudbot/v1/brain_link_pb";
import { Store } from "../src/model/store";
import { Drive } from "../src/net/drive";
import type { Reply } from "./calls";
import { connected } from "./fake_socket";

/** A page that drives `robot` of world `w`, and what its server hears. */
function driving() {
  const { connection, socket } = connected();
  const store = new Store();
  [store.world, store.robot] = ["w", "robot"];
  const drive = new Drive(connection, store);
  drive.start();
  const requests = () => socket.requests().map(({ request }) => request);
  const hear = (reply: Reply) => socket.hear(1, reply);
  const attach = (response: object) => hear({ case: "attach", value: { response } } as never);
  attach({ case: "welcome", value: { robots: [{ signalLimit: 1 }] } });
  return {
    drive,
    socket,
    hello: () => requests().flatMap((one) => (one.case === "attach" ? [one.value.request.value as Hello] : []))[0]!,
    steps: () =>
      requests().flatMap((one) =>
        one.case === "attach" && one.value.request.case === "step" ? [one.value.request.value as Step] : [],
      ),
    closed: () => requests().some((one) => one.case === "close"),
    turn: (turn: number) =>
      attach({
        case: "turn",
        value: { tick: turn, turn: BigInt(turn), robots: [{ robot: 0, atNs: BigInt(turn) * 10_000_000n }] },
      }),
    taken: () => hear({ case: "taken" }),
    fail: () => hear({ case: "failure", value: { code: "ABORTED", message: "thrown off" } }),
  };
}

function command(step: Step | undefined): [number, number] | undefined {
  const output = step?.robots[0]?.output;
  return output?.case === "command" ? [output.value.leftSignal, output.value.rightSignal] : undefined;
}

test("one Step is on its way, and of the Turns that come meanwhile the newest is answered with what is wanted then", () => {
  const { drive, steps, turn, taken } = driving();
  drive.keys.add("w");
  for (let i = 1; i <= 300; i++) turn(i);
  assert.deepEqual(
    steps().map((step) => step.turn),
    [1n],
    "300 Turns that nobody has taken the answer of",
  );
  assert.deepEqual(command(steps()[0]), [0.6, 0.6]);
  drive.keys.clear();
  taken();
  assert.deepEqual(
    steps().map((step) => step.turn),
    [1n, 300n],
  );
  assert.deepEqual(command(steps()[1]), [0, 0]);
  taken();
  assert.equal(steps().length, 2, "nothing is left to be answered");
  turn(301);
  assert.equal(steps().length, 3);
});

test("each Turn of a world that waits is answered at once", () => {
  const { steps, turn, taken } = driving();
  for (let i = 1; i <= 50; i++) {
    turn(i);
    assert.equal(steps().length, i);
    taken();
  }
  assert.deepEqual(
    steps().map((step) => step.turn),
    Array.from({ length: 50 }, (_, i) => BigInt(i + 1)),
  );
});

test("the server is asked to stop the robot when the page is gone", () => {
  const { drive, hello, closed } = driving();
  assert.equal(hello().stopWhenGone, true);
  drive.stop();
  assert.deepEqual([drive.state, closed()], ["off", true]);
});

test("who looks elsewhere wants the robot to stand, whatever was pressed", () => {
  const { drive, steps, turn, taken } = driving();
  let rests = 0;
  drive.on("rest", () => rests++);
  drive.keys.add("w");
  turn(1);
  drive.pad = { forward: 1, left: 0 };
  drive.rest();
  taken();
  turn(20);
  assert.deepEqual(command(steps()[1]), [0, 0]);
  assert.deepEqual([rests, drive.keys.size, drive.state], [1, 0, "driving"]);
});

test("who is thrown off drives no more, and may start over", () => {
  const { drive, socket, steps, turn, fail } = driving();
  drive.keys.add("w");
  turn(1);
  fail();
  assert.deepEqual([drive.state, drive.keys.size], ["off", 0]);
  drive.start();
  assert.equal(drive.state, "asking");
  assert.equal(steps().length, 1);
  socket.onclose?.();
  assert.equal(drive.state, "off");
});
