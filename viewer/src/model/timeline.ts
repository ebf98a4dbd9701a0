/** What happened on the chosen robot of late. */
import { TimelineKind, type TimelineEvent } from "../gen/baudbot/v1/observe_pb";

/** An event. Instants are numbers here: see `numberOf`. */
export interface Happening {
  start_ns: number;
  end_ns: number;
  kind: TimelineKind;
  part: number | undefined;
  bytes: number;
}

/** More are not kept; ten Δt of a busy robot are some hundreds. */
const MOST = 3000;

export class Timeline {
  /** In the order in which they became known. */
  happenings: Happening[] = [];
  /** Events before this instant may be told a second time: the world went back to it. */
  private known_ns = -Infinity;

  /** Events of a frame; the first frame of a Watch repeats what was known before. */
  take(events: TimelineEvent[], first: boolean): void {
    if (first) this.cut(-Infinity);
    const before = this.known_ns > -Infinity ? new Set(this.happenings.map(keyOf)) : undefined;
    for (const event of events.slice(-MOST)) {
      const happening = {
        start_ns: Number(event.startNs),
        end_ns: Number(event.endNs),
        kind: event.kind,
        part: event.part,
        bytes: event.bytes,
      };
      if (happening.start_ns > this.known_ns || !before?.has(keyOf(happening))) this.happenings.push(happening);
    }
    if (events.length > 0) this.known_ns = -Infinity;
    if (this.happenings.length > 2 * MOST) this.happenings = this.happenings.slice(-MOST);
  }

  /** Takes away what had not begun before an instant. */
  cut(time_ns: number): void {
    this.happenings = this.happenings.filter((event) => event.start_ns < time_ns);
    this.known_ns = time_ns;
  }
}

function keyOf({ start_ns, end_ns, kind, part, bytes }: Happening): string {
  return `${start_ns} ${end_ns} ${kind} ${part} ${bytes}`;
}
