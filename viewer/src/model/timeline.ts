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

  /** Events of a frame; the first frame of a Watch repeats what was known before. */
  take(events: TimelineEvent[], first: boolean): void {
    if (first) this.happenings = [];
    for (const event of events.slice(-MOST)) {
      this.happenings.push({
        start_ns: Number(event.startNs),
        end_ns: Number(event.endNs),
        kind: event.kind,
        part: event.part,
        bytes: event.bytes,
      });
    }
    if (this.happenings.length > 2 * MOST) this.happenings = this.happenings.slice(-MOST);
  }

  clear(): void {
    this.happenings = [];
  }
}
