/** A canvas of its own on which the arena is drawn for a film: with the page's own painter, whatever the screen is. */
import { Painter } from "../arena/painter";
import { BOLD, label, worldBounds, type Look, type Scene } from "../arena/scene";
import { fitted, heightFor, type View } from "../arena/view";
import { poseOf } from "../model/motion";
import type { Store } from "../model/store";
import { fixed, secondsOf } from "../model/units";
import { even } from "./plan";

export class Stage {
  readonly canvas = document.createElement("canvas");
  private readonly context: CanvasRenderingContext2D;
  private readonly painter = new Painter();
  private begun_ms = 0;
  private time_s = 0;

  constructor(
    private readonly store: Store,
    private readonly look: Look,
    private readonly view: View,
  ) {
    [this.canvas.width, this.canvas.height] = [view.width, view.height];
    const context = this.canvas.getContext("2d", { willReadFrequently: true });
    if (!context) throw new Error("this browser cannot draw on a canvas");
    this.context = context;
  }

  /** Time is the film's from here on; what is returned ends that. */
  begin(ticks: readonly bigint[]): () => void {
    const { store } = this;
    const { clock } = store;
    this.begun_ms = clock();
    store.clock = () => this.now_ms;
    store.filmStride = ticks.reduce((most, tick, k) => Math.max(most, Number(tick - (ticks[k - 1] ?? tick))), 1);
    return () => {
      store.clock = clock;
      store.filmStride = 0;
    };
  }

  setTime(time_s: number): void {
    this.time_s = time_s;
  }

  draw(): void {
    const { store, view, look } = this;
    const { frame } = store;
    const pose = frame && poseOf(frame.poses, store.robotIndex);
    const scene: Scene = {
      context: this.context,
      view: look.follows && pose ? { ...view, x_m: pose.x_m, y_m: pose.y_m } : view,
      theme: look.theme,
      store,
      layers: look.layers,
      poses: frame?.poses,
      // Where the newest frame has them.
      things: store.motion.things(Infinity),
      now_ms: this.now_ms,
      held: undefined,
    };
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.painter.paint(scene);
    this.caption(scene);
  }

  private get now_ms(): number {
    return this.begun_ms + 1000 * this.time_s;
  }

  private caption(scene: Scene): void {
    const { frame, world } = this.store;
    this.context.font = BOLD;
    this.context.textAlign = "left";
    const time = fixed(secondsOf(frame?.timeNs ?? 0n), 2);
    label(scene, `${world}   ${time} s`, 50, 22, this.look.theme.ink);
  }
}

/** All there is, in a picture that is so wide, and as high as that needs. */
export function wholeView(store: Store, width: number): View {
  const bounds = worldBounds(store);
  const wide = even(width);
  const height = even(bounds ? Math.min(1.5 * wide, Math.max(0.3 * wide, heightFor(wide, bounds))) : 0.75 * wide);
  const view: View = { x_m: 0, y_m: 0, scale: 100, width: wide, height };
  return bounds ? fitted(view, bounds) : view;
}

/** What a view shows, in a picture that is so wide. */
export function scaledView(view: View, width: number): View {
  const wide = even(width);
  const factor = wide / view.width;
  return { ...view, scale: view.scale * factor, width: wide, height: even(view.height * factor) };
}
