/** The picture of a timing diagram: lanes of bars over one axis of time. */
import { TimelineKind } from "../gen/baudbot/v1/observe_pb";
import type { Theme } from "../arena/palette";
import { withAlpha } from "../arena/palette";
import { duration, roundStep } from "../model/units";
import type { Cycle } from "./cycle";
import { isIdle, kindOf, type Kind } from "./kinds";
import type { Bar, Lane, Window } from "./layout";
import { partInWords, type WavePart } from "./pins";
import { drawWave } from "./wave";

export interface Picture {
  context: CanvasRenderingContext2D;
  width: number;
  height: number;
  theme: Theme;
  window: Window;
  lanes: Lane[];
  cycle: Cycle | undefined;
  step_ns: number;
  deadline_ns: number;
  /** Height of a row of bars. */
  row: number;
}

/** A picture that is being drawn. */
interface Sheet extends Picture {
  /** Where bars begin. */
  left: number;
}

/** Where a bar is, for the mouse. */
export interface Spot {
  x: number;
  y: number;
  width: number;
  height: number;
  bar: Bar;
}

const TOP = 28;
const BOTTOM = 20;
const RIGHT = 12;
const LOWEST = 14;
const HIGHEST = 20;
const GAP = 3;
const GROUP_GAP = 5;
/** Half of a diamond, and how far from its middle its label begins. */
const MARK = 5;
const BESIDE = 8;
/** Steps are drawn no closer than this. */
const APART = 26;
const FONT = "11px system-ui, sans-serif";
/** How strong what is not of the cycle is. */
const PALE = 0.32;

/** How high a picture of these lanes is, with rows of this height. */
export function heightOf(lanes: Lane[], row = LOWEST): number {
  return TOP + rowsOf(lanes) * row + gapsOf(lanes) + BOTTOM;
}

/** How high rows are so that lanes fill so much room, within what looks well. */
export function rowFor(lanes: Lane[], room: number): number {
  const row = Math.floor((room - TOP - BOTTOM - gapsOf(lanes)) / Math.max(1, rowsOf(lanes)));
  return Math.min(HIGHEST, Math.max(LOWEST, row));
}

function rowsOf(lanes: Lane[]): number {
  return lanes.reduce((sum, lane) => sum + lane.rows, 0);
}

function gapsOf(lanes: Lane[]): number {
  return lanes.length * GAP + new Set(lanes.map((lane) => lane.group)).size * GROUP_GAP;
}

/** Behind the longest label, unless that leaves bars too little. */
function leftOf({ context, lanes, width }: Picture): number {
  const widest = Math.max(0, ...lanes.map((lane) => context.measureText(lane.label).width));
  return Math.min(Math.max(64, Math.ceil(widest) + 18), Math.round(0.36 * width));
}

/** Where an instant is. */
function xOf(picture: Sheet, at_ns: number): number {
  const { from_ns, until_ns } = picture.window;
  const { left } = picture;
  return left + ((at_ns - from_ns) / (until_ns - from_ns)) * (picture.width - left - RIGHT);
}

/** Draws it; returns where its bars are. */
export function draw(wanted: Picture): Spot[] {
  const { context, width, height, theme } = wanted;
  context.fillStyle = theme.ground;
  context.fillRect(0, 0, width, height);
  context.font = FONT;
  const picture = { ...wanted, left: leftOf(wanted) };
  drawGroups(picture);
  drawLateTime(picture);
  drawSteps(picture);
  const spots = drawLanes(picture);
  drawAxis(picture);
  return spots;
}

/** Where each lane begins. */
function tops({ lanes, row }: Sheet): number[] {
  let y = TOP;
  return lanes.map((lane, i) => {
    if (i > 0 && lanes[i - 1]?.group !== lane.group) y += GROUP_GAP;
    const top = y;
    y += lane.rows * row + GAP;
    return top;
  });
}

