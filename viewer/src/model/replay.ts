/** Where one is in a recording, and what happened in it. */
import { ReplayEventKind, type ReplayEvent } from "../gen/baudbot/v1/control_pb";

/** The ticks that a recording has. */
export interface Range {
  first: bigint;
  last: bigint;
}

/** A tick that the recording has. */
export function within(tick: bigint, { first, last }: Range): bigint {
  return tick < first ? first : tick > last ? last : tick;
}

/** The first event after a tick, or the last one before it; events are in the order of their ticks. */
export function eventFrom(events: readonly ReplayEvent[], tick: bigint, direction: 1 | -1): ReplayEvent | undefined {
  return direction > 0 ? events.find((event) => event.tick > tick) : events.findLast((event) => event.tick < tick);
}

/** What happened at a tick, in words; of a crowd of events the first three. */
export function wordsAt(events: readonly ReplayEvent[], tick: bigint): string {
  const all = events.filter((event) => event.tick === tick).map((event) => event.text);
  const more = all.length > 3 ? `, and ${all.length - 3} more` : "";
  return all.slice(0, 3).join("; ") + more;
}

/** An event on the time line. */
export interface Mark {
  x: number;
  event: ReplayEvent;
}

/** Kinds from the one that is drawn first, and may be hidden, to the one that is drawn last. */
const ORDER = [
  ReplayEventKind.UNSPECIFIED,
  ReplayEventKind.ORDER,
  ReplayEventKind.COLLISION,
  ReplayEventKind.BRAIN,
  ReplayEventKind.CHANGE,
  ReplayEventKind.ENDING,
];

/** Marks of events on a line that is so long: of one kind one every two pixels, since more could not be told apart. */
export function marksOf(events: readonly ReplayEvent[], range: Range, left: number, wide: number): Mark[] {
  const span = Math.max(1, Number(range.last - range.first));
  const taken = new Set<string>();
  const marks: Mark[] = [];
  for (const event of events) {
    const x = left + (wide * Number(event.tick - range.first)) / span;
    const key = `${event.kind} ${Math.round(x / 2)}`;
    if (taken.has(key)) continue;
    taken.add(key);
    marks.push({ x, event });
  }
  return marks.sort((a, b) => ORDER.indexOf(a.event.kind) - ORDER.indexOf(b.event.kind));
}

/** The mark at a place, the topmost of the nearest; undefined if none is within reach. */
export function markAt(marks: readonly Mark[], x: number, reach: number): Mark | undefined {
  let found: Mark | undefined;
  for (const mark of marks) {
    const away = Math.abs(mark.x - x);
    if (away <= reach && away <= Math.abs((found?.x ?? Infinity) - x)) found = mark;
  }
  return found;
}
