/** What the layers of the arena are drawn from. */
import type { Pose } from "../model/pose";
import type { Store } from "../model/store";
import type { Poses } from "../net/frames";
import type { Theme } from "./palette";
import { boundsOf, toPixel, type Bounds, type View } from "./view";

/** Which layers people want to see. */
export interface Layers {
  rays: boolean;
  trails: boolean;
  ghost: boolean;
  belief: boolean;
  /** Not the chosen robot's alone. */
  allBeliefs: boolean;
  names: boolean;
  fields: boolean;
  /** Cells of the floor that are covered and sensed. */
  coverage: boolean;
}

/** What is shown until somebody wants something else. */
export const FIRST_LAYERS: Layers = {
  rays: true,
  trails: true,
  ghost: true,
  belief: true,
  allBeliefs: false,
  names: true,
  fields: true,
  coverage: true,
};

/** What the arena looks like, whatever it shows. */
export interface Look {
  theme: Theme;
  layers: Layers;
  /** The chosen robot stays in the middle. */
  follows: boolean;
}

/** Something that is being moved by hand, where it would be put down. */
export interface Held {
  kind: "robot" | "thing";
  index: number;
  pose: Pose;
}

/** One picture. */
export interface Scene {
  context: CanvasRenderingContext2D;
  view: View;
  theme: Theme;
  store: Store;
  layers: Layers;
  poses: Poses | undefined;
  things: Pose[];
  now_ms: number;
  held: Held | undefined;
}

/** Text that reads on anything. */
export function label(
  scene: Pick<Scene, "context" | "theme">,
  text: string,
  x: number,
  y: number,
  color: string,
): void {
  const { context, theme } = scene;
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = theme.halo;
  context.strokeText(text, x, y);
  context.fillStyle = color;
  context.fillText(text, x, y);
}

export const FONT = "11px system-ui, sans-serif";
export const BOLD = "600 12px system-ui, sans-serif";

/** Whether something round is in the picture at all. */
export function isShown(view: View, x_m: number, y_m: number, radius_m: number): boolean {
  const [x, y] = toPixel(view, x_m, y_m);
  const reach = radius_m * view.scale + 4;
  return x > -reach && y > -reach && x < view.width + reach && y < view.height + reach;
}

/** The box around all that there is in a world. */
export function worldBounds(store: Store): Bounds | undefined {
  const { description, frame } = store;
  if (!description) return undefined;
  const points: { x_m: number; y_m: number; radius_m?: number }[] = [];
  const add = (point: { xM: number; yM: number } | undefined, radius_m = 0) =>
    point && points.push({ x_m: point.xM, y_m: point.yM, radius_m });
  for (const polygon of description.polygons) for (const point of polygon.points) add(point);
  for (const disc of description.circles) add(disc.center, disc.radiusM);
  for (const zone of description.zones) {
    add(zone.outline?.center, zone.outline?.radiusM);
    for (const point of zone.outline?.points ?? []) add(point);
  }
  const poses = frame?.poses;
  for (let i = 0; i < (poses?.count ?? 0); i++) {
    const radius_m = 2 * (description.robots[i]?.radiusM ?? 0);
    points.push({ x_m: poses?.x_m[i] ?? 0, y_m: poses?.y_m[i] ?? 0, radius_m });
  }
  return boundsOf(points);
}
