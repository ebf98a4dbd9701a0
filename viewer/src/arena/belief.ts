/** What brains say that they believe, all in one colour: none of it need be true. */
import type { Belief, BelievedPose, GridMap } from "../gen/baudbot/v1/brain_link_pb";
import { rgb, withAlpha, type Theme } from "./palette";
import { traceBody } from "./robots";
import { BOLD, label, type Scene } from "./scene";
import { toPixel, useMetres } from "./view";
import { brief } from "../model/units";

const UNKNOWN = 255;
const OCCUPIED = 254;

/** Pictures of maps, as long as somebody has the map. */
const pictures = new WeakMap<GridMap, { dark: boolean; image: HTMLCanvasElement }>();

/** The map, which lies under all that moves. */
export function drawBeliefMap(scene: Scene, belief: Belief): void {
  const map = belief.map;
  if (!map || map.columns === 0) return;
  const { context, view, theme } = scene;
  const rows = Math.floor(map.cells.length / map.columns);
  if (rows === 0) return;
  const [left, bottom] = toPixel(view, map.xM, map.yM);
  const [wide, high] = [map.columns * map.cellM * view.scale, rows * map.cellM * view.scale];
  context.imageSmoothingEnabled = false;
  context.drawImage(picture(map, rows, theme), left, bottom - high, wide, high);
  context.imageSmoothingEnabled = true;
  context.strokeStyle = withAlpha(theme.belief, 0.5);
  context.lineWidth = 1;
  context.setLineDash([2, 3]);
  context.strokeRect(left, bottom - high, wide, high);
  context.setLineDash([]);
}

function picture(map: GridMap, rows: number, theme: Theme): HTMLCanvasElement {
  const known = pictures.get(map);
  if (known && known.dark === theme.dark) return known.image;
  const image = document.createElement("canvas");
  image.width = map.columns;
  image.height = rows;
  const context = image.getContext("2d");
  if (!context) return image;
  const pixels = context.createImageData(map.columns, rows);
  const [red, green, blue] = rgb(theme.belief);
  for (let i = 0; i < map.columns * rows; i++) {
    const cell = map.cells[i] ?? UNKNOWN;
    // Rows come from below, pixels from above.
    const at = 4 * ((rows - 1 - Math.floor(i / map.columns)) * map.columns + (i % map.columns));
    if (cell === UNKNOWN) pixels.data.set([128, 134, 146, 44], at);
    else pixels.data.set([red, green, blue, Math.round((115 * cell) / OCCUPIED)], at);
  }
  context.putImageData(pixels, 0, 0);
  pictures.set(map, { dark: theme.dark, image });
  return image;
}

/** All but the map. */
export function drawBelief(scene: Scene, robot: number, belief: Belief): void {
  drawParticles(scene, belief);
  drawPath(scene, belief);
  if (belief.pose) drawPose(scene, robot, belief.pose, belief.state);
}

function drawParticles(scene: Scene, belief: Belief): void {
  const { context, view, theme } = scene;
  const heaviest = belief.particles.reduce((most, particle) => Math.max(most, particle.weight), 0);
  const marks = belief.particles.map((particle) => ({
    at: toPixel(view, particle.xM, particle.yM),
    heading: particle.headingRad,
    level: heaviest > 0 ? Math.round(2 * (particle.weight / heaviest)) : 2,
  }));
  // Three levels of weight, so that there are three paths to draw however many particles there are.
  for (const level of [0, 1, 2]) {
    context.beginPath();
    for (const { at, heading } of marks.filter((mark) => mark.level === level)) {
      context.moveTo(at[0] + 1.3, at[1]);
      context.arc(at[0], at[1], 1.3, 0, 2 * Math.PI);
      context.moveTo(...at);
      context.lineTo(at[0] + 7 * Math.cos(heading), at[1] - 7 * Math.sin(heading));
    }
    context.strokeStyle = withAlpha(theme.belief, 0.25 + 0.25 * level);
    context.lineWidth = 1;
    context.stroke();
  }
}

function drawPath(scene: Scene, belief: Belief): void {
  const { context, view, theme } = scene;
  if (belief.path.length < 2) return;
  context.beginPath();
  for (const point of belief.path) context.lineTo(...toPixel(view, point.xM, point.yM));
  context.strokeStyle = theme.belief;
  context.lineWidth = 2;
  context.lineJoin = "round";
  context.setLineDash([7, 4]);
  context.stroke();
  context.setLineDash([]);
  const end = belief.path[belief.path.length - 1];
  if (!end) return;
  const [x, y] = toPixel(view, end.xM, end.yM);
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.fillStyle = theme.belief;
  context.fill();
}

function drawPose(scene: Scene, index: number, pose: BelievedPose, state: string): void {
  const { context, view, theme, store } = scene;
  const robot = store.description?.robots[index];
  if (!robot) return;
  drawEllipse(scene, pose);
  context.save();
  useMetres(context, view);
  context.translate(pose.xM, pose.yM);
  context.rotate(pose.headingRad);
  context.beginPath();
  traceBody(context, robot);
  context.moveTo(0, 0);
  context.lineTo(1.25 * robot.radiusM, 0);
  context.strokeStyle = theme.belief;
  context.lineWidth = 1.8 / view.scale;
  context.stroke();
  context.restore();
  const [x, y] = toPixel(view, pose.xM, pose.yM);
  context.font = BOLD;
  context.textAlign = "center";
  const below = Math.max(4, robot.radiusM * view.scale) + 18;
  label(scene, state === "" ? "belief" : `belief: ${brief(state, 40)}`, x, y + below, theme.belief);
}

/** Where it believes to be with 95 of 100: two standard deviations and a half, 2.45. */
function drawEllipse(scene: Scene, pose: BelievedPose): void {
  const [xx, xy, yy] = pose.covarianceM2;
  if (xx === undefined || xy === undefined || yy === undefined) return;
  const { context, view, theme } = scene;
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  const axis = (variance: number) => 2.45 * Math.sqrt(Math.max(0, variance)) * view.scale;
  const [x, y] = toPixel(view, pose.xM, pose.yM);
  context.beginPath();
  context.ellipse(x, y, axis(mean + spread), axis(mean - spread), -0.5 * Math.atan2(2 * xy, xx - yy), 0, 2 * Math.PI);
  context.fillStyle = withAlpha(theme.belief, 0.12);
  context.fill();
  context.strokeStyle = withAlpha(theme.belief, 0.7);
  context.lineWidth = 1;
  context.stroke();
}
