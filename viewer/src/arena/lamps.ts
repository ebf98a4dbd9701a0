/** Lamps that are not always lit: those that blink, and those that robots carry. And where robots' turrets point. */
import { ActuatorKind } from "../gen/baudbot/v1/brain_link_pb";
import type { Light, ObservedRobot, RobotTruth } from "../gen/baudbot/v1/observe_pb";
import { poseOf } from "../model/motion";
import { outOf, type Pose } from "../model/pose";
import { LAMP, LAMP_RIM, robotColors, withAlpha } from "./palette";
import type { Scene } from "./scene";
import { toPixel, type View } from "./view";

/** Robots with actuators that are drawn, at most: to know what they do all of their truth is decoded. */
const MOST = 100;

export function blinks(light: Light): boolean {
  return light.periodNs !== undefined && light.periodNs > 0n;
}

/** Whether a lamp that blinks is lit: from the start of its period on. */
export function isLit(light: Light, time_ns: bigint): boolean {
  return !blinks(light) || time_ns % (light.periodNs ?? 1n) < (light.litNs ?? 0n);
}

/** Lamps that blink, as they are now; the others belong to the ground. */
export function drawBlinking({ context, view, store }: Scene): void {
  const time_ns = store.frame?.timeNs ?? 0n;
  for (const light of store.description?.lights ?? [])
    if (blinks(light)) drawLight(context, view, light, isLit(light, time_ns));
}

export function drawLight(context: CanvasRenderingContext2D, view: View, light: Light, isOn = true): void {
  const [x, y] = toPixel(view, light.position?.xM ?? 0, light.position?.yM ?? 0);
  if (isOn) glow(context, view, x, y, light.intensityCd, 0.6);
  context.beginPath();
  context.arc(x, y, 4.5, 0, 2 * Math.PI);
  if (isOn) {
    context.fillStyle = LAMP;
    context.fill();
  }
  context.strokeStyle = LAMP_RIM;
  context.lineWidth = 1.2;
  for (let i = 0; i < 8; i++) {
    const [cos, sin] = [Math.cos((i * Math.PI) / 4), Math.sin((i * Math.PI) / 4)];
    context.moveTo(x + 6.5 * cos, y + 6.5 * sin);
    context.lineTo(x + 9.5 * cos, y + 9.5 * sin);
  }
  context.stroke();
}

function glow(
  context: CanvasRenderingContext2D,
  view: View,
  x: number,
  y: number,
  candela: number,
  most: number,
): void {
  // As far as it gives 10 lux, within what a picture can show.
  const size = Math.max(view.width, view.height);
  const reach = Math.min(0.22 * size, Math.max(0.04 * size, Math.sqrt(candela / 10) * view.scale));
  const light = context.createRadialGradient(x, y, 0, x, y, reach);
  light.addColorStop(0, withAlpha(LAMP, most));
  light.addColorStop(0.4, withAlpha(LAMP, most / 4));
  light.addColorStop(1, withAlpha(LAMP, 0));
  context.fillStyle = light;
  context.fillRect(x - reach, y - reach, 2 * reach, 2 * reach);
}

/** Turrets and lamps of robots, over their bodies. */
export function drawActuators(scene: Scene): void {
  const { store, poses } = scene;
  let drawn = 0;
  store.description?.robots.forEach((robot, i) => {
    const pose = poses && poseOf(poses, i);
    if (robot.actuators.length === 0 || !pose || drawn >= MOST) return;
    drawn++;
    const truth = store.frame?.truth(i);
    if (truth) drawOf(scene, robot, truth, pose);
  });
}

function drawOf(scene: Scene, robot: ObservedRobot, truth: RobotTruth, pose: Pose): void {
  const [x, y] = toPixel(scene.view, pose.x_m, pose.y_m);
  const radius = robot.radiusM * scene.view.scale;
  truth.actuators.forEach(({ signal, angleRad }, i) => {
    const kind = robot.description?.actuators[i]?.kind;
    if (kind === ActuatorKind.TURRET && radius > 6) drawTurret(scene, robot, pose, angleRad);
    if (kind === ActuatorKind.LAMP) drawCarried(scene, x, y, radius, signal);
  });
}

/** A turret from above: its ring in the robot's middle, and a barrel where it points. */
function drawTurret(scene: Scene, robot: ObservedRobot, pose: Pose, angle_rad: number): void {
  const { context, view, theme } = scene;
  const { rim, body } = robotColors(robot.look, theme);
  const at = (share: number) => {
    const turned = { ...pose, heading_rad: pose.heading_rad + angle_rad };
    const point = outOf(turned, share * robot.radiusM, 0);
    return toPixel(view, point.x_m, point.y_m);
  };
  const radius = robot.radiusM * view.scale;
  context.beginPath();
  context.moveTo(...at(0.3));
  context.lineTo(...at(0.95));
  context.strokeStyle = theme.ink;
  context.lineCap = "round";
  context.lineWidth = Math.max(2, 0.13 * radius);
  context.stroke();
  context.lineCap = "butt";
  context.beginPath();
  context.arc(...at(0), 0.3 * radius, 0, 2 * Math.PI);
  context.fillStyle = body;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = rim;
  context.stroke();
}

/** A lamp on a robot is as bright as its signal. */
function drawCarried({ context, view }: Scene, x: number, y: number, radius: number, signal: number): void {
  const share = Math.min(1, Math.max(0, signal));
  if (share > 0) glow(context, view, x, y, 0, 0.2 + 0.5 * share);
  context.beginPath();
  context.arc(x, y, Math.max(2, 0.12 * radius), 0, 2 * Math.PI);
  context.strokeStyle = LAMP_RIM;
  context.lineWidth = 1.2;
  context.stroke();
  if (share === 0) return;
  context.fillStyle = LAMP;
  context.fill();
}
