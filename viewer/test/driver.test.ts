/** Brains that are typed into the page: when they are asked, and that each run has new ones. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { AttachResponseSchema } from "../src/gen/baudbot/v1/brain_link_pb";
import { Driver } from "../src/alone/brains/driver";
import { makerOfJavascript, type Make } from "../src/alone/brains/javascript";
import { makerOfPython } from "../src/alone/brains/python";

const MS = 1_000_000;

/** A driver of so many robots with a sensor each. */
function drives(brain: string | Make, robots = 1) {
  const driver = new Driver(typeof brain === "string" ? makerOfJavascript(brain) : brain);
  const sensors = [{ sensor: "ir" }];
  const sheets = Array.from({ length: robots }, (_, i) => ({ robot: `r${i}`, sensors }));
  const hear = (response: object) => driver.hear(create(AttachResponseSchema, { response } as never).response);
  hear({ case: "welcome", value: { robots: sheets } });
  let turn = 0n;
  /** The left signals that are answered, by robot; undefined where there is no command. */
  return (tick: number, at_ms: number, readable: boolean, who = [0]) => {
    const part = (robot: number) => ({
      robot,
      atNs: BigInt(Math.round(at_ms * MS)),
      readings: [{ sensor: 0, values: [0.5], readable }],
    });
    const answer = hear({ case: "turn", value: { turn: ++turn, tick: BigInt(tick), robots: who.map(part) } });
    return answer?.value.robots?.map(({ output }) => (output as { value?: { leftSignal: number } })?.value?.leftSignal);
  };
}

test("a brain is asked when there is news, or when what it waits for is over", () => {
  const step = drives("let n = 0; function step() { n++; return { left: n, right: 0 }; }");
  // As in real time over 9600 baud: each second step is without news.
  const answers = [0, 1, 2, 3, 4, 5].map((tick) => step(tick, 10 * tick + 0.5, tick % 2 === 0)?.[0]);
  assert.deepEqual(answers, [1, undefined, 2, undefined, 3, undefined]);
  assert.deepEqual(step(14, 140.4, false), [undefined], "0.1 s after its last step");
  assert.deepEqual(step(15, 140.5, false), [4], "0.1 s after its last step it may repeat itself");
});

test("a brain that wants to be asked in each step is", () => {
  const step = drives("let n = 0; function step() { n++; return { left: n, right: 0, wait_s: 0 }; }");
  assert.deepEqual(
    [0, 1, 2].map((tick) => step(tick, 10 * tick, false)?.[0]),
    [1, 2, 3],
  );
});

test("each run has a new brain, whatever it keeps where", () => {
  const kept = [
    "function step(turn, memory) { memory.n = (memory.n ?? 0) + 1; return { left: memory.n, right: 0 }; }",
    "let n = 0; function step() { n++; return { left: n, right: 0 }; }",
    "globalThis.n = 0; function step() { globalThis.n++; return { left: globalThis.n, right: 0 }; }",
    "function step() { globalThis.m = (globalThis.m ?? 0) + 1; return { left: globalThis.m, right: 0 }; }",
  ];
  for (const code of kept) {
    const step = drives(code);
    // A run, one that was reset at once, one that was reset later, and one that was restored.
    const ticks = [0, 0, 1, 2, 0, 5, 9, 5, 6];
    assert.deepEqual(
      ticks.map((tick) => step(tick, 10 * tick, true)?.[0]),
      [1, 1, 2, 3, 1, 2, 3, 1, 2],
      code,
    );
  }
});

test("each run has a new brain in Python, too", async () => {
  const brain = `
import colorsys
import baudbot

class Counts(baudbot.Brain):
    own, ours = 0, [0]

    def step(self, turn):
        self.own += 1
        self.ours[0] += 1
        colorsys.steps = getattr(colorsys, "steps", 0) + 1
        assert self.own == self.ours[0] == colorsys.steps
        return baudbot.drive(self.own, 0)

if __name__ == "__main__":
    baudbot.main(Counts)
`;
  const folder = `${new URL("../node_modules/pyodide/", import.meta.url).pathname}`;
  const step = drives(await makerOfPython(brain, folder, () => {}));
  assert.deepEqual(
    [0, 0, 1, 2, 0, 5, 9, 5, 6].map((tick) => step(tick, 10 * tick, true)?.[0]),
    [1, 1, 2, 3, 1, 2, 3, 1, 2],
  );
});

test("robots that are asked one after the other in a tick are in the same run", () => {
  const code = "function step(turn, memory) { memory.n = (memory.n ?? 0) + 1; return { left: memory.n, right: 0 }; }";
  const step = drives(code, 2);
  assert.deepEqual([step(0, 0, true, [0, 1]), step(1, 10, true, [0]), step(1, 10, true, [1])], [[1, 1], [2], [2]]);
  assert.deepEqual(step(1, 10, true, [0, 1]), [1, 1]);
});
