/** Axes of charts: what part of the values they show, and ticks at round numbers whose labels are exactly theirs. */
import { roundStep } from "./units";

export interface Ticks {
  values: number[];
  labels: string[];
}

/** Beyond this many decimals, or above this size, a label is shorter with an exponent. */
const MOST_DECIMALS = 4;
const LARGEST = 1e6;
/** What is smaller is a zero that was computed: nobody looks that closely. */
const NOTHING = 1e-9;
/** Digits that ticks may need to be told apart; with more, doubles have no round numbers left. */
const MOST_DIGITS = 12;

/** Ticks from `min` to `max`, about `most` of them at most: multiples of 1, 2 or 5 times a power of ten. */
export function ticks(min: number, max: number, most: number): Ticks {
  const step = roundStep(Math.max((max - min) / Math.max(1, most), Math.max(-min, max) * 10 ** -MOST_DIGITS));
  const [first, last] = [Math.ceil(min / step - 1e-6), Math.floor(max / step + 1e-6)];
  const places = Math.floor(Math.log10(step) + 1e-6);
  const values = Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => rounded((first + i) * step, places));
  return { values, labels: values.map((value) => label(value, places)) };
}

/** What an axis shows of values from `min` to `max`. Those that hardly change are not blown up to its whole height. */
export function shownRange(min: number | null, max: number | null): [number, number] {
  if (min === null || max === null || !Number.isFinite(min) || !Number.isFinite(max)) return [0, 1];
  const [span, size] = [max - min, Math.max(Math.abs(min), Math.abs(max))];
  if (size < NOTHING) return [-1, 1];
  if (span < 1e-6 * size) return [min - 0.1 * size, max + 0.1 * size];
  const room = Math.max(0.08 * span, 0.02 * size);
  return [min === 0 ? 0 : min - room, max === 0 ? 0 : max + room];
}

/** What part of time is shown: so many seconds up to the last instant, or all that is known if that is 0. */
export function shownSpan(first_s: number, last_s: number, span_s: number): [number, number] {
  if (span_s === 0) return last_s > first_s ? [first_s, last_s] : [Math.max(0, last_s - 1), Math.max(1, last_s)];
  return [Math.max(0, last_s - span_s), Math.max(span_s, last_s)];
}

/** Without what binary fractions leave behind at the end. */
function rounded(value: number, places: number): number {
  return places < 0 ? Number(value.toFixed(Math.min(100, -places))) : value;
}

function label(value: number, places: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  const isPlain = -places <= MOST_DECIMALS && size < LARGEST;
  const digits = Math.max(0, Math.floor(Math.log10(size) + 1e-9) - places);
  const text = isPlain ? size.toFixed(Math.max(0, -places)) : size.toExponential(digits).replace("+", "");
  return (value < 0 ? "−" : "") + text.replace("e-", "e−");
}
