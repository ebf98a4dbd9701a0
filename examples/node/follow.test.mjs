import assert from "node:assert/strict";
import { test } from "node:test";
import { makeBrain, step } from "./follow.mjs";
import { drive } from "./link.mjs";
import { startServer } from "./test_server.mjs";

const stepWith = (values) => step((sensor, unread) => values[sensor] ?? unread);

test("it turns on the spot before any reading", () => {
  assert.deepEqual(stepWith({}), { leftSignal: -0.2, rightSignal: 0.2 });
});

test("it drives straight at the wanted nearness", () => {
  const signals = stepWith({ ir_front: 0, ir_front_left: 0, ir_right: 0.3 });
  assert.deepEqual(signals, { leftSignal: 0.4, rightSignal: 0.4 });
});

test("it turns away from a wall that is too near", () => {
  const { leftSignal, rightSignal } = stepWith({ ir_front: 0, ir_front_left: 0, ir_right: 0.1, ir_front_right: 0.9 });
  assert.ok(leftSignal < rightSignal, `${leftSignal}, ${rightSignal}`);
});

test("it commands again after a tenth of a second, and after a reset", () => {
  const brain = makeBrain();
  const value = (sensor, unread) => unread;
  const turns = [[500n, false], [510n, false], [520n, true], [620n, false], [10n, false]];
  const answers = turns.map(([atMs, isNews]) => brain({ robot: 0, atNs: atMs * 1_000_000n, isNews, value }));
  assert.deepEqual(answers.map(({ command }) => command !== undefined), [true, false, true, true, true]);
});

test("it drives until the run is over", async (t) => {
  process.env.BAUDBOT_CONNECT = await startServer(t, "--pace", "lockstep", "--set", "end.after_s=10.0");
  const commands = [];
  const tick = await drive("follow.mjs", () => {
    const brain = makeBrain();
    return (turn) => {
      const answer = brain(turn);
      commands.push(answer.command);
      return answer;
    };
  });
  assert.equal(tick, "1000");
  assert.ok(commands.some((command) => command?.leftSignal > 0 && command.rightSignal > 0), "no command drives forwards");
});
