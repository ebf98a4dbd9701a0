/** The events of a recording above the slider of its replay: a colour and a shape for each kind, and a tooltip. */
import type { Theme } from "../arena/palette";
import { el, setText, surface } from "../dom";
import { ReplayEventKind } from "../gen/baudbot/v1/control_pb";
import { markAt, marksOf, type Mark } from "../model/replay";
import { clock } from "../model/units";
import type { Replayer } from "../net/replayer";

const HEIGHT = 18;
/** Half a thumb of the slider, which does not go beyond its ends; as in the style sheet. */
const INSET = 8;
/** Pixels from a mark within which a finger means it. */
const REACH = 9;

export class EventMarks {
  readonly element: HTMLElement;
  private readonly canvas = el("canvas", { class: "event-marks", test: "replay-marks", role: "img", label: "Events" });
  private readonly tip = el("div", { class: "tip", hidden: true, role: "tooltip", test: "replay-tip" });
  private marks: Mark[] = [];

  constructor(
    private readonly replayer: Replayer,
    private readonly seconds: (tick: bigint) => number,
    private theme: Theme,
  ) {
    this.element = el("div", { class: "event-row" }, this.canvas, this.tip);
    this.canvas.addEventListener("pointermove", (event) => this.hover(event.offsetX));
    this.canvas.addEventListener("pointerleave", () => (this.tip.hidden = true));
    this.canvas.addEventListener("click", (event) => this.choose(event.offsetX));
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.draw();
  }

  draw(): void {
    const width = this.element.clientWidth;
    if (width === 0) return;
    const { range, events } = this.replayer;
    this.marks = marksOf(events, range, INSET, width - 2 * INSET);
    const context = surface(this.canvas, width, HEIGHT);
    context.clearRect(0, 0, width, HEIGHT);
    for (const { x, event } of this.marks) drawMark(context, this.theme, x, event.kind);
  }

  private hover(x: number): void {
    const mark = markAt(this.marks, x, REACH);
    this.tip.hidden = !mark;
    this.canvas.classList.toggle("on-mark", mark !== undefined);
    if (!mark) return;
    setText(this.tip, `${clock(this.seconds(mark.event.tick))}  ${mark.event.text}`);
    const room = Math.max(0, this.element.clientWidth - this.tip.offsetWidth);
    this.tip.style.left = `${Math.min(room, Math.max(0, mark.x - this.tip.offsetWidth / 2))}px`;
  }

  private choose(x: number): void {
    const mark = markAt(this.marks, x, REACH);
    if (mark) void this.replayer.seek(mark.event.tick);
  }
}

/** A diamond for a collision, a disc for a brain, a square for a change by hand, a bar for an order, a triangle for the end. */
function drawMark(context: CanvasRenderingContext2D, theme: Theme, x: number, kind: ReplayEventKind): void {
  const y = HEIGHT / 2;
  context.beginPath();
  if (kind === ReplayEventKind.COLLISION) polygon(context, x, y, [0, -5.5, 5, 0, 0, 5.5, -5, 0]);
  else if (kind === ReplayEventKind.CHANGE) context.rect(x - 4, y - 4, 8, 8);
  else if (kind === ReplayEventKind.ORDER) context.rect(x - 1.5, y - 5, 3, 10);
  else if (kind === ReplayEventKind.ENDING) polygon(context, x, y, [5, -6, 5, 6, -5, 0]);
  else context.arc(x, y, 4.5, 0, 2 * Math.PI);
  context.fillStyle = markColor(theme, kind);
  context.fill();
  context.lineWidth = 1;
  context.strokeStyle = theme.halo;
  context.stroke();
}

function polygon(context: CanvasRenderingContext2D, x: number, y: number, corners: number[]): void {
  for (let i = 0; i < corners.length; i += 2) context.lineTo(x + (corners[i] ?? 0), y + (corners[i + 1] ?? 0));
  context.closePath();
}

function markColor(theme: Theme, kind: ReplayEventKind): string {
  if (kind === ReplayEventKind.COLLISION) return theme.late;
  if (kind === ReplayEventKind.BRAIN) return theme.dark ? "#3fd0a4" : "#00805d";
  if (kind === ReplayEventKind.CHANGE) return theme.dark ? "#f0b84a" : "#b36b00";
  return kind === ReplayEventKind.ENDING ? theme.ink : theme.paleInk;
}
