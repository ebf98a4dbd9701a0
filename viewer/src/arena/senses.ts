/** What the chosen robot's sensors see now, and what has reached its brain. */
import { SensorKind, type SensorDescription } from "../gen/baudbot/v1/brain_link_pb";
import type { RayFan, SensorDetail } from "../gen/baudbot/v1/observe_pb";
import { short } from "../model/units";
import { composed, relative, type Pose } from "../model/pose";
import { darkened, hue, paled, withAlpha } from "./palette";
import { FONT, label, type Scene } from "./scene";
import { toPixel } from "./view";

/** A sensor with more rays than this is drawn as an area. */
const MANY_RAYS = 24;
/** Fans shorter than this on the screen have no number at their tips. */
const LEAST_FOR_TEXT = 36;

export function drawSenses(scene: Scene, robotPose: Pose): void {
  const record = scene.store.record;
  const truth = record?.now?.truth;
  const details = record?.now?.detail?.sensors;
  if (!record || !truth || !details) return;
  // Rays are those of the frame, the robot is drawn between two frames: the rays move with it.
  const framePose: Pose = { x_m: truth.xM, y_m: truth.yM, heading_rad: truth.headingRad };
  details.forEach((detail, i) => {
    const description = record.description.sensors[i];
    if (!description || !detail.rays) return;
    const { xM, yM, headingRad } = detail.rays;
    const onRobot = relative(framePose, { x_m: xM, y_m: yM, heading_rad: headingRad });
    drawFan(scene, description, detail, detail.rays, composed(robotPose, onRobot));
    // Its readings are along the rays.
    const share = Math.cos(description.mount?.elevationRad ?? 0);
    if (description.kind === SensorKind.LASER) drawScan(scene, detail, detail.rays, onRobot, share);
  });
}

/** The direction of the k-th of n rays: the first is on the right. */
function bearing(fan: RayFan, k: number, count: number): number {
  return count > 1 ? fan.openingRad * (k / (count - 1) - 0.5) : 0;
}

function drawFan(scene: Scene, sensor: SensorDescription, detail: SensorDetail, fan: RayFan, pose: Pose): void {
  const { context, view, theme } = scene;
  const color = hue(sensor.kind);
  const [x, y] = toPixel(view, pose.x_m, pose.y_m);
  const count = fan.lengthsM.length;
  const tips = fan.lengthsM.map((length_m, k): [number, number] => {
    const angle = pose.heading_rad + bearing(fan, k, count);
    return toPixel(view, pose.x_m + length_m * Math.cos(angle), pose.y_m + length_m * Math.sin(angle));
  });
  context.beginPath();
  context.moveTo(x, y);
  for (const tip of tips) context.lineTo(...tip);
  context.closePath();
  context.fillStyle = withAlpha(color, theme.dark ? 0.16 : 0.12);
  context.fill();
  context.beginPath();
  if (count <= MANY_RAYS) for (const tip of tips) (context.moveTo(x, y), context.lineTo(...tip));
  context.strokeStyle = withAlpha(color, theme.dark ? 0.55 : 0.4);
  context.lineWidth = 1;
  context.stroke();
  const range_m = sensor.rangeM ?? Infinity;
  const met = tips.filter((_, k) => (fan.lengthsM[k] ?? Infinity) < range_m * (1 - 1e-6));
  context.fillStyle = color;
  const size = count <= MANY_RAYS ? 4 : 2;
  for (const [tipX, tipY] of met) context.fillRect(tipX - size / 2, tipY - size / 2, size, size);
  writeReading(scene, detail, color, [x, y], tips[Math.floor(count / 2)] ?? [x, y]);
}

/** The value that the brain has, at the tip of the middle ray. */
function writeReading(
  scene: Scene,
  detail: SensorDetail,
  color: string,
  from: [number, number],
  tip: [number, number],
): void {
  const [value] = detail.values;
  if (detail.values.length !== 1 || value === undefined) return;
  const [dx, dy] = [tip[0] - from[0], tip[1] - from[1]];
  const length = Math.hypot(dx, dy);
  const reach = (scene.store.record?.description.sensors ?? []).reduce((most, s) => Math.max(most, s.rangeM ?? 0), 0);
  if (reach * scene.view.scale < LEAST_FOR_TEXT) return;
  const off = 13 / Math.max(1, length);
  scene.context.font = FONT;
  scene.context.textAlign = "center";
  label(
    scene,
    short(value),
    tip[0] + off * dx,
    tip[1] + off * dy + 4,
    scene.theme.dark ? paled(color) : darkened(color),
  );
}

/** The scan that the brain has, where it was taken: by now the robot may be elsewhere. */
function drawScan(scene: Scene, detail: SensorDetail, fan: RayFan, onRobot: Pose, share: number): void {
  const { context, view, store } = scene;
  const taken = detail.sampledAtNs === undefined ? undefined : store.record?.poseAt(detail.sampledAtNs);
  if (!taken) return;
  const sensor = composed(taken, onRobot);
  const count = fan.lengthsM.length;
  context.fillStyle = scene.theme.dark ? "#7be0bd" : "#00553e";
  detail.values.slice(0, count).forEach((distance_m, k) => {
    if (distance_m < 0) return;
    const angle = sensor.heading_rad + bearing(fan, k, count);
    const along_m = share * distance_m;
    const [x, y] = toPixel(view, sensor.x_m + along_m * Math.cos(angle), sensor.y_m + along_m * Math.sin(angle));
    context.fillRect(x - 1.25, y - 1.25, 2.5, 2.5);
  });
}
