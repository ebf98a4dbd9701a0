/** A value in the robot panel: a button that puts it on the chart or takes it off. */
import { el, setPressed, setText } from "../dom";

/** How a value is shown besides its number. */
export type Gauge = { kind: "none" } | { kind: "bar"; range: [number, number] };

export class ValueRow {
  readonly element: HTMLButtonElement;
  private readonly number = el("span", { class: "number" });
  private readonly fill: HTMLElement | undefined;
  private shown = "";

  constructor(
    readonly key: string,
    label: string,
    private readonly gauge: Gauge,
    click: (key: string) => void,
  ) {
    this.fill = gauge.kind === "bar" ? el("span", { class: "fill" }) : undefined;
    const track = el("span", { class: this.fill ? "track" : "track none" }, ...(this.fill ? [this.fill] : []));
    this.element = el(
      "button",
      {
        type: "button",
        class: "value",
        title: `${label}: add it to the chart, or remove it`,
        click: () => click(key),
      },
      el("span", { class: "label", text: label }),
      track,
      this.number,
    );
    setPressed(this.element, false);
  }

  set(value: number | undefined, text: string): void {
    setText(this.number, text);
    if (!this.fill || this.gauge.kind !== "bar" || this.shown === text) return;
    this.shown = text;
    const [min, max] = this.gauge.range;
    const share = (at: number) => Math.min(1, Math.max(0, (at - min) / (max - min || 1)));
    // A range on both sides of zero is filled from the zero.
    const [zero, at] = [share(0), share(value ?? 0)];
    const known = value !== undefined && Number.isFinite(value);
    this.fill.style.left = `${100 * Math.min(zero, at)}%`;
    this.fill.style.width = known ? `${100 * Math.abs(at - zero)}%` : "0";
  }

  charted(on: boolean): void {
    setPressed(this.element, on);
  }
}
