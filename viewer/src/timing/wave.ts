/** The signal of a wire: high, low, undriven, driven against each other, or pulses that are told together. */
import type { Theme } from "../arena/palette";
import { withAlpha } from "../arena/palette";
import { PinEventKind as K } from "../gen/baudbot/v1/observe_pb";
import { dutyOf } from "../model/pins";
import { pulsesInWords, type WavePart } from "./pins";

/** Where a wave is drawn. */
export interface Strip {
  context: CanvasRenderingContext2D;
  theme: Theme;
  /** Its edges, in pixels. */
  left: number;
  right: number;
  top: number;
  row: number;
  /** Where an instant is. */
  x: (at_ns: number) => number;
}

/** From a row's edge to high or low. */
const MARGIN = 2.5;
/** The opacity of pulses of duty 0 and 1, and of what is too dense to be drawn. */
const LIGHTEST = 0.12;
const DARKEST = 0.85;
const DENSE = 0.4;
/** On pulses of a greater duty text has the other ink. */
const DARK = 0.55;
/** Levels that are narrower than this are drawn together. */
const NARROW = 1.5;

export function drawWave(strip: Strip, wave: WavePart[]): void {
  const { context, theme } = strip;
  const line = new Path2D();
  const open = new Path2D();
  let pen: number | undefined;
  let dense: number | undefined;
  const thicken = (until: number) => {
    if (dense !== undefined) block(strip, dense, until, DENSE);
    dense = undefined;
  };
  for (const { part, until_ns } of wave) {
    const [from, until] = [strip.x(part.at_ns), strip.x(until_ns)].map((x) => near(strip, x)) as [number, number];
    const isLevel = part.kind === K.LOW || part.kind === K.HIGH;
    if (isLevel && until - from < NARROW && pen !== undefined) {
      dense ??= from;
      pen = levelOf(strip, part.kind);
      continue;
    }
    thicken(from);
    switch (part.kind) {
      case K.LOW:
      case K.HIGH: {
        const y = levelOf(strip, part.kind);
        line.moveTo(from, pen ?? y);
        line.lineTo(from, y);
        line.lineTo(until, y);
        pen = y;
        break;
      }
      case K.OPEN:
        pen = strip.top + strip.row / 2;
        open.moveTo(from, pen);
        open.lineTo(until, pen);
        break;
      case K.SHORT:
        hatch(strip, from, until);
        pen = undefined;
        break;
      case K.PULSES:
        drawPulses(strip, { part, until_ns }, from, until);
        pen = levelOf(strip, K.LOW);
        break;
      default:
        pen = undefined;
    }
  }
  const last = wave.at(-1);
  if (last) thicken(near(strip, strip.x(last.until_ns)));
  context.lineWidth = 1.3;
  context.strokeStyle = theme.frame;
  context.setLineDash([2, 3]);
  context.stroke(open);
  context.setLineDash([]);
  context.strokeStyle = theme.robot;
  context.stroke(line);
}

function levelOf({ top, row }: Strip, kind: K): number {
  return kind === K.HIGH ? top + MARGIN : top + row - MARGIN;
}

function near({ left, right }: Strip, x: number): number {
  return Math.min(right + 20, Math.max(left - 20, x));
}

function block({ context, theme, top, row }: Strip, from: number, until: number, opacity: number): void {
  context.fillStyle = withAlpha(theme.robot, opacity);
  context.fillRect(from, top + MARGIN, Math.max(1, until - from), row - 2 * MARGIN);
}

/** Pulses, with their duty and frequency on them if there is room. */
function drawPulses(strip: Strip, { part }: WavePart, from: number, until: number): void {
  const { context, theme, top, row } = strip;
  const duty = dutyOf(part);
  block(strip, from, until, LIGHTEST + (DARKEST - LIGHTEST) * Math.min(1, duty));
  context.lineWidth = 1;
  context.strokeStyle = theme.robot;
  context.strokeRect(from, top + MARGIN, Math.max(1, until - from), row - 2 * MARGIN);
  const [left, right] = [Math.max(from, strip.left), Math.min(until, strip.right)];
  const words = pulsesInWords(part);
  const text = [words, words.split(",")[0] ?? ""].find((text) => context.measureText(text).width + 6 <= right - left);
  if (!text) return;
  context.textAlign = "center";
  context.fillStyle = duty > DARK ? (theme.dark ? theme.ground : "#ffffff") : theme.ink;
  context.fillText(text, (left + right) / 2, top + row / 2 + 4);
}

function hatch({ context, theme, top, row }: Strip, from: number, until: number): void {
  const [high, low, wide] = [top + MARGIN, top + row - MARGIN, Math.max(2, until - from)];
  context.fillStyle = withAlpha(theme.late, 0.15);
  context.fillRect(from, high, wide, low - high);
  context.lineWidth = 1.2;
  context.strokeStyle = theme.late;
  context.strokeRect(from, high, wide, low - high);
  const stripes = new Path2D();
  for (let x = from; x + 5 <= from + wide; x += 5) {
    stripes.moveTo(x, low);
    stripes.lineTo(x + 5, high);
  }
  context.stroke(stripes);
}
