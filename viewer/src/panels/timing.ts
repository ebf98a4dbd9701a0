/** The panel with the timing diagram: what part of time it shows, and what the mouse is on. */
import type { Theme } from "../arena/palette";
import { button, el, setPressed, setText, surface } from "../dom";
import type { Store } from "../model/store";
import { duration, exactMs, numberOf } from "../model/units";
import { lastCycle, type Cycle } from "../timing/cycle";
import { draw, heightOf, rowFor, type Spot } from "../timing/draw";
import { lanes, MOST_STEPS, what, windowFor, type Lane, type Window } from "../timing/layout";
import { pinLanes } from "../timing/pins";
import type { CablePanel } from "./cable";

/** Pictures per second: more could not be read. */
const RATE_HZ = 4;

export class TimingPanel {
  readonly element: HTMLElement;
  private readonly canvas = el("canvas", {
    class: "timing-canvas",
    test: "timing-canvas",
    role: "img",
    label: "Timing diagram",
  });
  private readonly tip = el("div", { class: "tip", hidden: true, role: "tooltip" });
  private readonly verdict = el("span", { class: "verdict" });
  private readonly span = el("span", { class: "span" });
  private readonly hold: HTMLButtonElement;
  private readonly pins: HTMLButtonElement;
  private readonly scroller: HTMLElement;
  private spots: Spot[] = [];
  /** Δt that are shown; 0: as many as the cycle needs. */
  private steps = 0;
  private isHeld = false;
  private isHovered = false;
  private drawn_ms = 0;
  private isAsked = false;

  constructor(
    private readonly store: Store,
    private theme: Theme,
    cable: CablePanel,
  ) {
    const bytes = button("Bytes", "The bytes of a cable, with their meaning (y)", () => cable.toggle(), {
      test: "bytes",
    });
    setPressed(bytes, false);
    cable.changed = () => setPressed(bytes, cable.isOpen);
    this.hold = button("Hold", "Keep this picture (it also stays while the mouse is over it)", () =>
      this.setHeld(!this.isHeld),
    );
    this.pins = button("Pins", "What is on the pins of the chip", () => store.showPins(!store.showsPins), {
      test: "pins",
    });
    const tools = [
      this.pins,
      button("−", "Longer: more Δt", () => this.setSteps(1), { label: "Longer" }),
      this.span,
      button("+", "Shorter: fewer Δt", () => this.setSteps(-1), { label: "Shorter" }),
      button("Auto", "As long as the cycle", () => this.setSteps(0)),
      this.hold,
      bytes,
    ];
    const head = el(
      "div",
      { class: "panel-head" },
      el("h2", { text: "Timing" }),
      this.verdict,
      el("div", { class: "tools" }, ...tools),
    );
    this.scroller = el("div", { class: "timing-scroll" }, this.canvas, this.tip);
    this.element = el("section", { class: "panel timing", label: "Timing diagram" }, head, this.scroller);
    this.canvas.addEventListener("pointermove", (event) => this.hover(event));
    this.canvas.addEventListener("pointerleave", () => this.leave());
    new ResizeObserver(() => this.refresh(true)).observe(this.scroller);
    store.on("frame", () => this.refresh(false));
    store.on("robot", () => this.refresh(true));
    store.on("pins", () => this.refresh(true));
    setPressed(this.hold, false);
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.refresh(true);
  }

  private setSteps(change: number): void {
    const shown = this.steps || Number(this.span.dataset.steps ?? 3);
    const by = change * Math.max(1, Math.round(shown / 8));
    this.steps = change === 0 ? 0 : Math.min(MOST_STEPS, Math.max(1, shown + by));
    this.refresh(true);
  }

  private setHeld(on: boolean): void {
    this.isHeld = on;
    setPressed(this.hold, on);
  }

  /** Draws when it is time for it. */
  private refresh(now: boolean): void {
    if (this.isAsked || (!now && (this.isHeld || this.isHovered))) return;
    const wait_ms = now ? 0 : Math.max(0, this.drawn_ms + 1000 / RATE_HZ - performance.now());
    this.isAsked = true;
    setTimeout(() => {
      this.isAsked = false;
      requestAnimationFrame(() => this.draw());
    }, wait_ms);
  }

