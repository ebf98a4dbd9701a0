/** Robots, from a point each in a crowd to a body with wheels when there is room for it. */
import type { BodyPart, ObservedRobot } from "../gen/baudbot/v1/observe_pb";
import type { Pose } from "../model/pose";
import { poseOf } from "../model/motion";
import { robotColors, withAlpha } from "./palette";
import { BOLD, FONT, isShown, label, type Scene } from "./scene";
import { toPixel, useMetres } from "./view";
import { trace, traceOutline } from "./ground";

/** Smaller than this on the screen, in pixels of radius, a robot is a square. */
const DOT = 2.5;
/** Larger than this it has wheels. */
const BODY = 9;
/** More robots than this have no wheels and no names, however large. */
const CROWD = 300;
const MOST_NAMES = 60;
const FLASH_MS = 700;

export function drawRobots(scene: Scene): void {
  const { store, poses } = scene;
  const robots = store.description?.robots;
  if (!robots || !poses) return;
  const shown = robots.map((_, i) => i).filter((i) => isIn(scene, i, robots[i]));
  const largest = shown.reduce((most, i) => Math.max(most, (robots[i]?.radiusM ?? 0) * scene.view.scale), 0);
  if (largest < BODY || shown.length > CROWD) drawBatched(scene, robots, shown);
  else for (const i of shown) drawBody(scene, robots[i], poseOf(poses, i));
  flash(scene, robots, shown);
  markChosen(scene, robots);
  names(scene, robots, shown);
}

function isIn(scene: Scene, i: number, robot: ObservedRobot | undefined): boolean {
  const { poses, view } = scene;
  return isShown(view, poses?.x_m[i] ?? 0, poses?.y_m[i] ?? 0, robot?.radiusM ?? 0);
}

/** All robots of a colour in one path. */
function drawBatched(scene: Scene, robots: ObservedRobot[], shown: number[]): void {
  const groups = new Map<string, { rim: string; members: number[] }>();
  for (const i of shown) {
    const { body, rim } = robotColors(robots[i]?.look, scene.theme);
    const group = groups.get(body) ?? { rim, members: [] };
    groups.set(body, group);
    group.members.push(i);
  }
  for (const [body, { rim, members }] of groups) drawGroup(scene, robots, members, body, rim);
}

function drawGroup(scene: Scene, robots: ObservedRobot[], members: number[], body: string, rim: string): void {
  const { context, view, poses } = scene;
  let bodies: Path2D | undefined;
  const headings = new Path2D();
  context.fillStyle = rim;
  for (const i of members) {
    const [x, y] = toPixel(view, poses?.x_m[i] ?? 0, poses?.y_m[i] ?? 0);
    const radius = (robots[i]?.radiusM ?? 0) * view.scale;
    if (radius < DOT) {
      // Thousands of squares one by one are much less work for a browser than a path of all of them.
      const size = Math.max(1.25, radius);
      context.fillRect(x - size, y - size, 2 * size, 2 * size);
      continue;
    }
    bodies ??= new Path2D();
    bodies.moveTo(x + radius, y);
    bodies.arc(x, y, radius, 0, 2 * Math.PI);
    const heading = poses?.heading_rad[i] ?? 0;
    headings.moveTo(x, y);
    headings.lineTo(x + radius * Math.cos(heading), y - radius * Math.sin(heading));
  }
  if (!bodies) return;
  context.fillStyle = body;
  context.fill(bodies);
  context.strokeStyle = rim;
  context.lineWidth = 1;
  context.stroke(bodies);
  context.stroke(headings);
}

/** One robot with all that is to be seen of it. */
export function drawBody(scene: Scene, robot: ObservedRobot | undefined, pose: Pose | undefined): void {
  if (!robot || !pose) return;
  const { context, view, theme } = scene;
  const { body, rim } = robotColors(robot.look, theme);
  const radius = robot.radiusM * view.scale;
  context.save();
  useMetres(context, view);
  context.translate(pose.x_m, pose.y_m);
  context.rotate(pose.heading_rad);
  if (radius > BODY) wheels(scene, robot);
  context.beginPath();
  traceBody(context, robot);
  context.fillStyle = body;
  context.fill();
  context.strokeStyle = rim;
  context.lineWidth = (radius > 30 ? 2 : 1.3) / view.scale;
  context.stroke();
  for (const part of robot.parts) drawPart(scene, part);
  arrow(context, robot.radiusM, rim, view.scale);
  context.restore();
}

/** What stands on a robot or sticks out of it, in the robot's frame. */
function drawPart({ context, view, theme }: Scene, { outline, look }: BodyPart): void {
  const { body, rim } = robotColors(look, theme);
  context.beginPath();
  traceOutline(context, outline);
  context.fillStyle = body;
  context.fill();
  context.strokeStyle = rim;
  context.lineWidth = 1 / view.scale;
  context.stroke();
}

/** The rim of a robot in its own frame. */
export function traceBody(path: CanvasRenderingContext2D, robot: ObservedRobot): void {
  if (robot.outline.length > 0) return trace(path, robot.outline, true);
  path.moveTo(robot.radiusM, 0);
  path.arc(0, 0, robot.radiusM, 0, 2 * Math.PI);
}

