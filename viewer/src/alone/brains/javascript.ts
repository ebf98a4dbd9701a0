/** Brains in JavaScript. */
import type { Answer, BrainTurn } from "./turn";

/** What a brain does in a step; each robot has a memory of its own. */
export type Step = (turn: BrainTurn, memory: Record<string, unknown>) => Answer | null | undefined;

/** Makes a brain for a run: nothing in it is left of another run. */
export type Make = () => Step;

/** What makes the function `step` of a text, with variables of its own. */
export function makerOfJavascript(code: string): Make {
  const own = new Set(Reflect.ownKeys(globalThis));
  return () => {
    for (const key of Reflect.ownKeys(globalThis)) if (!own.has(key)) Reflect.deleteProperty(globalThis, key);
    return stepOfJavascript(code);
  };
}

function stepOfJavascript(code: string): Step {
  const step: unknown = new Function(
    `"use strict";\n${code}\nreturn typeof step === "undefined" ? undefined : step;`,
  )();
  if (typeof step === "function") return step as Step;
  throw new Error("there is no function step(turn, memory)");
}
