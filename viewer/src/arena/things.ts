/** What moves by itself and what is pushed; the dead reckoning; what is held in the hand. */
import type { ObservedThing } from "../gen/baudbot/v1/observe_pb";
import { outOf, type Pose } from "../model/pose";
import { MOVER, solidColors, withAlpha } from "./palette";
import { drawBody, traceBody } from "./robots";
import { FONT, label, type Scene } from "./scene";
import { traceOutline } from "./ground";
import { toPixel, useMetres } from "./view";

export function drawThings(scene: Scene): void {
  scene.store.description?.things.forEach((thing, i) => drawThing(scene, thing, scene.things[i], 1));
}

function drawThing(scene: Scene, thing: ObservedThing, pose: Pose | undefined, alpha: number): void {
  if (!pose) return;
  const { context, view, theme } = scene;
  const { fill, rim } = solidColors(thing.look, theme, thing.movable);
  context.save();
  useMetres(context, view);
  context.translate(pose.x_m, pose.y_m);
  context.rotate(pose.heading_rad);
  context.beginPath();
  traceOutline(context, thing.outline);
  context.globalAlpha = alpha;
  context.fillStyle = fill;
  context.fill();
  context.strokeStyle = thing.movable ? rim : MOVER;
  context.lineWidth = (thing.movable ? 1.2 : 2) / view.scale;
  context.stroke();
  context.restore();
}

/** The thing at a place of the picture that can be moved by hand, the topmost; -1 if there is none. */
export function movableAt(scene: Scene, x: number, y: number): number {
  const { context, view } = scene;
  const things = scene.store.description?.things ?? [];
  for (let i = things.length - 1; i >= 0; i--) {
    const [thing, pose] = [things[i], scene.things[i]];
    if (!thing?.movable || !pose) continue;
    const path = new Path2D();
    const at = (x_m: number, y_m: number): [number, number] => {
      const point = outOf(pose, x_m, y_m);
      return toPixel(view, point.x_m, point.y_m);
    };
    const points = thing.outline?.points ?? [];
    for (const point of points) path.lineTo(...at(point.xM, point.yM));
    const center = at(thing.outline?.center?.xM ?? 0, thing.outline?.center?.yM ?? 0);
    if (points.length === 0) path.arc(...center, (thing.outline?.radiusM ?? 0) * view.scale, 0, 2 * Math.PI);
    const ratio = context.getTransform().a;
    if (context.isPointInPath(path, x * ratio, y * ratio)) return i;
  }
  return -1;
}

/** Where the robot would believe itself to be if it had nothing but its wheels. */
export function drawGhost(scene: Scene): void {
  const { context, view, theme, store } = scene;
  const pose = store.record?.ghost?.pose;
  const robot = store.description?.robots[store.robotIndex];
  if (!pose || !robot) return;
  const trail = store.record?.ghostTrail;
  context.beginPath();
  for (let i = 0; trail && i < trail.length; i++) {
    const [x, y] = toPixel(view, ...trail.at(i));
    if (trail.isJump(i)) context.moveTo(x, y);
    else context.lineTo(x, y);
  }
  context.strokeStyle = withAlpha(theme.ghost, 0.5);
  context.lineWidth = 1;
  context.setLineDash([3, 3]);
  context.stroke();
  context.setLineDash([]);
  context.save();
  useMetres(context, view);
  context.translate(pose.x_m, pose.y_m);
  context.rotate(pose.heading_rad);
  context.beginPath();
  traceBody(context, robot);
  context.moveTo(0, 0);
  context.lineTo(robot.radiusM, 0);
  context.setLineDash([4 / view.scale, 3 / view.scale]);
  context.strokeStyle = theme.ghost;
  context.lineWidth = 1.5 / view.scale;
  context.stroke();
  context.restore();
  nameGhost(scene, pose, robot.radiusM);
}

/** It has a name as soon as it is away from the robot, where it would be on the robot's own. */
function nameGhost(scene: Scene, pose: Pose, radius_m: number): void {
  const { view, poses, store, theme } = scene;
  const [dx, dy] = [pose.x_m - (poses?.x_m[store.robotIndex] ?? 0), pose.y_m - (poses?.y_m[store.robotIndex] ?? 0)];
  if (Math.hypot(dx, dy) < radius_m) return;
  const [x, y] = toPixel(view, pose.x_m, pose.y_m);
  scene.context.font = FONT;
  scene.context.textAlign = "center";
  label(scene, "dead reckoning", x, y + radius_m * view.scale + 14, theme.ghost);
}

/** What is held in the hand, where it would be put down. */
export function drawHeld(scene: Scene): void {
  const { held, store, context } = scene;
  if (!held) return;
  context.save();
  context.globalAlpha = 0.7;
  if (held.kind === "robot") drawBody(scene, store.description?.robots[held.index], held.pose);
  const thing = store.description?.things[held.index];
  if (held.kind === "thing" && thing) drawThing(scene, thing, held.pose, 0.7);
  context.restore();
}
