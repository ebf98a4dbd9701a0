// A brain in TypeScript that follows the wall on its right. For one of your own change `step`, and keep link.ts.
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { CommandSchema } from "./gen/baudbot/v1/brain_link_pb";
import { type Brain, drive, type Value } from "./link";
import { withParameters } from "./settings";

// `wanted` is the nearness of the wall that it keeps: 0 is out of range, 1 is very near.
const { speed, gain, wanted } = withParameters({ speed: 0.4, gain: 1.0, wanted: 0.3 });

const repeatNs = 100_000_000n;

/** What the brain does in a step. `value` gives a sensor's last reading, or `unread` if none has arrived yet. */
function step(value: Value): MessageInitShape<typeof CommandSchema> {
  const ahead = Math.max(value("ir_front", 1), value("ir_front_left", 1));
  if (ahead > wanted) {
    return { leftSignal: -0.5 * speed, rightSignal: 0.5 * speed }; // a corner: to the left, on the spot
  }
  const right = Math.max(value("ir_right", 0), value("ir_front_right", 0));
  const turning = gain * speed * (right - wanted); // too near: to the left
  return { leftSignal: speed - turning, rightSignal: speed + turning };
}

/**
 * Makes a brain that has driven no robot yet. It gives one command for each message, and another after 0.1 s without any,
 * since the cable may have lost the last one.
 */
function makeBrain(): Brain {
  const commandedAtNs: bigint[] = []; // by robot
  return ({ robot, atNs, isNews, value }) => {
    const last = commandedAtNs[robot];
    const isDue = last === undefined || atNs >= last + repeatNs;
    const wasReset = last !== undefined && atNs < last;
    if (!isNews && !isDue && !wasReset) {
      return { robot, untilMessage: { atLatestNs: last + repeatNs } };
    }
    commandedAtNs[robot] = atNs;
    return { robot, output: { case: "command", value: step(value) }, untilMessage: { atLatestNs: atNs + repeatNs } };
  };
}

try {
  console.log(`the run is over at tick ${await drive("follow.ts", makeBrain)}`);
} catch (error) {
  console.error(`follow.ts: ${(error as Error).message}`);
  process.exitCode = 1;
}
