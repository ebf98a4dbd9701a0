#!/usr/bin/env node
// A brain that follows the wall on its right. For one of your own change `step`, and keep link.mjs.
import { realpathSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { drive } from "./link.mjs";

const SPEED = 0.4;
const GAIN = 1.0;
const WANTED = 0.3; // nearness of the wall that it keeps: 0 is out of range, 1 is very near
const REPEAT_NS = 100_000_000n;

/** What the brain does in a step. `value` gives a sensor's last reading, or `unread` if none has arrived yet. */
export function step(value) {
  const ahead = Math.max(value("ir_front", 1), value("ir_front_left", 1));
  if (ahead > WANTED) {
    return { leftSignal: -0.5 * SPEED, rightSignal: 0.5 * SPEED }; // a corner: to the left, on the spot
  }
  const right = Math.max(value("ir_right", 0), value("ir_front_right", 0));
  const turning = GAIN * SPEED * (right - WANTED); // too near: to the left
  return { leftSignal: SPEED - turning, rightSignal: SPEED + turning };
}

/**
 * Makes a brain that has driven no robot yet. It gives one command for each message, and another after 0.1 s without any,
 * since the cable may have lost the last one.
 */
export function makeBrain() {
  const commandedAtNs = []; // by robot
  return ({ robot, atNs, isNews, value }) => {
    const last = commandedAtNs[robot];
    const wasReset = atNs < last;
    const answer = { robot };
    if (isNews || last === undefined || wasReset || atNs >= last + REPEAT_NS) {
      commandedAtNs[robot] = atNs;
      answer.command = step(value);
    }
    answer.untilMessage = { atLatestNs: String(commandedAtNs[robot] + REPEAT_NS) };
    return answer;
  };
}

if (realpathSync(process.argv[1]) === fileURLToPath(import.meta.url)) {
  try {
    console.log(`the run is over at tick ${await drive("follow.mjs", makeBrain)}`);
  } catch (error) {
    console.error(`follow: ${error.message}`);
    process.exitCode = 1;
  }
}