  private draw(): void {
    const { store, theme } = this;
    this.drawn_ms = performance.now();
    const width = this.scroller.clientWidth;
    const { record, description } = store;
    if (width === 0) return;
    const robot = record?.description;
    if (!record || !robot || !description) return void surface(this.canvas, 1, 1);
    const all = record.timeline.happenings;
    const step_ns = Math.max(1, numberOf(description.stepNs));
    const deadline_ns = numberOf(description.robots[record.robot]?.deadlineNs ?? 0n) || step_ns;
    const cycle = lastCycle(all);
    const window = windowFor(cycle, numberOf(store.frame?.timeNs ?? 0n), step_ns, this.steps);
    const room = this.scroller.clientHeight;
    this.pins.hidden = !store.hasChip;
    setPressed(this.pins, store.showsPins);
    const pins = store.hasChip && store.showsPins ? this.pinLanes(window, width) : undefined;
    const full = lanes(robot, all, window, cycle, undefined, pins);
    const shown = heightOf(full) <= room ? full : lanes(robot, all, window, cycle, 1, pins);
    const row = rowFor(shown, room);
    const height = heightOf(shown, row);
    this.canvas.style.height = `${height}px`;
    const context = surface(this.canvas, width, height);
    this.spots = draw({ context, width, height, theme, window, lanes: shown, cycle, step_ns, deadline_ns, row });
    const steps = Math.round((window.until_ns - window.from_ns) / 1.1 / step_ns) || 1;
    this.span.dataset.steps = String(Math.min(MOST_STEPS, steps));
    setText(this.span, `${steps} Δt`);
    this.judge(cycle, deadline_ns);
  }

  private pinLanes(window: Window, width: number): Lane[] {
    const { record, description, frame } = this.store;
    const signals = record && description?.robots[record.robot]?.pins;
    if (!record || !signals) return [];
    const now_ns = Math.min(numberOf(frame?.timeNs ?? 0n), window.until_ns);
    // Names take about a fifth of the picture.
    const px_ns = (window.until_ns - window.from_ns) / (0.8 * width);
    return pinLanes(signals, record.pins, window, now_ns, px_ns);
  }

  private judge(cycle: Cycle | undefined, deadline_ns: number): void {
    if (!cycle) {
      setText(
        this.verdict,
        this.store.hasChip
          ? "a program of its own"
          : this.store.record?.now?.detail?.attached
            ? "no answered cycle yet"
            : "no brain is attached",
      );
      this.verdict.className = "verdict";
      return;
    }
    const took_ns = cycle.obeyed_ns - cycle.begun_ns;
    const isLate = took_ns > deadline_ns;
    const words = `cycle ${duration(took_ns)}, ${isLate ? "late" : "in time"}`;
    this.verdict.title = `The last answered cycle took ${duration(took_ns)}; its deadline is ${duration(deadline_ns)}`;
    setText(this.verdict, words);
    this.verdict.className = isLate ? "verdict bad" : "verdict good";
  }

  private hover(event: PointerEvent): void {
    this.isHovered = event.pointerType === "mouse";
    const [x, y] = [event.offsetX, event.offsetY];
    const spot = this.spots.findLast(
      (spot) => x >= spot.x && x <= spot.x + spot.width && y >= spot.y && y <= spot.y + spot.height,
    );
    this.tip.hidden = !spot;
    const robot = this.store.record?.description;
    if (!spot || !robot) return;
    const { start_ns, end_ns } = spot.bar.event;
    const times =
      end_ns === start_ns
        ? `at ${exactMs(start_ns)} ms`
        : `${exactMs(start_ns)} to ${exactMs(end_ns)} ms, ${duration(end_ns - start_ns)}`;
    setText(this.tip, `${spot.bar.tip ?? what(robot, spot.bar.event)}: ${times}`);
    const left = Math.min(x + 12, Math.max(0, this.scroller.clientWidth - this.tip.offsetWidth - 4));
    this.tip.style.left = `${left}px`;
    this.tip.style.top = `${y + 34 > this.canvas.clientHeight ? y - 30 : y + 14}px`;
  }

  private leave(): void {
    this.isHovered = false;
    this.tip.hidden = true;
    this.refresh(false);
  }
}
