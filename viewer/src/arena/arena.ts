/** The canvas of the arena: when it is drawn, and what part of the world it shows. */
import { surface } from "../dom";
import { poseOf } from "../model/motion";
import type { Store } from "../model/store";
import { Painter } from "./painter";
import type { Theme } from "./palette";
import { isFlashing, robotAt } from "./robots";
import { FIRST_LAYERS, worldBounds, type Held, type Layers, type Look, type Scene } from "./scene";
import { fitted, panned, zoomed, type View } from "./view";

export class Arena {
  view: View = { x_m: 0, y_m: 0, scale: 100, width: 100, height: 100 };
  layers = FIRST_LAYERS;
  follows = false;
  held: Held | undefined;
  /** Frames drawn, for tests. */
  drawn = 0;
  /** Called when what the buttons show may have changed. */
  changed: () => void = () => {};
  private readonly painter = new Painter();
  private isAsked = false;
  private isFitted = false;
  /** All is shown, and is to be shown when the picture gets another size. */
  private isWhole = false;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly store: Store,
    private theme: Theme,
  ) {
    new ResizeObserver(() => this.resize()).observe(canvas);
    store.on("world", () => (this.isFitted = false));
    for (const event of ["world", "robot", "frame", "drawn"] as const) store.on(event, () => this.invalidate());
  }

  /** How it looks, for a film of it. */
  get look(): Look {
    return { theme: this.theme, layers: this.layers, follows: this.follows };
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.invalidate();
  }

  /** Draws soon. */
  invalidate(): void {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame(() => {
      this.isAsked = false;
      this.draw();
    });
  }

  /** Shows all there is. */
  fit(): void {
    const bounds = worldBounds(this.store);
    this.setFollows(false);
    if (bounds) this.view = fitted(this.view, bounds);
    this.isWhole = true;
    this.invalidate();
  }

  zoom(factor: number, x = this.view.width / 2, y = this.view.height / 2): void {
    this.isWhole = false;
    this.view = zoomed(this.view, factor, x, y);
    this.invalidate();
  }

  pan(dx: number, dy: number): void {
    this.setFollows(false);
    this.isWhole = false;
    this.view = panned(this.view, dx, dy);
    this.invalidate();
  }

  setFollows(on: boolean): void {
    if (this.follows === on) return;
    this.follows = on;
    this.isWhole = false;
    this.changed();
    this.invalidate();
  }

  toggle(layer: keyof Layers): void {
    this.layers = { ...this.layers, [layer]: !this.layers[layer] };
    this.changed();
    this.invalidate();
  }

  /** What is drawn at this moment. */
  scene(now_ms = performance.now()): Scene {
    const { view, store, theme, layers, held } = this;
    const context = surface(this.canvas, view.width, view.height);
    const { motion } = store;
    return {
      context,
      view,
      theme,
      store,
      layers,
      poses: motion.poses(now_ms),
      things: motion.things(now_ms),
      now_ms,
      held,
    };
  }

  /** Chooses the robot at a place of the picture. */
  pick(x: number, y: number): void {
    const found = robotAt(this.scene(), x, y, 12);
    const robot = this.store.description?.robots[found];
    if (robot) this.store.chooseRobot(robot.robot);
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.view = { ...this.view, width: clientWidth, height: clientHeight };
    if (this.store.frames === 0 || !this.store.frame) this.isFitted = false;
    else if (this.isWhole) this.fit();
    this.invalidate();
  }

  private draw(): void {
    const now_ms = performance.now();
    if (!this.isFitted && this.store.frame && this.canvas.clientWidth > 0) {
      this.isFitted = true;
      this.fit();
    }
    const poses = this.store.motion.poses(now_ms);
    const chosen = poses && poseOf(poses, this.store.robotIndex);
    if (this.follows && chosen) this.view = { ...this.view, x_m: chosen.x_m, y_m: chosen.y_m };
    const scene = this.scene(now_ms);
    this.painter.paint(scene);
    this.drawn++;
    if (!this.store.motion.settled(now_ms) || isFlashing(scene)) this.invalidate();
  }
}
