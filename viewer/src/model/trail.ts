/** Ways that robots have come, as long as there is room. */
import type { Poses } from "../net/frames";

/** Points of all trails together: what can be drawn sixty times a second. */
const ALL_POINTS = 6000;
const FEWEST = 24;
const MOST = 900;

/** One way: the newest points of it. */
export class Trail {
  private readonly places: Float32Array;
  private head = 0;
  length = 0;

  constructor(readonly capacity: number) {
    this.places = new Float32Array(2 * capacity);
  }

  /** Takes a point, unless it is hardly away from the last one. */
  add(x_m: number, y_m: number, least_m: number): void {
    if (this.length > 0) {
      const [lastX, lastY] = this.at(this.length - 1);
      if (Math.hypot(x_m - lastX, y_m - lastY) < least_m) return;
    }
    this.places[2 * this.head] = x_m;
    this.places[2 * this.head + 1] = y_m;
    this.head = (this.head + 1) % this.capacity;
    this.length = Math.min(this.length + 1, this.capacity);
  }

  /** The i-th point, 0 being the oldest. */
  at(i: number): [number, number] {
    const place = (this.head - this.length + i + this.capacity) % this.capacity;
    return [this.places[2 * place] ?? 0, this.places[2 * place + 1] ?? 0];
  }

  clear(): void {
    this.length = 0;
    this.head = 0;
  }
}

/** The trails of all robots; of a crowd there is only that of the chosen one. */
export class Trails {
  all: Trail[] = [];

  /** For so many robots. */
  reset(robots: number): void {
    const capacity = Math.floor(ALL_POINTS / Math.max(1, robots));
    this.all = robots > 250 ? [] : Array.from({ length: robots }, () => new Trail(within(capacity)));
  }

  take(poses: Poses, radius_m: (robot: number) => number): void {
    this.all.forEach((trail, i) => trail.add(poses.x_m[i] ?? 0, poses.y_m[i] ?? 0, 0.15 * radius_m(i)));
  }
}

function within(capacity: number): number {
  return Math.min(MOST, Math.max(FEWEST, capacity));
}