function drawGroups(picture: Sheet): void {
  const { context, lanes, theme, width } = picture;
  const starts = tops(picture);
  lanes.forEach((lane, i) => {
    const [top, high] = [starts[i] ?? 0, lane.rows * picture.row + GAP];
    context.fillStyle = theme.floor;
    context.fillRect(0, top, width, high);
    context.fillStyle = theme.ink;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(clipped(context, lane.label, picture.left - 12), picture.left - 8, top + high / 2);
  });
  context.textBaseline = "alphabetic";
}

/** What is later than the deadline after the cycle began is on red ground. */
function drawLateTime(picture: Sheet): void {
  const { context, cycle, deadline_ns, theme, width, height } = picture;
  if (!cycle) return;
  const late_ns = cycle.begun_ns + deadline_ns;
  const [from, until] = [xOf(picture, late_ns), Math.min(width - RIGHT, xOf(picture, cycle.end_ns))];
  if (cycle.obeyed_ns > late_ns) {
    context.fillStyle = withAlpha(theme.late, theme.dark ? 0.16 : 0.09);
    context.fillRect(from, TOP, until - from, height - TOP - BOTTOM);
  }
  const lines: [number, string, string][] = [
    [cycle.begun_ns, "cycle begins", theme.ink],
    [late_ns, `deadline ${duration(deadline_ns)}`, theme.late],
    [cycle.obeyed_ns, "obeyed", theme.ink],
  ];
  let free = -Infinity;
  for (const [at_ns, text, color] of lines.sort((a, b) => a[0] - b[0])) {
    const x = xOf(picture, at_ns);
    if (x > width) continue;
    dashed(context, x, TOP - 4, height - BOTTOM, color, [2, 2]);
    const wide = context.measureText(text).width;
    const left = Math.min(Math.max(x - wide / 2, free), width - wide - 2);
    context.fillStyle = color;
    context.textAlign = "left";
    if (left >= free) context.fillText(text, left, TOP - 15);
    free = left + wide + 8;
  }
}

/** Steps: from the cycle's beginning if there is one, or else multiples of Δt. */
function drawSteps(picture: Sheet): void {
  const { context, window, cycle, step_ns, theme, height } = picture;
  const origin = cycle?.begun_ns ?? 0;
  const together = Math.max(1, roundStep(APART / (xOf(picture, origin + step_ns) - xOf(picture, origin))));
  const span_ns = together * step_ns;
  const first = Math.ceil((window.from_ns - origin) / span_ns);
  const count = Math.floor((window.until_ns - origin) / span_ns) - first;
  context.textAlign = "center";
  const unit = together > 1 ? `${together} Δt` : "Δt";
  for (let i = first; i <= first + count; i++) {
    const at_ns = origin + i * span_ns;
    const x = xOf(picture, at_ns);
    dashed(context, x, TOP - 10, height - BOTTOM, theme.frame, [5, 4]);
    const wide = xOf(picture, at_ns + span_ns) - x;
    context.fillStyle = theme.paleInk;
    const text = i === Math.max(0, first) && wide > 80 ? `${unit} = ${duration(span_ns)}` : unit;
    if (i < first + count && context.measureText(text).width + 4 < wide) context.fillText(text, x + wide / 2, TOP - 3);
  }
}

function dashed(
  context: CanvasRenderingContext2D,
  x: number,
  top: number,
  bottom: number,
  color: string,
  dash: number[],
): void {
  context.beginPath();
  context.moveTo(Math.round(x) + 0.5, top);
  context.lineTo(Math.round(x) + 0.5, bottom);
  context.setLineDash(dash);
  context.lineWidth = 1;
  context.strokeStyle = color;
  context.stroke();
  context.setLineDash([]);
}

