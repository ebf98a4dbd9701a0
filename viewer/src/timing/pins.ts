/**
 * From what is on the pins of a chip to lanes of the timing diagram, as in `baudbot diagram` (crates/plot/src/timing/pins.rs): waves of
 * pins, results of the ADC, and the characters of the UART.
 */
import { PinEventKind as K, PinSignalKind as S, TimelineKind, type PinSignal } from "../gen/baudbot/v1/observe_pb";
import { dutyOf, frequencyOf, untilOf, type PinLog, type PinPart } from "../model/pins";
import { duration, short } from "../model/units";
import { LINES, type Kind } from "./kinds";
import type { Bar, Lane, Window } from "./layout";

/** A part of a wave with its end. */
export interface WavePart {
  part: PinPart;
  until_ns: number;
}

const PINS = 7;
const CHIP = 8;
const LOOP = 9;
/** A character that is so wide, in pixels, is a bar of its own. */
const ROOMY = 14;

/** The lanes of a chip's signals. A pixel is so long. */
export function pinLanes(signals: PinSignal[], log: PinLog, window: Window, now_ns: number, px_ns: number): Lane[] {
  const onAdc = new Set(
    signals.flatMap((signal) => (signal.kind === S.ADC && signal.pin !== undefined ? [signal.pin] : [])),
  );
  const lane = (signal: PinSignal, i: number): Lane[] => {
    const label = [signal.signal, ...signal.on].join(" ");
    const parts = seen(log.of(i), window, now_ns);
    switch (signal.kind) {
      case S.PIN: {
        const isShown = (signal.on.length > 0 && !onAdc.has(i)) || moves(parts, window);
        return isShown ? [{ label, group: PINS, rows: 1, bars: [], wave: parts }] : [];
      }
      case S.MAIN_LOOP:
        return parts.length > 0 ? [bars(label, rounds(parts), LOOP)] : [];
      case S.ADC:
        return [bars(label, results(parts, window))];
      case S.SENT:
        return log.of(i).length > 0 ? [bars(label, characters(parts, px_ns, LINES.sent))] : [];
      case S.RECEIVED:
        return log.of(i).length > 0 ? [bars(label, characters(parts, px_ns, LINES.received))] : [];
      default:
        return [];
    }
  };
  return signals.flatMap(lane);
}

/** What a part of a wave is, in words. */
export function partInWords(part: PinPart): string {
  switch (part.kind) {
    case K.LOW:
      return "low";
    case K.HIGH:
      return "high";
    case K.OPEN:
      return "not driven, or a voltage";
    case K.SHORT:
      return "driven against each other";
    case K.PULSES:
      return `${part.pulses?.count ?? 0} pulses, ${pulsesInWords(part)}`;
    default:
      return "";
  }
}

/** The duty and the frequency of pulses that are alike, else how many there are. */
export function pulsesInWords(part: PinPart): string {
  if (!part.pulses?.even) return `${part.pulses?.count ?? 0} × high`;
  const percent = `${Number((100 * dutyOf(part)).toFixed(1))} %`;
  const hz = frequencyOf(part);
  return `${percent}, ${hz < 1000 ? `${short(hz)} Hz` : `${short(hz / 1000)} kHz`}`;
}

/** A character as text, with an escape if it cannot be printed. */
export function printable(number: number): string {
  const known = { 9: "\\t", 10: "\\n", 13: "\\r", 92: "\\\\" }[number];
  if (known) return known;
  return number >= 32 && number < 127 ? String.fromCharCode(number) : `\\x${number.toString(16).padStart(2, "0")}`;
}

/** The parts of which something is in a window, with their ends. */
function seen(parts: readonly PinPart[], window: Window, now_ns: number): WavePart[] {
  const found: WavePart[] = [];
  for (let i = parts.length - 1; i >= 0; i--) {
    const part = parts[i] as PinPart;
    const next = parts[i + 1];
    const until_ns = untilOf(part) ?? next?.at_ns ?? Math.max(now_ns, part.at_ns);
    if (until_ns < window.from_ns) break;
    if (part.at_ns < window.until_ns) found.push({ part, until_ns });
  }
  return found.reverse();
}

/** Whether a wire changes in the window, other than by being let go. */
function moves(parts: WavePart[], window: Window): boolean {
  const drives = (part: PinPart) => part.kind === K.LOW || part.kind === K.HIGH || part.kind === K.SHORT;
  return parts.some(({ part }) => part.kind === K.PULSES || (part.at_ns > window.from_ns && drives(part)));
}

function bars(label: string, own: Bar[], group = CHIP): Lane {
  return { label, group, rows: 1, bars: own };
}

function rounds(parts: WavePart[]): Bar[] {
  return parts.flatMap(({ part, until_ns }) => {
    if (!part.rounds) return [];
    const { count, cycles } = part.rounds;
    const label = count > 1 ? `${count} rounds` : duration(until_ns - part.at_ns);
    const style = part.kind === K.SHORT_ROUNDS ? LINES.rounds : LINES.round;
    return [bar(part.at_ns, until_ns, label, style, roundsInWords(count, cycles))];
  });
}

/** How many rounds of the main loop these are, and how many cycles they take. */
export function roundsInWords(count: number, cycles: number): string {
  const mean = Number((cycles / Math.max(1, count)).toFixed(1));
  return count > 1 ? `${count} short rounds, ${mean} cycles on average` : `a round of ${mean} cycles`;
}

function bar(from_ns: number, until_ns: number, label: string, style: Kind, tip: string): Bar {
  const event = { start_ns: from_ns, end_ns: until_ns, kind: TimelineKind.UNSPECIFIED, part: undefined, bytes: 0 };
  return { event, row: 0, label, pale: false, style, tip };
}

function results(parts: WavePart[], window: Window): Bar[] {
  return parts
    .filter(({ part }) => part.kind === K.NUMBER && part.at_ns >= window.from_ns)
    .map(({ part }) => bar(part.at_ns, part.at_ns, String(part.number), LINES.convert, String(part.number)));
}

/** Characters; those that follow on each other and have no room for their own text are one bar. */
function characters(parts: WavePart[], px_ns: number, style: Kind): Bar[] {
  const words: Bar[] = [];
  for (const { part, until_ns } of parts) {
    if (part.kind !== K.NUMBER) continue;
    const [text, long_ns] = [printable(part.number), until_ns - part.at_ns];
    const last = words.at(-1);
    if (last && long_ns < ROOMY * px_ns && part.at_ns - last.event.end_ns <= long_ns / 2) {
      last.event.end_ns = until_ns;
      last.label += text;
      last.tip = last.label;
    } else words.push(bar(part.at_ns, until_ns, text, style, text));
  }
  return words;
}
