/** What stands still, drawn once for each view: floor, grid, zones, coverage, fields, walls, lamps. */
import type {
  DescribeWorldResponse,
  GetCoverageResponse,
  Outline,
  Polygon,
  ScalarField,
  Zone,
} from "../gen/baudbot/v1/observe_pb";
import { roundStep } from "../model/units";
import { CoveragePicture } from "./coverage";
import { blinks, drawLight } from "./lamps";
import { FIELDS, floorColor, HOLLOW, rgb, solidColors, uses, withAlpha, type Theme } from "./palette";
import { FONT, label } from "./scene";
import { toPixel, toWorld, useMetres, type Bounds, type View } from "./view";

type Context = CanvasRenderingContext2D;

/** Solid and hollow things of the same colours in one path: a plan of a building has thousands of them. */
interface Batch {
  fill: string | undefined;
  line: string;
  dashed: boolean;
  /** Some sensors see under it. */
  raised: boolean;
  path: Path2D;
}

/** The ground of one world in one theme. */
export class Ground {
  private readonly batches: Batch[];
  private readonly shades: { image: HTMLCanvasElement; bounds: Bounds }[];
  private readonly coverage: CoveragePicture;

  constructor(
    private readonly description: DescribeWorldResponse,
    private readonly theme: Theme,
    bounds: Bounds | undefined,
  ) {
    this.batches = batchesOf(description, theme);
    this.coverage = new CoveragePicture(theme);
    this.shades = bounds ? description.fields.map((field, i) => ({ image: shade(field, i, bounds), bounds })) : [];
  }

  draw(context: Context, view: View, withFields: boolean, map: GetCoverageResponse | undefined): void {
    context.fillStyle = this.theme.floor;
    context.fillRect(0, 0, view.width, view.height);
    for (const zone of this.description.zones) drawZone(context, view, this.theme, zone);
    if (map) this.coverage.draw(context, view, map);
    if (withFields) for (const shade of this.shades) drawShade(context, view, shade);
    drawGrid(context, view, this.theme);
    for (const light of this.description.lights) if (!blinks(light)) drawLight(context, view, light);
    this.drawWalls(context, view);
    context.font = FONT;
    context.textAlign = "center";
    for (const zone of this.description.zones) nameZone(context, view, this.theme, zone);
  }

  private drawWalls(context: Context, view: View): void {
    context.save();
    useMetres(context, view);
    context.lineJoin = "round";
    context.lineCap = "round";
    for (const batch of this.batches) {
      context.strokeStyle = batch.line;
      context.lineWidth = (batch.fill ? 1 : 2.5) / view.scale;
      context.setLineDash(batch.dashed ? [5 / view.scale, 3 / view.scale] : []);
      if (batch.fill) {
        context.fillStyle = batch.fill;
        context.globalAlpha = batch.raised ? 0.45 : 1;
        context.fill(batch.path);
        context.globalAlpha = 1;
      }
      context.stroke(batch.path);
    }
    context.restore();
  }
}

function batchesOf(description: DescribeWorldResponse, theme: Theme): Batch[] {
  const batches = new Map<string, Batch>();
  const path = (thing: Polygon | { look?: Polygon["look"]; solid: boolean }): Path2D => {
    const { fill, rim } = solidColors(thing.look, theme, false);
    const dashed = thing.look?.heightM !== undefined;
    const raised = (thing.look?.lowerEdgeM ?? 0) > 0;
    const key = `${fill} ${rim} ${dashed} ${raised} ${thing.solid}`;
    const known = batches.get(key);
    if (known) return known.path;
    const [inside, line] = thing.solid ? [fill, rim] : [undefined, fill];
    const made = { fill: inside, line, dashed, raised, path: new Path2D() };
    batches.set(key, made);
    return made.path;
  };
  for (const polygon of description.polygons) trace(path(polygon), polygon.points, polygon.closed || polygon.solid);
  for (const disc of description.circles) {
    const [x, y] = [disc.center?.xM ?? 0, disc.center?.yM ?? 0];
    const to = path({ look: disc.look, solid: true });
    to.moveTo(x + disc.radiusM, y);
    to.arc(x, y, disc.radiusM, 0, 2 * Math.PI);
  }
  return [...batches.values()];
}

/** Corners, as they are given, onto a path. */
export function trace(path: Path2D | Context, points: { xM: number; yM: number }[], closed: boolean): void {
  points.forEach((point, i) => (i === 0 ? path.moveTo(point.xM, point.yM) : path.lineTo(point.xM, point.yM)));
  if (closed && points.length > 0) path.closePath();
}

/** A polygon or a disc, as it is given, onto a path. */
export function traceOutline(path: Path2D | Context, outline: Outline | undefined): void {
  if (!outline) return;
  if (outline.points.length > 0) return trace(path, outline.points, true);
  const [x, y] = [outline.center?.xM ?? 0, outline.center?.yM ?? 0];
  path.moveTo(x + outline.radiusM, y);
  path.arc(x, y, outline.radiusM, 0, 2 * Math.PI);
}

/** Metres between lines of the grid. */
export function gridStep(view: View): number {
  return roundStep(56 / view.scale);
}

