/** Charts over time of whatever values people have clicked on. */
import uPlot from "uplot";
import type { Theme } from "../arena/palette";
import { button, el, setText, Throttle } from "../dom";
import { labelOf, unitOf } from "../model/quantities";
import type { Store } from "../model/store";
import { fixed, secondsOf, short } from "../model/units";

/** Colours of lines, of Okabe's and Ito's set, in a light and in a dark theme. */
const LINES = {
  light: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#56b4e9", "#882255", "#332288"],
  dark: ["#56b4e9", "#ff9a52", "#3fd0a4", "#e39bc4", "#f0c541", "#9ad4f5", "#d76a9f", "#9f93f0"],
};
const RATE_HZ = 8;
const MOST = LINES.light.length;
/** Spans that can be chosen, in seconds. */
const SPANS = [5, 15, 60, 0];

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
    const clear = button("Clear", "Take all values off the chart", () => this.set([]));
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
    const close = button("×", `Take ${labelOf(key)} off the chart`, () => this.toggle(key), { class: "quiet" });
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
    return {
      width: this.holder.clientWidth,
      height: Math.max(90, this.holder.clientHeight),
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { size: 6 } },
      scales: { x: { time: false }, ...Object.fromEntries(units.map((unit) => [unit, { range }])) },
      series: [{}, ...this.keys.map((key, i) => this.line(key, i))],
      axes: this.axes(units),
    };
  }

  private line(key: string, i: number): uPlot.Series {
    const gaps = (plot: uPlot, _: number, from: number, until: number) => this.gaps(plot, from, until);
    return { scale: this.unit(key), stroke: this.color(i), width: 1.5, gaps, points: { show: false } };
  }

  /** A line goes over values that were not there, but not over time that a replay has leapt over. */
  private gaps(plot: uPlot, from: number, until: number): uPlot.Series.Gaps {
    const times = plot.data[0];
    const longest_s = this.store.longest * secondsOf(this.store.description?.stepNs ?? 0n);
    const gaps: uPlot.Series.Gaps = [];
    for (let i = from + 1; i <= until; i++) {
      const [before, now] = [times[i - 1] ?? 0, times[i] ?? 0];
      if (now - before > longest_s) gaps.push([plot.valToPos(before, "x", true), plot.valToPos(now, "x", true)]);
    }
    return gaps;
  }

  /** Time below; the first two units on the left and on the right. */
  private axes(units: string[]): uPlot.Axis[] {
    const font = "11px system-ui, sans-serif";
    const grid = { stroke: this.theme.gridStrong, width: 1 };
    const values = (_: uPlot, values: number[]) =>
      values.map((value) => (value === null ? "" : axisText(value, values)));
    const axis = { stroke: this.theme.paleInk, font, ticks: { stroke: this.theme.gridStrong, size: 4 }, values };
    const ofUnit = (unit: string, i: number): uPlot.Axis => {
      const label = unit === "1" ? "" : unit;
      const [side, own] = i === 0 ? [3 as const, grid] : [1 as const, { show: false }];
      return {
        ...axis,
        scale: unit,
        side,
        grid: own,
        size: 48,
        label,
        labelSize: label === "" ? 0 : 14,
        labelFont: font,
        labelGap: 0,
      };
    };
    return [{ ...axis, grid, size: 24 }, ...units.slice(0, 2).map(ofUnit)];
  }

  private data(): uPlot.AlignedData {
    const series = this.store.record?.series;
    const rows = series?.rows(this.keys, series.capacity) ?? [
      new Float64Array(0),
      ...this.keys.map(() => new Float64Array(0)),
    ];
    const times = rows[0] ?? new Float64Array(0);
    const last = times[times.length - 1] ?? 0;
    const first = this.span_s === 0 ? 0 : times.findIndex((time) => time >= last - this.span_s);
    // A value that was not there is null to uPlot, which draws on to the next.
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

/** Values that hardly change are not blown up to the height of the chart. */
function range(_: uPlot, min: number | null, max: number | null): [number, number] {
  if (min === null || max === null || !Number.isFinite(min) || !Number.isFinite(max)) return [0, 1];
  const room = Math.max(0.08 * (max - min), 0.02 * Math.max(Math.abs(min), Math.abs(max)), 1e-6);
  return [min === 0 ? 0 : min - room, max + room];
}

function axisText(value: number, all: number[]): string {
  const step = all.length > 1 ? Math.abs((all[1] ?? 0) - (all[0] ?? 0)) : 1;
  const decimals = Math.max(0, Math.min(6, Math.ceil(-Math.log10(step || 1) - 1e-9)));
  return Math.abs(value) >= 1e5 ? short(value, 2) : fixed(value, decimals);
}