function drawLanes(picture: Sheet): Spot[] {
  const { context, lanes, width } = picture;
  const { left } = picture;
  const starts = tops(picture);
  const spots: Spot[] = [];
  context.save();
  context.beginPath();
  context.rect(left, 0, width - left - RIGHT + 6, picture.height);
  context.clip();
  lanes.forEach((lane, i) => {
    const topOf = (row: number) => (starts[i] ?? 0) + GAP / 2 + row * picture.row;
    if (lane.wave) spots.push(...drawPin(picture, lane.wave, topOf(0)));
    spots.push(...lane.bars.map((bar) => drawBar(picture, bar, topOf(bar.row))));
    for (let row = 0; row < lane.rows; row++) nameMarks(picture, lane, row, topOf(row));
  });
  context.restore();
  return spots;
}

/** A pin's signal, and where its parts are. */
function drawPin(picture: Sheet, wave: WavePart[], top: number): Spot[] {
  const { context, theme, left, row } = picture;
  const x = (at_ns: number) => xOf(picture, at_ns);
  drawWave({ context, theme, left, right: picture.width - RIGHT, top, row, x }, wave);
  return wave.map(({ part, until_ns }) => {
    const event = { start_ns: part.at_ns, end_ns: until_ns, kind: TimelineKind.UNSPECIFIED, part: undefined, bytes: 0 };
    const bar = { event, row: 0, label: "", pale: false, tip: partInWords(part) };
    return { x: x(part.at_ns), y: top, width: Math.max(1, x(until_ns) - x(part.at_ns)), height: row, bar };
  });
}

/** The labels of a row's marks: beside them, where there is room before what comes next. A crowd has one. */
function nameMarks(picture: Sheet, lane: Lane, row: number, top: number): void {
  const { context } = picture;
  const bars = lane.bars.filter((bar) => bar.row === row);
  bars.forEach((bar, i) => {
    const next = bars[i + 1];
    if (!isMark(bar) || bar.label === "" || (next && isOneCrowd(picture, bar, next))) return;
    let first = i;
    while (first > 0 && isOneCrowd(picture, bars[first - 1] as Bar, bars[first] as Bar)) first--;
    const text = first < i ? `${i - first + 1} × ${bar.label}` : bar.label;
    const from = xOf(picture, bar.event.start_ns) + BESIDE;
    const until = next ? xOf(picture, next.event.start_ns) - (isMark(next) ? MARK : 0) : picture.width - RIGHT + 6;
    if (from + context.measureText(text).width + 3 > until) return;
    context.globalAlpha = bar.pale ? PALE : 1;
    context.textAlign = "left";
    context.fillStyle = picture.theme.ink;
    context.fillText(text, from, top + picture.row / 2 + 4);
    context.globalAlpha = 1;
  });
}

function isMark({ event }: Bar): boolean {
  return event.end_ns === event.start_ns;
}

/** Whether two marks that follow on each other say the same at the same place, as far as eyes can tell. */
function isOneCrowd(picture: Sheet, bar: Bar, next: Bar): boolean {
  const apart = xOf(picture, next.event.start_ns) - xOf(picture, bar.event.start_ns);
  return isMark(bar) && isMark(next) && bar.label === next.label && apart < 2 * MARK;
}

function drawBar(picture: Sheet, bar: Bar, top: number): Spot {
  const { context, row } = picture;
  const { event } = bar;
  const kind = styleOf(bar);
  const [from, until] = [xOf(picture, event.start_ns), xOf(picture, event.end_ns)];
  context.globalAlpha = bar.pale ? PALE : 1;
  if (isMark(bar)) {
    mark(picture, from, top + row / 2, colorOf(picture, bar, event.start_ns), isIdle(event));
    context.globalAlpha = 1;
    return { x: from - MARK - 1, y: top, width: 2 * MARK + 2, height: row, bar };
  }
  const wide = Math.max(1.5, until - from);
  const late_ns = lateFrom(picture, bar);
  const split = Math.min(until, Math.max(from, late_ns === undefined ? until : xOf(picture, late_ns)));
  context.fillStyle = kind.color;
  context.fillRect(from, top + 1.5, Math.max(split - from, split < until ? 0 : wide), row - 3);
  if (split < until) {
    context.fillStyle = picture.theme.late;
    context.fillRect(split, top + 1.5, Math.max(1.5, until - split), row - 3);
  }
  write(picture, bar, from, until, top);
  context.globalAlpha = 1;
  return { x: from - 2, y: top, width: wide + 4, height: row, bar };
}

