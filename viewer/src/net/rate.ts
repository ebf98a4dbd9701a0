/** How often a frame is asked for: as often as eyes want it, whatever the pace and however large the world. */
import type { Pace } from "../gen/baudbot/v1/world_pb";

/** Frames a second of wall-clock time that look smooth, as poses are interpolated between them. */
const WANTED_PER_S = 25;
/** Share of the time that messages may take. */
const MOST_LOAD = 0.4;

/** What was measured over the last while. */
export interface Measured {
  /** Ticks that went by in a second of wall-clock time. */
  ticks_per_s: number;
  /** Share of the wall-clock time that messages took. */
  load: number;
}

/** What to begin with, before anything is measured. */
export function firstEvery(pace: Pace | undefined, step_s: number): number {
  const kind = pace?.kind;
  if (kind?.case === "stepped") return 1;
  const factor = kind?.case === "scaled" ? kind.value.factor : 1;
  return atLeastOne(factor / (WANTED_PER_S * step_s));
}

/** Ticks between two frames from now on. It stays as it is unless another would be much better. */
export function nextEvery(current: number, pace: Pace | undefined, measured: Measured): number {
  if (pace?.kind.case === "stepped") return 1;
  if (measured.ticks_per_s <= 0) return current;
  const bearable = (current * measured.load) / MOST_LOAD;
  const wanted = atLeastOne(Math.max(measured.ticks_per_s / WANTED_PER_S, bearable));
  const ratio = wanted / current;
  return ratio > 1.8 || ratio < 0.55 ? wanted : current;
}

function atLeastOne(ticks: number): number {
  return Math.max(1, Math.round(ticks));
}
