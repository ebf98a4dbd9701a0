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

/** Whether a file is one in MCAP, by its first bytes. */
export function isMcap(bytes: Uint8Array): boolean {
  return [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a].every((byte, i) => bytes[i] === byte);
}
