/** From the world to the picture and back: metres, y upwards, to CSS pixels, y downwards. */

/** What a picture shows. */
export interface View {
  /** Where the middle of the picture is in the world. */
  x_m: number;
  y_m: number;
  /** Pixels a metre. */
  scale: number;
  /** Size of the picture in pixels. */
  width: number;
  height: number;
}

/** A box in the world. */
export interface Bounds {
  min_x_m: number;
  min_y_m: number;
  max_x_m: number;
  max_y_m: number;
}

const LEAST_SCALE = 0.05;
const MOST_SCALE = 50_000;

export function toPixel(view: View, x_m: number, y_m: number): [number, number] {
  return [view.width / 2 + (x_m - view.x_m) * view.scale, view.height / 2 - (y_m - view.y_m) * view.scale];
}

export function toWorld(view: View, x: number, y: number): [number, number] {
  return [view.x_m + (x - view.width / 2) / view.scale, view.y_m - (y - view.height / 2) / view.scale];
}

/** Larger or smaller about a place of the picture, which stays where it is. */
export function zoomed(view: View, factor: number, x: number, y: number): View {
  const scale = Math.min(MOST_SCALE, Math.max(LEAST_SCALE, view.scale * factor));
  const [x_m, y_m] = toWorld(view, x, y);
  return {
    ...view,
    scale,
    x_m: x_m - (x - view.width / 2) / scale,
    y_m: y_m + (y - view.height / 2) / scale,
  };
}

/** Moved by so many pixels. */
export function panned(view: View, dx: number, dy: number): View {
  return { ...view, x_m: view.x_m - dx / view.scale, y_m: view.y_m + dy / view.scale };
}

/** What the axes and the buttons take. */
const ROOM = { left: 46, right: 18, top: 44, bottom: 52 };

/** How high a picture is that is so wide and shows nothing but a box, and the axes. */
export function heightFor(width: number, bounds: Bounds): number {
  const across = Math.max(20, width - ROOM.left - ROOM.right) / Math.max(bounds.max_x_m - bounds.min_x_m, 1e-3);
  return ROOM.top + ROOM.bottom + across * (bounds.max_y_m - bounds.min_y_m);
}

/** Shows all of a box, with room for the axes. */
export function fitted(view: View, bounds: Bounds): View {
  const [wide_m, high_m] = [bounds.max_x_m - bounds.min_x_m, bounds.max_y_m - bounds.min_y_m];
  const across = Math.max(20, view.width - ROOM.left - ROOM.right) / Math.max(wide_m, 1e-3);
  const up = Math.max(20, view.height - ROOM.top - ROOM.bottom) / Math.max(high_m, 1e-3);
  const scale = Math.min(MOST_SCALE, Math.max(LEAST_SCALE, Math.min(across, up)));
  return {
    ...view,
    scale,
    x_m: (bounds.min_x_m + bounds.max_x_m) / 2 - (ROOM.left - ROOM.right) / 2 / scale,
    y_m: (bounds.min_y_m + bounds.max_y_m) / 2 - (ROOM.bottom - ROOM.top) / 2 / scale,
  };
}

/** The box around points; undefined if there are none. */
export function boundsOf(points: Iterable<{ x_m: number; y_m: number; radius_m?: number }>): Bounds | undefined {
  const bounds = { min_x_m: Infinity, min_y_m: Infinity, max_x_m: -Infinity, max_y_m: -Infinity };
  for (const { x_m, y_m, radius_m = 0 } of points) {
    bounds.min_x_m = Math.min(bounds.min_x_m, x_m - radius_m);
    bounds.min_y_m = Math.min(bounds.min_y_m, y_m - radius_m);
    bounds.max_x_m = Math.max(bounds.max_x_m, x_m + radius_m);
    bounds.max_y_m = Math.max(bounds.max_y_m, y_m + radius_m);
  }
  return Number.isFinite(bounds.min_x_m) && Number.isFinite(bounds.max_y_m) ? bounds : undefined;
}

/** Draws in metres from here on, whatever the device's pixels are. */
export function useMetres(context: CanvasRenderingContext2D, view: View): void {
  const ratio = context.getTransform().a;
  const scale = ratio * view.scale;
  const [x, y] = toPixel(view, 0, 0);
  context.setTransform(scale, 0, 0, -scale, ratio * x, ratio * y);
}