function drawGrid(context: Context, view: View, theme: Theme): void {
  const step_m = gridStep(view);
  const [left_m, top_m] = toWorld(view, 0, 0);
  const [right_m, bottom_m] = toWorld(view, view.width, view.height);
  context.lineWidth = 1;
  for (const strong of [false, true]) {
    context.beginPath();
    for (let i = Math.ceil(left_m / step_m); i * step_m <= right_m; i++) {
      if ((i % 5 === 0) !== strong) continue;
      const x = Math.round(toPixel(view, i * step_m, 0)[0]) + 0.5;
      context.moveTo(x, 0);
      context.lineTo(x, view.height);
    }
    for (let i = Math.ceil(bottom_m / step_m); i * step_m <= top_m; i++) {
      if ((i % 5 === 0) !== strong) continue;
      const y = Math.round(toPixel(view, 0, i * step_m)[1]) + 0.5;
      context.moveTo(0, y);
      context.lineTo(view.width, y);
    }
    context.strokeStyle = strong ? theme.gridStrong : theme.grid;
    context.stroke();
  }
}

function drawZone(context: Context, view: View, theme: Theme, zone: Zone): void {
  const { hue, words } = uses(zone);
  context.save();
  useMetres(context, view);
  const path = new Path2D();
  traceOutline(path, zone.outline);
  if (zone.floor !== undefined) {
    context.fillStyle = floorColor(zone.floor, theme);
    context.fill(path);
  }
  // A zone that is nothing but a floor of another grey is drawn as that.
  if (words.length > Number(zone.floor !== undefined) || zone.floor === undefined) {
    context.fillStyle = withAlpha(hue, theme.dark ? 0.16 : 0.1);
    context.fill(path);
    hatch(context, view, path, hue);
    context.strokeStyle = hue;
    context.lineWidth = 1.2 / view.scale;
    context.stroke(path);
  }
  context.restore();
}

/** Slanting lines, which stay where they are in the world when the view moves. */
function hatch(context: Context, view: View, path: Path2D, hue: string): void {
  context.save();
  context.clip(path);
  const [left_m, bottom_m] = toWorld(view, 0, view.height);
  const [right_m, top_m] = toWorld(view, view.width, 0);
  const step_m = roundStep(10 / view.scale);
  const high_m = top_m - bottom_m;
  context.beginPath();
  const first = Math.floor((left_m - bottom_m - high_m) / step_m);
  for (let i = first; i * step_m < right_m - bottom_m; i++) {
    context.moveTo(i * step_m + bottom_m, bottom_m);
    context.lineTo(i * step_m + bottom_m + high_m, top_m);
  }
  context.strokeStyle = withAlpha(hue, 0.35);
  context.lineWidth = 1.4 / view.scale;
  context.stroke();
  context.restore();
}

function nameZone(context: Context, view: View, theme: Theme, zone: Zone): void {
  const { words } = uses(zone);
  const points = zone.outline?.points ?? [];
  const middle = (pick: (point: { xM: number; yM: number }) => number) =>
    points.reduce((sum, point) => sum + pick(point), 0) / points.length;
  const center = zone.outline?.center;
  const x_m = points.length > 0 ? middle((point) => point.xM) : (center?.xM ?? 0);
  const y_m = points.length > 0 ? middle((point) => point.yM) : (center?.yM ?? 0);
  const [x, y] = toPixel(view, x_m, y_m);
  const text = words.length > 0 && words.join() !== zone.zone ? `${zone.zone}: ${words.join(", ")}` : zone.zone;
  label({ context, theme }, text, x, y + 4, theme.paleInk);
}

const SHADE_PX = 160;

/** A field's values as an opacity, over the whole arena and a little beyond. */
function shade(field: ScalarField, index: number, bounds: Bounds): HTMLCanvasElement {
  const image = document.createElement("canvas");
  image.width = image.height = SHADE_PX;
  const context = image.getContext("2d");
  if (!context) return image;
  const values = new Float64Array(SHADE_PX * SHADE_PX);
  let largest = 1e-12;
  for (let i = 0; i < values.length; i++) {
    const share = { x: ((i % SHADE_PX) + 0.5) / SHADE_PX, y: (Math.floor(i / SHADE_PX) + 0.5) / SHADE_PX };
    const x_m = bounds.min_x_m + share.x * (bounds.max_x_m - bounds.min_x_m);
    const y_m = bounds.max_y_m - share.y * (bounds.max_y_m - bounds.min_y_m);
    values[i] = strength(field, x_m, y_m);
    largest = Math.max(largest, Math.abs(values[i] ?? 0));
  }
  const [up, down] = [rgb(FIELDS[index % FIELDS.length] ?? HOLLOW), rgb(HOLLOW)];
  const pixels = context.createImageData(SHADE_PX, SHADE_PX);
  values.forEach((value, i) => {
    pixels.data.set([...(value < 0 ? down : up), Math.round((130 * Math.abs(value)) / largest)], 4 * i);
  });
  context.putImageData(pixels, 0, 0);
  return image;
}

/** A field's value over its background. */
function strength(field: ScalarField, x_m: number, y_m: number): number {
  return field.sources.reduce(
    (sum, { position, strength, widthM }) => {
      const distance_m = Math.hypot(x_m - (position?.xM ?? 0), y_m - (position?.yM ?? 0)) / widthM;
      return sum + strength * Math.exp(-0.5 * distance_m * distance_m);
    },
    field.slopeXPerM * x_m + field.slopeYPerM * y_m,
  );
}

function drawShade(
  context: Context,
  view: View,
  { image, bounds }: { image: HTMLCanvasElement; bounds: Bounds },
): void {
  const [left, top] = toPixel(view, bounds.min_x_m, bounds.max_y_m);
  const [right, bottom] = toPixel(view, bounds.max_x_m, bounds.min_y_m);
  context.imageSmoothingEnabled = true;
  context.drawImage(image, left, top, right - left, bottom - top);
}