function styleOf(bar: Bar): Kind {
  return bar.style ?? kindOf(bar.event.kind);
}

/** From when on a bar is red: its cycle's deadline. */
function lateFrom(picture: Sheet, bar: Bar): number | undefined {
  const { cycle, deadline_ns } = picture;
  return cycle && cycle.events.has(bar.event) ? cycle.begun_ns + deadline_ns : undefined;
}

function colorOf(picture: Sheet, bar: Bar, at_ns: number): string {
  const late_ns = lateFrom(picture, bar);
  return late_ns !== undefined && at_ns > late_ns ? picture.theme.late : styleOf(bar).color;
}

/** What takes no time is a diamond, and one that is hollow is without news. */
function mark({ context }: Sheet, x: number, y: number, color: string, isHollow: boolean): void {
  const size = isHollow ? MARK - 1 : MARK;
  context.beginPath();
  context.moveTo(x, y - size);
  context.lineTo(x + size, y);
  context.lineTo(x, y + size);
  context.lineTo(x - size, y);
  context.closePath();
  if (isHollow) {
    context.lineWidth = 1.5;
    context.strokeStyle = color;
    context.stroke();
  } else {
    context.fillStyle = color;
    context.fill();
  }
}

/** A bar's label: on it, if there is room. */
function write(picture: Sheet, bar: Bar, from: number, until: number, top: number): void {
  const { context } = picture;
  const [left, right] = [Math.max(from, picture.left), Math.min(until, picture.width - RIGHT)];
  if (bar.label === "" || context.measureText(bar.label).width + 6 > right - left) return;
  context.textAlign = "center";
  context.fillStyle = inkOf(picture, bar);
  context.fillText(bar.label, (left + right) / 2, top + picture.row / 2 + 4);
}

/** The colour of text on a bar. */
function inkOf(picture: Sheet, bar: Bar): string {
  const { theme } = picture;
  if (bar.pale && theme.dark) return theme.ink;
  const late_ns = lateFrom(picture, bar) ?? Infinity;
  const isRed = late_ns < (bar.event.start_ns + bar.event.end_ns) / 2;
  return isRed ? (theme.dark ? "#10151f" : "#ffffff") : styleOf(bar).ink;
}

function drawAxis(picture: Sheet): void {
  const { context, window, theme, width, height } = picture;
  const { left } = picture;
  const y = height - BOTTOM + 0.5;
  context.beginPath();
  context.moveTo(left, y);
  context.lineTo(width - RIGHT, y);
  const step_ns = roundStep(((window.until_ns - window.from_ns) / (width - left - RIGHT)) * 80);
  const decimals = Math.max(0, Math.min(6, 6 - Math.floor(Math.log10(step_ns) + 1e-9)));
  context.fillStyle = theme.paleInk;
  context.textAlign = "center";
  for (let i = Math.ceil(window.from_ns / step_ns); i * step_ns <= window.until_ns; i++) {
    const x = xOf(picture, i * step_ns);
    context.moveTo(Math.round(x) + 0.5, y);
    context.lineTo(Math.round(x) + 0.5, y + 4);
    if (x < width - RIGHT - 16) context.fillText(((i * step_ns) / 1e6).toFixed(decimals), x, height - 4);
  }
  context.strokeStyle = theme.frame;
  context.lineWidth = 1;
  context.stroke();
  context.textAlign = "left";
  context.fillText("time in ms", 6, height - 4);
}

function clipped(context: CanvasRenderingContext2D, text: string, most: number): string {
  if (context.measureText(text).width <= most) return text;
  let short = text;
  while (short.length > 1 && context.measureText(`${short}…`).width > most) short = short.slice(0, -1);
  return `${short}…`;
}
