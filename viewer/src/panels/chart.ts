/** Charts over time of whatever values people have clicked on. */
import uPlot from "uplot";
import type { Theme } from "../arena/palette";
import { button, el, setText, Throttle } from "../dom";
import { labelOf, unitOf } from "../model/quantities";
import type { Store } from "../model/store";
import { shownRange, shownSpan, ticks } from "../model/ticks";
import { secondsOf, short } from "../model/units";

/** Colours of lines, of Okabe's and Ito's set, in a light and in a dark theme. */
const LINES = {
  light: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#56b4e9", "#882255", "#332288"],
  dark: ["#56b4e9", "#ff9a52", "#3fd0a4", "#e39bc4", "#f0c541", "#9ad4f5", "#d76a9f", "#9f93f0"],
};
const RATE_HZ = 8;
const MOST = LINES.light.length;
/** Spans that can be chosen, in seconds. */
const SPANS = [5, 15, 60, 0];
const FONT = "11px system-ui, sans-serif";
/** Pixels between two ticks, at least: of time, and of values. */
const APART = [78, 26] as const;

export class ChartPanel {
  readonly element: HTMLElement;
  keys = ["signal:left", "signal:right"];
  /** Called when `keys` has changed. */
  changed: () => void = () => {};
  private readonly holder = el("div", { class: "chart-holder" });
  private readonly legend = el("div", { class: "legend" });
  private readonly hint = el("p", { class: "hint", text: "Click a value of the robot to chart it." });
  private plot: uPlot | undefined;
  private span_s = 15;
  private readonly throttle = new Throttle(1000 / RATE_HZ, () => this.draw());
  private readonly values = new Map<string, HTMLElement>();

  constructor(
    private readonly store: Store,
    private theme: Theme,
  ) {
    const span = el("select", { title: "How much of the past", label: "Span of the chart" });
    for (const span_s of SPANS)
      span.append(el("option", { value: String(span_s), text: span_s ? `${span_s} s` : "all" }));
    span.value = String(this.span_s);
    span.addEventListener("change", () => {
      this.span_s = Number(span.value);
      this.throttle.ask(true);
    });
    const clear = button("Clear", "Remove all values from the chart", () => this.set([]));
    const head = el(
      "div",
      { class: "panel-head" },
      el("h2", { text: "Chart" }),
      el("div", { class: "tools" }, span, clear),
    );
    this.element = el(
      "section",
      { class: "panel chart", test: "chart", label: "Chart" },
      head,
      this.legend,
      this.hint,
      this.holder,
    );
    new ResizeObserver(() => this.resize()).observe(this.holder);
    store.on("frame", () => this.throttle.ask());
    store.on("robot", () => this.rebuild());
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.rebuild();
  }

  /** Puts a value on the chart, or takes it off. */
  toggle(key: string): void {
    this.set(this.keys.includes(key) ? this.keys.filter((other) => other !== key) : [...this.keys, key].slice(-MOST));
  }

  private set(keys: string[]): void {
    this.keys = keys;
    this.rebuild();
    this.changed();
  }

  private rebuild(): void {
    this.plot?.destroy();
    this.plot = undefined;
    this.values.clear();
    this.legend.replaceChildren(...this.keys.map((key, i) => this.legendEntry(key, i)));
    this.hint.hidden = this.keys.length > 0;
    this.holder.hidden = this.keys.length === 0;
    if (this.keys.length > 0 && this.holder.clientWidth > 0)
      this.plot = new uPlot(this.options(), this.data(), this.holder);
  }

  private legendEntry(key: string, i: number): HTMLElement {
    const value = el("span", { class: "legend-value" });
    this.values.set(key, value);
    const swatch = el("span", { class: "swatch" });
    swatch.style.background = this.color(i);
    const close = button("×", `Remove ${labelOf(key)} from the chart`, () => this.toggle(key), { class: "quiet" });
    return el("span", { class: "legend-entry" }, swatch, labelOf(key), value, close);
  }

  private color(i: number): string {
    return LINES[this.theme.dark ? "dark" : "light"][i % MOST] ?? "#888888";
  }

  private unit(key: string): string {
    return unitOf(key, this.store.record?.description);
  }

