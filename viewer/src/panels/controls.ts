/** The bar at the top: what the chosen world does, and what the operator can order. */
import { button, el, setPressed, setText, Throttle } from "../dom";
import { WorldState } from "../gen/baudbot/v1/world_pb";
import type { Store } from "../model/store";
import { clock, count, secondsOf } from "../model/units";
import { paceOf, type Orders, type PaceKind } from "../net/orders";
import type { RecordControl } from "./record_control";
import { stateWords } from "./words";

/** How often the time is written: more could not be read. */
const RATE_HZ = 10;

const PACES: [PaceKind, string][] = [
  ["realTime", "real time"],
  ["scaled", "× factor"],
  ["lockstep", "lockstep"],
  ["stepped", "stepped"],
  ["free", "free"],
];

export class Controls {
  readonly element: HTMLElement;
  private readonly name = el("strong", { class: "world-title" });
  private readonly pill = el("span", { class: "pill", test: "state" });
  private readonly time = el("span", { class: "time", test: "time", title: "Simulated time of the newest frame" });
  private readonly tick = el("span", { class: "tick" });
  /** Each change of a text is laid out by the browser. */
  private readonly throttle = new Throttle(1000 / RATE_HZ, () => this.showTime());
  private readonly run: HTMLButtonElement;
  private readonly pause: HTMLButtonElement;
  private readonly pace = el("select", { title: "Pace: how simulated time follows the wall clock", label: "Pace" });
  private readonly factor = el("input", {
    type: "number",
    class: "factor",
    title: "Simulated seconds per second",
    label: "Factor",
    attributes: { min: "0.01", step: "any" },
  });
  private readonly snapshots = el("select", {
    title: "Go back to a snapshot",
    label: "Snapshots",
    test: "snapshots",
  });

  /** What a replay cannot do. */
  private readonly live = el("div", { class: "group" });

  constructor(
    private readonly store: Store,
    private readonly orders: Orders,
    record: RecordControl,
  ) {
    this.run = button("▶ Run", "Run the world (space)", () => void orders.run(), {
      test: "run",
      class: "primary",
    });
    this.pause = button("❚❚ Pause", "Stop the world before its next tick (space)", () => void orders.pause(), {
      test: "pause",
    });
    const steps = [1, 10, 100].map((ticks) =>
      button(
        ticks === 1 ? "Step 1" : String(ticks),
        `Run ${ticks} ${ticks === 1 ? "tick (.)" : "ticks"}; the pace becomes stepped`,
        () => void orders.step(ticks),
        { test: ticks === 1 ? "step" : `step-${ticks}`, label: `Step ${ticks}` },
      ),
    );
    for (const [kind, text] of PACES) this.pace.append(el("option", { value: kind, text }));
    this.factor.value = "2";
    this.pace.addEventListener("change", () => this.setPace());
    this.factor.addEventListener("change", () => this.setPace());
    this.snapshots.addEventListener("change", () => this.restore());
    const group = (...children: Node[]) => el("div", { class: "group" }, ...children);
    this.element = el(
      "div",
      { class: "controls", role: "toolbar", label: "World" },
      el("div", { class: "world-now" }, this.name, this.pill, this.time, this.tick),
      group(this.run, this.pause),
      group(...steps),
      group(this.pace, this.factor),
      this.live,
      group(...record.elements),
    );
    this.live.append(
      button("Reset", "Take the world back to its start", () => void orders.reset(), { test: "reset" }),
      button("Snapshot", "Take a snapshot of the current state", () => void this.keep(), { test: "snapshot" }),
      this.snapshots,
    );
    store.on("worlds", () => this.refresh());
    store.on("world", () => this.refresh());
    store.on("frame", () => this.throttle.ask());
    this.refresh();
  }

  /** The time of the newest frame. */
  private showTime(): void {
    const { frame } = this.store;
    if (!frame) return;
    setText(this.time, clock(secondsOf(frame.timeNs)));
    setText(this.tick, `tick ${count(frame.tick)}`);
  }

  private setPace(): void {
    const kind = this.pace.value as PaceKind;
    const factor = Number(this.factor.value);
    this.factor.hidden = kind !== "scaled";
    if (kind === "scaled" && !(factor > 0)) return this.store.note("The factor must be positive.", "error");
    void this.orders.setPace(paceOf(kind, factor));
  }

  private async keep(): Promise<void> {
    await this.orders.snapshot();
    this.listSnapshots();
  }

  private restore(): void {
    if (this.snapshots.value !== "") void this.orders.restore(BigInt(this.snapshots.value));
    this.snapshots.value = "";
  }

  private refresh(): void {
    const { status, world, frame } = this.store;
    const { text, style } = stateWords(status);
    setText(this.name, world || "no world");
    setText(this.pill, text);
    this.pill.className = `pill ${style}`;
    this.element.classList.toggle("without-world", world === "");
    if (!frame) {
      setText(this.time, status ? clock(secondsOf(status.timeNs)) : "");
      setText(this.tick, "");
    }
    const runs = status?.state === WorldState.RUNNING;
    setPressed(this.run, runs);
    setPressed(this.pause, status?.state === WorldState.PAUSED);
    const kind = status?.pace?.kind;
    if (kind?.case && document.activeElement !== this.pace) this.pace.value = kind.case;
    if (kind?.case === "scaled" && document.activeElement !== this.factor)
      this.factor.value = String(kind.value.factor);
    this.factor.hidden = this.pace.value !== "scaled";
    this.listSnapshots();
    this.allow(status?.replay !== undefined);
    document.title = world ? `${world}: ${text} – baudbot` : "baudbot";
  }

  /** A replay waits for no brain, and does what was recorded. */
  private allow(isReplay: boolean): void {
    this.live.hidden = isReplay;
    for (const option of this.pace.options)
      option.disabled = isReplay && (option.value === "lockstep" || option.value === "free");
  }

  private listSnapshots(): void {
    const kept = this.orders.kept.get(this.store.world) ?? [];
    if (this.snapshots.childElementCount === kept.length + 1 && this.snapshots.dataset.world === this.store.world)
      return;
    this.snapshots.dataset.world = this.store.world;
    const title = kept.length > 0 ? `Back to… (${kept.length})` : "no snapshots";
    const options = kept.map((one) =>
      el("option", { value: String(one.snapshot), text: `#${one.snapshot} at ${clock(one.time_s)}` }),
    );
    this.snapshots.replaceChildren(el("option", { value: "", text: title }), ...options.reverse());
    this.snapshots.disabled = kept.length === 0;
  }
}
