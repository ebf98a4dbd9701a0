/** Metres along the edges, and a bar of a round length. */
import { gridStep } from "./ground";
import { FONT, type Scene } from "./scene";
import { toPixel, toWorld } from "./view";
import { lengthText } from "../model/units";

const LEFT = 38;
const BOTTOM = 22;

export function drawAxes(scene: Scene): void {
  const { context, view, theme } = scene;
  const step_m = gridStep(view);
  const decimals = Math.max(0, -Math.floor(Math.log10(step_m) + 1e-9));
  const text = (value: number) => (Math.abs(value) < step_m / 2 ? "0" : value.toFixed(decimals).replace("-", "−"));
  context.fillStyle = theme.ground;
  context.fillRect(0, 0, LEFT, view.height);
  context.fillRect(0, view.height - BOTTOM, view.width, BOTTOM);
  context.fillStyle = theme.paleInk;
  context.strokeStyle = theme.frame;
  context.lineWidth = 1;
  context.font = FONT;
  context.beginPath();
  context.moveTo(LEFT + 0.5, 0);
  context.lineTo(LEFT + 0.5, view.height - BOTTOM - 0.5);
  context.lineTo(view.width, view.height - BOTTOM - 0.5);
  const [left_m, bottom_m] = toWorld(view, LEFT, view.height - BOTTOM);
  const [right_m, top_m] = toWorld(view, view.width, 0);
  context.textAlign = "center";
  for (let i = Math.ceil(left_m / step_m); i * step_m <= right_m; i++) {
    const x = toPixel(view, i * step_m, 0)[0];
    if (x < view.width - 12 && x > LEFT + 8) context.fillText(text(i * step_m), x, view.height - 7);
    context.moveTo(Math.round(x) + 0.5, view.height - BOTTOM);
    context.lineTo(Math.round(x) + 0.5, view.height - BOTTOM + 4);
  }
  context.textAlign = "right";
  for (let i = Math.ceil(bottom_m / step_m); i * step_m <= top_m; i++) {
    const y = toPixel(view, 0, i * step_m)[1];
    if (y > 8) context.fillText(text(i * step_m), LEFT - 7, y + 4);
    context.moveTo(LEFT - 4, Math.round(y) + 0.5);
    context.lineTo(LEFT, Math.round(y) + 0.5);
  }
  context.stroke();
  context.textAlign = "left";
  context.fillText("m", 8, view.height - 7);
}

export function drawScaleBar(scene: Scene): void {
  const { context, view, theme } = scene;
  const length_m = gridStep(view);
  const length = length_m * view.scale;
  const [right, y] = [view.width - 16, view.height - BOTTOM - 10];
  context.fillStyle = theme.halo;
  context.fillRect(right - length - 6, y - 18, length + 12, 24);
  context.beginPath();
  context.moveTo(right - length, y - 4);
  context.lineTo(right - length, y);
  context.lineTo(right, y);
  context.lineTo(right, y - 4);
  context.lineWidth = 1.5;
  context.strokeStyle = theme.ink;
  context.stroke();
  context.font = FONT;
  context.textAlign = "center";
  const text = lengthText(length_m);
  context.fillStyle = theme.ink;
  context.fillText(text, right - length / 2, y - 6);
}
