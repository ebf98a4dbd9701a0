/** Which ticks a film shows. */
import { within, type Range } from "../model/replay";

export interface FilmWish {
  /** In simulated seconds; absent: the recording's beginning and end. */
  from_s?: number | undefined;
  to_s?: number | undefined;
  /** Simulated seconds per second of the film. */
  speed: number;
  /** Pictures per second. */
  fps: number;
}

/** More pictures would not fit into the memory of a page. */
const MOST_PICTURES = 20_000;
/** A GIF counts in hundredths of a second, and browsers slow down what is quicker. */
const MOST_FPS = 50;

/** The tick of each picture. What cannot be done is thrown, in words. */
export function planFilm(range: Range, step_s: number, { from_s, to_s, speed, fps }: FilmWish): bigint[] {
  if (!(speed > 0)) throw new Error("speed: must be positive");
  if (!(fps >= 1 && fps <= MOST_FPS)) throw new Error(`fps: must be 1 to ${MOST_FPS}`);
  const first_s = Math.max(from_s ?? -Infinity, Number(range.first) * step_s);
  const last_s = Math.min(to_s ?? Infinity, Number(range.last) * step_s);
  if (!(last_s >= first_s)) throw new Error("to_s: must not be before from_s, nor before the recording");
  const count = Math.floor(((last_s - first_s) * fps) / speed + 1e-6) + 1;
  if (count > MOST_PICTURES) throw new Error(`a film of ${count} pictures; there is room for ${MOST_PICTURES}`);
  const tickAt = (k: number) => BigInt(Math.round((first_s + (k * speed) / fps) / step_s));
  return Array.from({ length: count }, (_, k) => within(tickAt(k), range));
}

/** An even number: some codecs know no other sizes. */
export function even(length: number): number {
  return Math.max(2, 2 * Math.round(length / 2));
}
