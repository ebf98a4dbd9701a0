/** States in words. */
import { WorldState, type WorldStatus } from "../gen/baudbot/v1/world_pb";

/** What a world is doing, in a word for people and one for styles. */
export function stateWords(status: WorldStatus | undefined): { text: string; style: string } {
  switch (status?.state) {
    case WorldState.RUNNING:
      return { text: "running", style: "running" };
    case WorldState.PAUSED:
      return { text: "paused", style: "paused" };
    case WorldState.ENDED:
      return { text: "ended", style: "ended" };
    case WorldState.WAITING_FOR_BRAINS:
      return { text: "waiting for brains", style: "waiting" };
    default:
      return { text: "–", style: "paused" };
  }
}

/** The number of the line that a message speaks of; 0 if it speaks of none. */
export function lineOf(message: string): number {
  const found = /\bline[ :]+(\d{1,6})\b/i.exec(message);
  return found ? Number(found[1]) : 0;
}
