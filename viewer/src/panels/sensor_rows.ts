/** A sensor in the robot panel: its values, how old they are, and when it was fresh. */
import { hue, kindName } from "../arena/palette";
import { el, setClass, setText, surface } from "../dom";
import { agesText, readingOf, type Ages } from "../model/quantities";
import { STRIP, type RobotRecord } from "../model/record";
import { partsOf, type Part } from "../model/sensors";
import { count, withUnit } from "../model/units";
import { ValueRow } from "./value_row";

const STRIP_HEIGHT = 9;
const SCAN_HEIGHT = 44;

export class SensorRows {
  readonly element: HTMLElement;
  readonly rows: ValueRow[] = [];
  private readonly age: HTMLElement;
  private readonly strip = el("canvas", { class: "strip", attributes: { "aria-hidden": "true" } });
  private readonly missed = el("span", {
    class: "missed",
    title: "Missed reads: the previous one was still waiting",
  });
  private readonly scans: { part: Part; canvas: HTMLCanvasElement }[] = [];
  private readonly parts: Part[];
  private readonly ageButton: HTMLButtonElement;
  /** Of the last frames: since the last picture. */
  private ages: Ages | undefined;

  constructor(
    private readonly record: RobotRecord,
    private readonly index: number,
    chart: (key: string) => void,
  ) {
    const sensor = record.description.sensors[index];
    const name = sensor?.sensor ?? "";
    this.parts = sensor ? partsOf(sensor) : [];
    this.age = el("span", { class: "age", test: `sensor-age-${name}` });
    this.ageButton = el(
      "button",
      {
        type: "button",
        class: "age-button",
        title: `Age of ${name}'s reading: add it to the chart, or remove it`,
        click: () => (chart(`age:${name}`), chart(`least-age:${name}`)),
      },
      this.age,
    );
    const swatch = el("span", { class: "swatch" });
    swatch.style.background = hue(sensor?.kind);
    const isSingle = this.parts.length === 1 && this.parts[0]?.count === 1;
    const values = this.parts.map((part) => this.makePart(part, isSingle ? name : "", chart));
    const title = el("span", { class: "sensor-name", text: name, title: kindName(sensor?.kind) });
    const head = isSingle ? values : [title, el("span", { class: "kind", text: kindName(sensor?.kind) })];
    this.element = el(
      "div",
      { class: "sensor" },
      el("div", { class: "sensor-head" }, swatch, ...head, this.ageButton),
      ...(isSingle ? [] : values),
      el("div", { class: "sensor-foot" }, ...(record.strips[index] ? [this.strip] : []), this.missed),
    );
  }

  /** Whether a value is on the chart. */
  charted(keys: string[]): void {
    for (const row of this.rows) row.charted(keys.includes(row.key));
    setClass(this.ageButton, "charted", keys.includes(`age:${this.record.description.sensors[this.index]?.sensor}`));
  }

  refresh(accent: string, faint: string): void {
    const now = this.record.now;
    if (!now) return;
    const reading = readingOf(this.record.description, this.index, now);
    for (const row of this.rows) {
      const value = this.record.values.get(row.key);
      const part = this.parts.find((part) => `sensor:${part.name}` === row.key);
      row.set(value, value === undefined ? "–" : withUnit(value, part?.unit ?? ""));
    }
    for (const { part, canvas } of this.scans)
      drawScan(canvas, part, reading.slice(part.first, part.first + part.count), accent, faint);
    this.refreshAge();
    const strip = this.record.strips[this.index];
    if (strip) drawStrip(this.strip, strip, accent, faint);
  }

  private makePart(part: Part, name: string, chart: (key: string) => void): Node {
    const own = part.name.includes(".") ? part.name.slice(part.name.indexOf(".") + 1) : "value";
    const key = `sensor:${part.name}`;
    const row = new ValueRow(
      key,
      name || (part.count > 1 ? `least of ${part.count}` : own),
      part.range ? { kind: "bar", range: part.range } : { kind: "none" },
      chart,
    );
    this.rows.push(row);
    if (part.count === 1) return row.element;
    const canvas = el("canvas", { class: "scan", role: "img", label: `${part.count} values of ${part.name}` });
    this.scans.push({ part, canvas });
    return el("div", {}, row.element, canvas);
  }

  private refreshAge(): void {
    const { now } = this.record;
    const detail = now?.detail?.sensors[this.index];
    const ages = this.record.takeAges(this.index);
    // Without a new frame those of the last ones are still what is to be seen.
    if (ages || detail?.sampledAtNs === undefined) this.ages = ages;
    setText(
      this.age,
      this.ages ? agesText(this.ages) : detail && detail.values.length > 0 ? "age unknown" : "no reading",
    );
    setClass(this.age, "fresh", detail?.readable ?? false);
    this.ageButton.title = detail?.readable
      ? "Readable: new since the brain's last step"
      : "Not new since the brain's last step";
    const missed = detail?.missed ?? 0n;
    setText(this.missed, missed > 0n ? `${count(missed)} missed` : "");
  }
}

/** A tick a frame, filled when it was fresh; the newest is on the right. */
function drawStrip(
  canvas: HTMLCanvasElement,
  strip: { length: number; at(i: number): number },
  accent: string,
  faint: string,
): void {
  const width = canvas.clientWidth;
  if (width === 0) return;
  const context = surface(canvas, width, STRIP_HEIGHT);
  context.clearRect(0, 0, width, STRIP_HEIGHT);
  const step = width / STRIP;
  for (let i = 0; i < strip.length; i++) {
    const [value, x] = [strip.at(i), width - (strip.length - i) * step];
    if (Number.isNaN(value)) continue;
    context.fillStyle = value > 0 ? accent : faint;
    const high = value > 0 ? STRIP_HEIGHT : 3;
    context.fillRect(x, STRIP_HEIGHT - high, Math.max(1, step - 1), high);
  }
}

/** A scan from left to right: its first value is of the ray on the right of the robot, so it is drawn last. */
function drawScan(
  canvas: HTMLCanvasElement,
  part: Part,
  values: readonly number[],
  accent: string,
  faint: string,
): void {
  const width = canvas.clientWidth;
  if (width === 0) return;
  const context = surface(canvas, width, SCAN_HEIGHT);
  context.clearRect(0, 0, width, SCAN_HEIGHT);
  const met = values.filter((value) => value >= 0);
  const most = part.range?.[1] ?? Math.max(1e-9, ...met);
  const step = width / Math.max(1, part.count);
  values.forEach((value, i) => {
    const high = value < 0 ? SCAN_HEIGHT : (SCAN_HEIGHT * Math.min(value, most)) / most;
    context.fillStyle = value < 0 ? faint : accent;
    context.fillRect(width - (i + 1) * step, SCAN_HEIGHT - high, Math.max(0.75, step - (step > 3 ? 1 : 0)), high);
  });
}
