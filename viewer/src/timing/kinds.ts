/** What a bar stands for, and its colours: those of `baudbot diagram` (crates/plot/src/timing/class.rs, whose test compares). */
import { TimelineKind } from "../gen/baudbot/v1/observe_pb";
import type { Happening } from "../model/timeline";

export interface Kind {
  color: string;
  /** The colour of text on it. */
  ink: string;
  words: string;
  /** Something went wrong. */
  trouble?: boolean;
}

const DARK_INK = "#10151f";
const WHITE = "#ffffff";

const KINDS: Record<TimelineKind, Kind> = {
  [TimelineKind.UNSPECIFIED]: { color: "#8a93a3", ink: WHITE, words: "something" },
  [TimelineKind.ACQUIRE]: { color: "#56b4e9", ink: DARK_INK, words: "a sensor is read" },
  [TimelineKind.MEASURE]: { color: "#b5d9ee", ink: DARK_INK, words: "a device measures" },
  [TimelineKind.FRAME]: { color: "#0072b2", ink: WHITE, words: "readings are framed" },
  [TimelineKind.BLOCK]: { color: "#bcc3cf", ink: DARK_INK, words: "waiting" },
  [TimelineKind.UP]: { color: "#009e73", ink: WHITE, words: "readings on the wire" },
  [TimelineKind.ADAPTER]: { color: "#8fcfb8", ink: DARK_INK, words: "in the adapter" },
  [TimelineKind.PORT]: { color: "#66b8ad", ink: DARK_INK, words: "on a cable of its own" },
  [TimelineKind.THINK]: { color: "#e69f00", ink: DARK_INK, words: "the brain thinks" },
  [TimelineKind.DOWN]: { color: "#cc79a7", ink: DARK_INK, words: "a command on its way" },
  [TimelineKind.PORT_DOWN]: { color: "#e3b7cf", ink: DARK_INK, words: "to a device, on its own cable" },
  [TimelineKind.OBEY]: { color: "#8f4a86", ink: WHITE, words: "a command is taken" },
  [TimelineKind.ACT]: { color: "#5a49b8", ink: WHITE, words: "the motors obey" },
  [TimelineKind.LATE]: { color: "#d0312d", ink: WHITE, words: "not in time", trouble: true },
  [TimelineKind.MISSED]: { color: "#882255", ink: WHITE, words: "skipped", trouble: true },
  [TimelineKind.LOST]: { color: "#b5651d", ink: WHITE, words: "bytes lost", trouble: true },
  [TimelineKind.FAULT]: { color: "#999933", ink: WHITE, words: "a fault", trouble: true },
};

/** What is on the lines of a chip's main loop, ADC and UART. */
export const LINES = {
  round: { color: "#6a5acd", ink: WHITE, words: "a round of the main loop" },
  rounds: { color: "#d6d0ee", ink: DARK_INK, words: "short rounds" },
  convert: { color: "#ddaa33", ink: DARK_INK, words: "the ADC holds a voltage" },
  sent: { color: "#117733", ink: WHITE, words: "the program sends" },
  received: { color: "#aa4499", ink: WHITE, words: "the program receives" },
} satisfies Record<string, Kind>;

/** Whether the brain had no news, so that nothing came of it. */
export function isIdle(event: Happening): boolean {
  return event.kind === TimelineKind.THINK && event.part !== 1;
}

export function kindOf(kind: TimelineKind): Kind {
  return KINDS[kind] ?? KINDS[TimelineKind.UNSPECIFIED];
}
