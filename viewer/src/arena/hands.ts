/** Mouse, pen and fingers on the arena: they pan, pinch, pick, and in the mode for it carry robots and things. */
import type { Held } from "./scene";
import type { Arena } from "./arena";
import { robotAt } from "./robots";
import { movableAt } from "./things";
import { poseOf } from "../model/motion";
import { toWorld } from "./view";

/** A pointer that moves less than this, in pixels, clicks. */
const CLICK = 6;

interface Point {
  x: number;
  y: number;
}

export class Hands {
  /** Whether robots and things are carried. */
  moves = false;
  private readonly pointers = new Map<number, Point>();
  private travelled = 0;
  /** From the hand to the middle of what it holds, in metres. */
  private grip = { x_m: 0, y_m: 0 };

  constructor(
    private readonly arena: Arena,
    /** Called when something is put down elsewhere. */
    private readonly put: (held: Held) => void,
  ) {
    const { canvas } = arena;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event, true));
    canvas.addEventListener("pointercancel", (event) => this.up(event, false));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  /** Turns what is held. */
  turn(angle_rad: number): boolean {
    const { held } = this.arena;
    if (!held) return false;
    held.pose = { ...held.pose, heading_rad: held.pose.heading_rad + angle_rad };
    this.arena.invalidate();
    return true;
  }

  /** Lets go without putting it down. */
  drop(): void {
    this.arena.held = undefined;
    this.arena.invalidate();
  }

  private at(event: MouseEvent): Point {
    const box = this.arena.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private down(event: PointerEvent): void {
    const point = this.at(event);
    this.arena.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, point);
    if (this.pointers.size === 1) {
      this.travelled = 0;
      if (this.moves) this.grab(point);
    }
  }

  private grab({ x, y }: Point): void {
    const { arena } = this;
    const scene = arena.scene();
    const robot = robotAt(scene, x, y, 10);
    const thing = robot < 0 ? movableAt(scene, x, y) : -1;
    const pose = robot >= 0 ? scene.poses && poseOf(scene.poses, robot) : scene.things[thing];
    if (!pose) return;
    const [x_m, y_m] = toWorld(arena.view, x, y);
    this.grip = { x_m: pose.x_m - x_m, y_m: pose.y_m - y_m };
    arena.held = { kind: robot >= 0 ? "robot" : "thing", index: robot >= 0 ? robot : thing, pose: { ...pose } };
    arena.setFollows(false);
    arena.invalidate();
  }

  private move(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const point = this.at(event);
    this.pointers.set(event.pointerId, point);
    this.travelled += Math.hypot(point.x - before.x, point.y - before.y);
    if (this.arena.held) this.carry(point);
    else if (this.pointers.size === 2) this.pinch(event.pointerId, before, point);
    else if (this.travelled > CLICK) this.arena.pan(point.x - before.x, point.y - before.y);
  }

  private carry(point: Point): void {
    const { held, view } = this.arena;
    if (!held) return;
    const [x_m, y_m] = toWorld(view, point.x, point.y);
    held.pose = { ...held.pose, x_m: x_m + this.grip.x_m, y_m: y_m + this.grip.y_m };
    this.arena.invalidate();
  }

  /** Two fingers: the world stays under both, but for turning. */
  private pinch(moved: number, before: Point, now: Point): void {
    const other = [...this.pointers].find(([id]) => id !== moved)?.[1];
    if (!other) return;
    const factor =
      Math.hypot(now.x - other.x, now.y - other.y) / Math.max(1, Math.hypot(before.x - other.x, before.y - other.y));
    if (!this.arena.follows) this.arena.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
    this.arena.zoom(factor, (now.x + other.x) / 2, (now.y + other.y) / 2);
  }

  private up(event: PointerEvent, isDone: boolean): void {
    const point = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (!point) return;
    const { held } = this.arena;
    const isClick = this.travelled <= CLICK;
    if (held) {
      if (isDone && !isClick) this.put(held);
      this.drop();
    }
    if (isDone && isClick && this.pointers.size === 0) this.arena.pick(point.x, point.y);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    if (this.turn(-Math.sign(event.deltaY) * (Math.PI / 12))) return;
    const lines = event.deltaMode === 1 ? 16 : 1;
    const { x, y } = this.at(event);
    const factor = Math.exp(-0.0015 * event.deltaY * lines * (event.ctrlKey ? 4 : 1));
    if (this.arena.follows) this.arena.zoom(factor);
    else this.arena.zoom(factor, x, y);
  }
}
