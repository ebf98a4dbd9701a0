/**
 * A control cycle among the events: from the reads whose values a message carries to the command that answers it. As in
 * `baudbot diagram` (cli/src/diagram/cycle.rs), but for the last cycle that is over instead of the n-th.
 */
import { TimelineKind } from "../gen/baudbot/v1/observe_pb";
import type { Happening } from "../model/timeline";

export interface Cycle {
  /** When it began: when the message was begun, less what the reads took. */
  begun_ns: number;
  /** When the command is obeyed that answers it. */
  obeyed_ns: number;
  /** The end of the latest of its events. */
  end_ns: number;
  events: Set<Happening>;
}

/** The last cycle that was answered; undefined if none was. */
export function lastCycle(all: Happening[]): Cycle | undefined {
  const ups = waysUp(all);
  for (let i = all.length - 1; i >= 0; i--) {
    const frame = all[i];
    if (frame?.kind !== TimelineKind.FRAME) continue;
    const cycle = follow(all, i, frame, ups.get(frame));
    if (cycle) return cycle;
  }
  return undefined;
}

/** Each message's way over the wire, which keeps messages in their order. */
function waysUp(all: Happening[]): Map<Happening, Happening> {
  const byStart = (a: Happening, b: Happening) => a.start_ns - b.start_ns;
  const frames = all.filter((event) => event.kind === TimelineKind.FRAME).sort(byStart);
  const ups = all.filter((event) => event.kind === TimelineKind.UP).sort(byStart);
  const found = new Map<Happening, Happening>();
  let next = 0;
  for (const up of ups) {
    // A message that never came on the wire was lost; the next one of this size is the one.
    let i = next;
    while (i < frames.length && frames[i]?.bytes !== up.bytes) i++;
    const frame = frames[i];
    if (!frame || frame.start_ns > up.start_ns) continue;
    found.set(frame, up);
    next = i + 1;
  }
  return found;
}

function follow(all: Happening[], at: number, frame: Happening, up: Happening | undefined): Cycle | undefined {
  const events = new Set<Happening>([frame]);
  const take = (kind: TimelineKind, is: (event: Happening) => boolean): Happening | undefined => {
    const found = earliest(all, (event) => event.kind === kind && is(event));
    if (found) events.add(found);
    return found;
  };
  let reading_ns = 0;
  for (const read of readsBefore(all, at)) {
    reading_ns += read.end_ns - read.start_ns;
    events.add(read);
  }
  take(TimelineKind.BLOCK, (event) => event.start_ns >= frame.start_ns && event.start_ns <= frame.end_ns);
  if (up) events.add(up);
  // A link that takes no time has no event of its own for the wire.
  const arrived = up?.end_ns ?? frame.end_ns;
  const there = take(TimelineKind.ADAPTER, (event) => event.start_ns === arrived)?.end_ns ?? arrived;
  const thought = take(TimelineKind.THINK, (event) => event.part === 1 && event.start_ns >= there);
  if (!thought) return undefined;
  // What a step of the brain wrote it wrote within the step; what is written later answers another message.
  const isOwn = (event: Happening) => event.start_ns >= thought.start_ns && event.start_ns <= thought.end_ns;
  const down = all.findLast((event) => event.kind === TimelineKind.DOWN && isOwn(event));
  if (!down) return undefined;
  events.add(down);
  const least = down.end_ns;
  const obeyed = take(TimelineKind.OBEY, (event) => event.end_ns >= least);
  if (!obeyed) return undefined;
  take(TimelineKind.ACT, (event) => event.start_ns >= obeyed.end_ns);
  const end_ns = Math.max(...[...events].map((event) => event.end_ns));
  return { begun_ns: frame.start_ns - reading_ns, obeyed_ns: obeyed.end_ns, end_ns, events };
}

/** The reads between the message before and this one: events are noted in the order in which the tasks are done. */
function readsBefore(all: Happening[], at: number): Happening[] {
  const reads: Happening[] = [];
  for (let i = at - 1; i >= 0 && all[i]?.kind !== TimelineKind.FRAME; i--) {
    const event = all[i];
    if (event?.kind === TimelineKind.ACQUIRE) reads.push(event);
  }
  return reads;
}

function earliest(all: Happening[], is: (event: Happening) => boolean): Happening | undefined {
  let found: Happening | undefined;
  for (const event of all) {
    if (is(event) && (!found || event.start_ns < found.start_ns)) found = event;
  }
  return found;
}
