/** What was seen on the pins of the chosen robot's chip of late, signal by signal. */
import { PinEventKind, type PinEvent } from "../gen/baudbot/v1/observe_pb";

/** Something on a signal, until the next. Instants are numbers here: see `numberOf`. */
export interface PinPart {
  /** UNSPECIFIED: nothing is known from here on. */
  kind: PinEventKind;
  at_ns: number;
  /** A result of the ADC, or a character. */
  number: number;
  /** Only of pulses. */
  pulses?: Pulses;
  /** Only of rounds of the main loop. */
  rounds?: Rounds;
}

export interface Rounds {
  until_ns: number;
  count: number;
  /** All together, in periods of the chip's clock. */
  cycles: number;
}

export interface Pulses {
  until_ns: number;
  count: number;
  high_ns: number;
  /** They are alike. */
  even: boolean;
}

/** More of a signal are not kept. */
const MOST = 4000;
/** Pulses are alike if they differ by less than this part of a period, as in crates/sim/src/chip/pulses.rs. */
const UNLIKE = 50;

export class PinLog {
  private readonly signals = new Map<number, PinPart[]>();
  /** Up to when it is known what was on the pins. */
  private known_ns = -Infinity;

  /** What is on a signal, in the order of time. */
  of(signal: number): readonly PinPart[] {
    return this.signals.get(signal) ?? [];
  }

  /** Events of a frame at an instant, of which so many are missing. What is told again replaces what is here. */
  take(events: PinEvent[], missed: bigint, now_ns: number): void {
    if (missed > 0n) this.forget();
    for (const event of events) {
      const parts = this.signals.get(event.signal) ?? [];
      this.signals.set(event.signal, parts);
      const at_ns = Number(event.atNs);
      while ((parts.at(-1)?.at_ns ?? -Infinity) > at_ns) parts.pop();
      const part: PinPart = { kind: event.kind, at_ns, number: event.number };
      if (event.kind === PinEventKind.PULSES)
        part.pulses = {
          until_ns: Number(event.untilNs),
          count: event.pulses,
          high_ns: Number(event.highNs),
          even: event.even,
        };
      if (event.kind === PinEventKind.ROUND || event.kind === PinEventKind.SHORT_ROUNDS)
        part.rounds = { until_ns: Number(event.untilNs), count: event.rounds, cycles: Number(event.cycles) };
      if (!goesOn(parts.at(-1), part)) parts.push(part);
      if (parts.length > 2 * MOST) parts.splice(0, parts.length - MOST);
    }
    this.known_ns = now_ns;
  }

  /** The world went back: what is not before an instant has not happened. */
  cut(time_ns: number): void {
    for (const [signal, all] of this.signals) {
      const parts = all.filter((part) => part.at_ns < time_ns && (untilOf(part) ?? 0) <= time_ns);
      this.signals.set(signal, parts);
    }
    this.known_ns = Math.min(this.known_ns, time_ns);
  }

  /** Nothing is known of what comes next. */
  private forget(): void {
    if (this.known_ns === -Infinity) return;
    for (const parts of this.signals.values()) {
      if ((parts.at(-1)?.at_ns ?? Infinity) < this.known_ns)
        parts.push({ kind: PinEventKind.UNSPECIFIED, at_ns: this.known_ns, number: 0 });
    }
  }
}

/** When something ends that says so itself. */
export function untilOf(part: PinPart): number | undefined {
  return part.pulses?.until_ns ?? part.rounds?.until_ns;
}

/** The share of time in which the wire is high, from 0 to 1. */
export function dutyOf(part: PinPart): number {
  return part.pulses ? part.pulses.high_ns / Math.max(1, part.pulses.until_ns - part.at_ns) : 0;
}

/** Pulses per second. */
export function frequencyOf(part: PinPart): number {
  return part.pulses ? (part.pulses.count * 1e9) / Math.max(1, part.pulses.until_ns - part.at_ns) : 0;
}

/** Whether pulses follow on others and are alike, or short rounds on others; then those take them in. */
function goesOn(last: PinPart | undefined, next: PinPart): boolean {
  const [few, others] = [last?.rounds, next.rounds];
  if (few && others) {
    const areShort = last?.kind === PinEventKind.SHORT_ROUNDS && next.kind === PinEventKind.SHORT_ROUNDS;
    if (!areShort || few.until_ns !== next.at_ns) return false;
    few.until_ns = others.until_ns;
    few.count += others.count;
    few.cycles += others.cycles;
    return true;
  }
  const [before, more] = [last?.pulses, next.pulses];
  if (!last || !before || !more || before.until_ns !== next.at_ns || before.even !== more.even) return false;
  if (before.even && !isAlike(last, next)) return false;
  before.until_ns = more.until_ns;
  before.count += more.count;
  before.high_ns += more.high_ns;
  return true;
}

function isAlike(a: PinPart, b: PinPart): boolean {
  const [long_a, long_b] = [1e9 / frequencyOf(a), 1e9 / frequencyOf(b)];
  const far = long_a / UNLIKE + 1;
  return Math.abs(long_a - long_b) <= far && Math.abs(dutyOf(a) * long_a - dutyOf(b) * long_b) <= far;
}