  private options(): uPlot.Options {
    const units = [...new Set(this.keys.map((key) => this.unit(key)))];
    const values = { range: (_: uPlot, min: number | null, max: number | null) => shownRange(min, max) };
    return {
      width: this.holder.clientWidth,
      height: Math.max(90, this.holder.clientHeight),
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { size: 6 } },
      scales: {
        x: { time: false, range: () => this.shown },
        ...Object.fromEntries(units.map((unit) => [unit, values])),
      },
      series: [{}, ...this.keys.map((key, i) => this.line(key, i))],
      axes: this.axes(units),
      padding: [8, units.length > 1 ? 0 : 16, 0, 0],
    };
  }

  /** A line has gaps where nothing was seen; what was seen between two gaps is a dot. */
  private line(key: string, i: number): uPlot.Series {
    const points = { show: true, filter: lonely, size: 5, fill: this.color(i) };
    return { scale: this.unit(key), stroke: this.color(i), width: 1.5, points };
  }

  /** Time below; the first two units on the left and on the right. */
  private axes(units: string[]): uPlot.Axis[] {
    const grid = { stroke: this.theme.gridStrong, width: 1 };
    const axis = { stroke: this.theme.paleInk, font: FONT, ticks: { stroke: this.theme.gridStrong, size: 4 } };
    const ofUnit = (unit: string, i: number): uPlot.Axis => {
      const label = unit === "1" ? "" : unit;
      const [side, own] = i === 0 ? [3 as const, grid] : [1 as const, { show: false }];
      return {
        ...axis,
        ...round(1, ""),
        size: roomFor,
        scale: unit,
        side,
        grid: own,
        label,
        labelSize: label === "" ? 0 : 14,
        labelFont: FONT,
        labelGap: 0,
      };
    };
    return [{ ...axis, ...round(0, " s"), grid, size: 24 }, ...units.slice(0, 2).map(ofUnit)];
  }

  /** The part of time that is shown, in seconds. */
  private get shown(): [number, number] {
    const { record, frame } = this.store;
    return shownSpan(record?.series.first ?? 0, secondsOf(frame?.timeNs ?? 0n), this.span_s);
  }

  private data(): uPlot.AlignedData {
    const series = this.store.record?.series;
    const rows = series?.rows(this.keys, series.capacity) ?? [
      new Float64Array(0),
      ...this.keys.map(() => new Float64Array(0)),
    ];
    const from_s = this.shown[0];
    // The line comes in from what was before.
    const first = (rows[0] ?? new Float64Array(0)).findIndex((time_s) => time_s >= from_s) - 1;
    // A value that was not there is null to uPlot.
    return rows.map((row, i) => {
      const part = row.subarray(Math.max(0, first));
      return i === 0 ? part : Array.from(part, (value) => (Number.isNaN(value) ? null : value));
    }) as unknown as uPlot.AlignedData;
  }

  private draw(): void {
    if (this.keys.length === 0) return;
    if (!this.plot) this.rebuild();
    this.plot?.setData(this.data());
    for (const [key, element] of this.values) setText(element, short(this.store.record?.values.get(key) ?? NaN));
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.holder;
    if (this.keys.length === 0 || clientWidth === 0) return;
    if (!this.plot) return this.rebuild();
    this.plot.setSize({ width: clientWidth, height: Math.max(90, clientHeight) });
  }
}

/** An axis of ticks at round numbers, in the direction of the width (0) or of the height (1). */
function round(direction: 0 | 1, unit: string): Pick<uPlot.Axis, "splits" | "values"> {
  const most = (plot: uPlot) => {
    const length = direction === 0 ? plot.bbox.width : plot.bbox.height;
    return Math.max(2, length / window.devicePixelRatio / APART[direction]);
  };
  const made = (plot: uPlot, axis: number) => {
    const { min, max } = plot.scales[plot.axes[axis]?.scale ?? "x"] ?? {};
    return ticks(min ?? 0, max ?? 1, most(plot));
  };
  return {
    splits: (plot, axis) => made(plot, axis).values,
    values: (plot, _, axis) => made(plot, axis).labels.map((label) => label + unit),
  };
}

/** How wide an axis is so that its labels are whole. It does not change with each digit. */
function roomFor(plot: uPlot, labels: string[] | null): number {
  plot.ctx.save();
  plot.ctx.font = FONT;
  const widest = Math.max(20, ...(labels ?? []).map((label) => plot.ctx.measureText(label).width));
  plot.ctx.restore();
  return 12 + 8 * Math.ceil(widest / 8);
}

/** The places of values without neighbours: no line shows them. */
function lonely(plot: uPlot, series: number): number[] {
  const values = plot.data[series] ?? [];
  const isThere = (i: number) => values[i] !== null && values[i] !== undefined;
  return Array.from(values.keys()).filter((i) => isThere(i) && !isThere(i - 1) && !isThere(i + 1));
}
