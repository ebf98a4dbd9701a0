/** Trails of robots, as long as there is room. */
import type { Poses } from "../net/frames";

/** Points of all trails together: what can be drawn sixty times a second. */
const ALL_POINTS = 6000;
const FEWEST = 24;
const MOST = 900;

/** One way: the newest points of it. Each was there from one tick until another. */
export class Trail {
  private readonly places: Float32Array;
  private readonly ticks: Float64Array;
  private readonly jumps: Uint8Array;
  private head = 0;
  length = 0;
  private drawn: Path2D | undefined;

  constructor(readonly capacity: number) {
    this.places = new Float32Array(2 * capacity);
    this.ticks = new Float64Array(2 * capacity);
    this.jumps = new Uint8Array(capacity);
  }

  /** Takes a point, unless it is hardly away from the last one. After more than `longest` ticks the way is not known. */
  add(x_m: number, y_m: number, least_m: number, tick = 0, longest = Infinity): void {
    const last = this.place(this.length - 1);
    const isNear = this.length > 0 && this.away(last, x_m, y_m) < least_m;
    const isLost = this.length > 0 && tick - (this.ticks[2 * last + 1] ?? 0) > longest;
    if (isNear) return void (this.ticks[2 * last + 1] = tick);
    this.places.set([x_m, y_m], 2 * this.head);
    this.ticks.set([tick, tick], 2 * this.head);
    this.jumps[this.head] = Number(isLost);
    this.head = (this.head + 1) % this.capacity;
    this.length = Math.min(this.length + 1, this.capacity);
    this.drawn = undefined;
  }

  /** The way as it is drawn, in metres. It is kept until there is another point: pictures are more frequent than frames. */
  get path(): Path2D {
    this.drawn ??= this.draw();
    return this.drawn;
  }

  /** The i-th point, 0 being the oldest. */
  at(i: number): [number, number] {
    const place = this.place(i);
    return [this.places[2 * place] ?? 0, this.places[2 * place + 1] ?? 0];
  }

  /** Whether it is not known how it came to the i-th point. */
  isJump(i: number): boolean {
    return this.jumps[this.place(i)] === 1;
  }

  /** Takes away what is later than a tick. */
  cut(tick: number): void {
    while (this.length > 0 && (this.ticks[2 * this.place(this.length - 1)] ?? 0) > tick) {
      this.head = this.place(this.length - 1);
      this.length--;
      this.drawn = undefined;
    }
    const until = 2 * this.place(this.length - 1) + 1;
    if (this.length > 0) this.ticks[until] = Math.min(tick, this.ticks[until] ?? tick);
  }

  clear(): void {
    this.length = 0;
    this.head = 0;
    this.drawn = undefined;
  }

  private draw(): Path2D {
    const path = new Path2D();
    for (let i = 0; i < this.length; i++) {
      const place = this.place(i);
      const [x_m, y_m] = [this.places[2 * place] ?? 0, this.places[2 * place + 1] ?? 0];
      if (this.jumps[place] === 1) path.moveTo(x_m, y_m);
      else path.lineTo(x_m, y_m);
    }
    return path;
  }

  private place(i: number): number {
    return (this.head - this.length + i + this.capacity) % this.capacity;
  }

  private away(place: number, x_m: number, y_m: number): number {
    return Math.hypot(x_m - (this.places[2 * place] ?? 0), y_m - (this.places[2 * place + 1] ?? 0));
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

  take(poses: Poses, radius_m: (robot: number) => number, tick: number, longest: number): void {
    this.all.forEach((trail, i) => {
      trail.add(poses.x_m[i] ?? 0, poses.y_m[i] ?? 0, 0.15 * radius_m(i), tick, longest);
    });
  }

  cut(tick: number): void {
    for (const trail of this.all) trail.cut(tick);
  }
}

function within(capacity: number): number {
  return Math.min(MOST, Math.max(FEWEST, capacity));
}
