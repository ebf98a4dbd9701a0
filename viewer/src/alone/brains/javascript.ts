/** Brains in JavaScript. */
import type { Answer, BrainTurn } from "./turn";

/** What a brain does in a step; each robot has a memory of its own. */
export type Step = (turn: BrainTurn, memory: Record<string, unknown>) => Answer | null | undefined;

/** The function `step` of a text. */
export function stepOfJavascript(code: string): Step {
  const step: unknown = new Function(
    `"use strict";\n${code}\nreturn typeof step === "undefined" ? undefined : step;`,
  )();
  if (typeof step === "function") return step as Step;
  throw new Error("there is no function step(turn, memory)");
}
