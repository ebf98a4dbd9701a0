/**
 * Poses between two frames, so that what moves does so smoothly. What is drawn is up to one frame behind; the time that
 * the page shows is that of the newest frame.
 */
import type { Frame, Poses } from "../net/frames";
import { wrapped, type Pose } from "./pose";

/** A frame that comes later than this is jumped to within this. */
const LONGEST_MS = 150;
/** Share of a new interval in the mean of the intervals. */
const SMOOTHING = 0.2;

export class Motion {
  private from: Poses | undefined;
  private to: Poses | undefined;
  private arrived_ms = 0;
  private interval_ms = 50;
  private shown: Poses | undefined;
  private thingsFrom: Pose[] = [];
  private thingsTo: Pose[] = [];

  take(frame: Frame, now_ms: number): void {
    const gap_ms = now_ms - this.arrived_ms;
    this.from = this.to && this.to.count === frame.poses.count ? this.poses(now_ms) : undefined;
    if (this.from) this.from = copied(this.from);
    this.thingsFrom = this.things(now_ms);
    this.to = frame.poses;
    this.thingsTo = frame.rest.things.map((thing) => ({ x_m: thing.xM, y_m: thing.yM, heading_rad: thing.headingRad }));
    this.interval_ms += SMOOTHING * (Math.min(gap_ms, LONGEST_MS) - this.interval_ms);
    this.arrived_ms = now_ms;
  }

  /** How far it is from the frame before to the newest: 0 to 1. */
  share(now_ms: number): number {
    if (!this.from) return 1;
    return Math.min(1, Math.max(0, (now_ms - this.arrived_ms) / Math.max(1, this.interval_ms)));
  }

  /** Whether all is where the newest frame has it. */
  settled(now_ms: number): boolean {
    return this.share(now_ms) >= 1;
  }

  /** All robots as they are drawn. */
  poses(now_ms: number): Poses | undefined {
    const { from, to } = this;
    const share = this.share(now_ms);
    if (!from || !to || share >= 1) return to;
    const shown = this.shown?.count === to.count ? this.shown : copied(to);
    this.shown = shown;
    for (let i = 0; i < to.count; i++) {
      const [x, y, heading] = [to.x_m[i] ?? 0, to.y_m[i] ?? 0, to.heading_rad[i] ?? 0];
      const [x0, y0, heading0] = [from.x_m[i] ?? 0, from.y_m[i] ?? 0, from.heading_rad[i] ?? 0];
      shown.x_m[i] = x0 + share * (x - x0);
      shown.y_m[i] = y0 + share * (y - y0);
      shown.heading_rad[i] = heading0 + share * wrapped(heading - heading0);
    }
    shown.collided = to.collided;
    return shown;
  }

  /** One robot as it is drawn. */
  pose(robot: number, now_ms: number): Pose | undefined {
    const poses = this.poses(now_ms);
    return poses && poseOf(poses, robot);
  }

  /** All things as they are drawn. A thing that turns is not wrapped, so its heading can be taken as it is. */
  things(now_ms: number): Pose[] {
    const share = this.share(now_ms);
    return this.thingsTo.map((to, i) => {
      const from = this.thingsFrom[i] ?? to;
      const mix = (a: number, b: number) => a + share * (b - a);
      return {
        x_m: mix(from.x_m, to.x_m),
        y_m: mix(from.y_m, to.y_m),
        heading_rad: mix(from.heading_rad, to.heading_rad),
      };
    });
  }

  reset(): void {
    this.from = this.to = this.shown = undefined;
    this.thingsFrom = this.thingsTo = [];
  }
}

/** A robot's pose among all. */
export function poseOf(poses: Poses, robot: number): Pose | undefined {
  const [x_m, y_m, heading_rad] = [poses.x_m[robot], poses.y_m[robot], poses.heading_rad[robot]];
  return x_m === undefined || y_m === undefined || heading_rad === undefined ? undefined : { x_m, y_m, heading_rad };
}

function copied(poses: Poses): Poses {
  return { ...poses, x_m: poses.x_m.slice(), y_m: poses.y_m.slice(), heading_rad: poses.heading_rad.slice() };
}