/** Wheels as they are seen from above. */
function wheels(scene: Scene, robot: ObservedRobot): void {
  const { context, view, theme } = scene;
  const half_track_m = robot.description?.halfTrackM ?? 0;
  const half_length_m = robot.description?.wheelRadiusM ?? 0;
  const half_width_m = Math.max(0.25 * half_length_m, 0.06 * robot.radiusM, 1 / view.scale);
  context.fillStyle = theme.dark ? "#c3ccd9" : "#1d2430";
  for (const side of [1, -1]) {
    const y_m = side * half_track_m - half_width_m;
    context.fillRect(-half_length_m, y_m, 2 * half_length_m, 2 * half_width_m);
  }
}

/** Which way is forwards, in the robot's frame. */
function arrow(context: CanvasRenderingContext2D, radius_m: number, color: string, scale: number): void {
  const [tip, head] = [0.68 * radius_m, 0.24 * radius_m];
  context.strokeStyle = context.fillStyle = color;
  context.lineWidth = Math.max(1 / scale, 0.06 * radius_m);
  context.beginPath();
  context.moveTo(0, 0);
  context.lineTo(tip - head, 0);
  context.stroke();
  context.beginPath();
  context.moveTo(tip, 0);
  context.lineTo(tip - 1.4 * head, 0.75 * head);
  context.lineTo(tip - 1.4 * head, -0.75 * head);
  context.fill();
}

/** Robots that have just run into something light up. */
function flash(scene: Scene, robots: ObservedRobot[], shown: number[]): void {
  const { context, view, store, now_ms, poses, theme } = scene;
  for (const i of shown) {
    const share = Math.min(1, 1 - (now_ms - (store.bumpedAt[i] ?? -Infinity)) / FLASH_MS);
    if (share <= 0) continue;
    const [x, y] = toPixel(view, poses?.x_m[i] ?? 0, poses?.y_m[i] ?? 0);
    const radius = Math.max(3, (robots[i]?.radiusM ?? 0) * view.scale);
    context.beginPath();
    context.arc(x, y, radius + 2 + 4 * (1 - share), 0, 2 * Math.PI);
    context.fillStyle = withAlpha(theme.late, 0.25 * share);
    context.fill();
    context.strokeStyle = withAlpha(theme.late, share);
    context.lineWidth = 2.5;
    context.stroke();
  }
}

/** Whether some robot still lights up. */
export function isFlashing(scene: Pick<Scene, "store" | "now_ms">): boolean {
  return scene.store.bumpedAt.some((at) => scene.now_ms - at < FLASH_MS);
}

function markChosen(scene: Scene, robots: ObservedRobot[]): void {
  const { context, view, store, poses, theme } = scene;
  const pose = poses && poseOf(poses, store.robotIndex);
  if (!pose || robots.length < 2) return;
  const [x, y] = toPixel(view, pose.x_m, pose.y_m);
  context.beginPath();
  context.arc(x, y, Math.max(4, (robots[store.robotIndex]?.radiusM ?? 0) * view.scale) + 4, 0, 2 * Math.PI);
  context.strokeStyle = theme.chosen;
  context.lineWidth = 1.5;
  context.setLineDash([4, 3]);
  context.stroke();
  context.setLineDash([]);
}

function names(scene: Scene, robots: ObservedRobot[], shown: number[]): void {
  const { context, view, store, poses, theme } = scene;
  const chosen = store.robotIndex;
  const all = scene.layers.names && shown.length <= MOST_NAMES ? shown : shown.filter((i) => i === chosen);
  context.textAlign = "center";
  for (const i of all) {
    const robot = robots[i];
    const pose = poses && poseOf(poses, i);
    if (!robot || !pose) continue;
    const [x, y] = toPixel(view, pose.x_m, pose.y_m);
    context.font = i === chosen ? BOLD : FONT;
    const above = Math.max(4, robot.radiusM * view.scale) + 9;
    label(scene, robot.robot, x, y - above, i === chosen ? theme.chosen : theme.paleInk);
  }
}

/** Trails of robots. */
export function drawTrails(scene: Scene): void {
  const { context, view, store, theme, poses } = scene;
  if (!poses) return;
  const chosen = store.robotIndex;
  context.save();
  useMetres(context, view);
  context.lineJoin = "round";
  store.trails.all.forEach((trail, robot) => {
    if (robot >= poses.count || trail.length < 2) return;
    const { rim } = robotColors(store.description?.robots[robot]?.look, theme);
    context.strokeStyle = withAlpha(rim, robot === chosen ? 0.65 : 0.28);
    context.lineWidth = (robot === chosen ? 1.6 : 1) / view.scale;
    context.stroke(trail.path);
  });
  context.restore();
}

/** The robot at a place of the picture: the nearest of those within reach. */
export function robotAt(scene: Pick<Scene, "view" | "store" | "poses">, x: number, y: number, slack: number): number {
  const { view, store, poses } = scene;
  let [found, least] = [-1, Infinity];
  for (let i = 0; i < (poses?.count ?? 0); i++) {
    const [rx, ry] = toPixel(view, poses?.x_m[i] ?? 0, poses?.y_m[i] ?? 0);
    const away = Math.hypot(rx - x, ry - y);
    const reach = Math.max((store.description?.robots[i]?.radiusM ?? 0) * view.scale, slack);
    if (away <= reach && away < least) [found, least] = [i, away];
  }
  return found;
}
