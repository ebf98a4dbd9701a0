/** The bytes of a cable with their meaning, row by row. They are asked for only while this is open. */
import { button, el, setPressed, setText, Throttle } from "../dom";
import { CableLog, instantOf, MOST_ROWS, type CableRow } from "../model/cable_log";
import type { Store } from "../model/store";
import { count, duration } from "../model/units";
import { CableWatch } from "../net/cable_watch";
import type { Connection } from "../net/connection";

/** More often, rows are not added. */
const RATE_HZ = 10;

export class CablePanel {
  readonly element: HTMLElement;
  readonly watch: CableWatch;
  /** Called when it was opened or closed. */
  changed: () => void = () => {};
  private readonly log = new CableLog();
  private readonly robot = el("select", { label: "Robot of the cable", test: "cable-robot" });
  private readonly cable = el("select", { label: "Cable", test: "cable-choice" });
  private readonly direction = el("select", { label: "Direction", test: "cable-direction" });
  private readonly pause: HTMLButtonElement;
  private readonly follow: HTMLButtonElement;
  private readonly state = el("span", { class: "cable-state", role: "status", test: "cable-state" });
  private readonly list = el("ol", { class: "cable-rows", test: "cable-rows", attributes: { tabindex: "0" } });
  private readonly throttle = new Throttle(1000 / RATE_HZ, () => this.draw());
  private isFollowing = true;

  constructor(
    private readonly store: Store,
    connection: Connection,
  ) {
    this.watch = new CableWatch(
      connection,
      (response) => {
        this.log.take(response);
        this.throttle.ask();
      },
      () => this.throttle.ask(true),
    );
    this.pause = button(
      "Pause",
      "Hold the list still; whatever arrives meanwhile is skipped",
      () => this.togglePause(),
      {
        test: "cable-pause",
      },
    );
    this.follow = button("Newest", "Keep the newest row in view", () => this.setFollowing(!this.isFollowing));
    const clear = button("Clear", "Empty the list", () => this.clear(), { test: "cable-clear" });
    const close = button("×", "Close (y)", () => this.toggle(), { class: "quiet", label: "Close" });
    for (const [value, text] of [
      ["both", "both ways"],
      ["up", "↑ up"],
      ["down", "↓ down"],
    ] as const)
      this.direction.append(el("option", { value, text }));
    this.direction.addEventListener("change", () => (this.list.dataset.direction = this.direction.value));
    this.robot.addEventListener("change", () => this.fillCables());
    this.cable.addEventListener("change", () => this.begin());
    const head = el(
      "div",
      { class: "panel-head" },
      el("h2", { text: "Cable" }),
      this.robot,
      this.cable,
      this.direction,
      this.state,
      el("div", { class: "tools" }, this.pause, this.follow, clear, close),
    );
    this.element = el(
      "section",
      { class: "cable-panel", label: "Cable", test: "cable-panel", hidden: true },
      head,
      this.list,
    );
    this.list.dataset.direction = "both";
    setPressed(this.pause, false);
    setPressed(this.follow, true);
    store.on("world", () => this.isOpen && this.fillRobots());
  }

  get isOpen(): boolean {
    return !this.element.hidden;
  }

  toggle(): void {
    this.element.hidden = !this.element.hidden;
    if (this.isOpen) this.fillRobots();
    else this.watch.close();
    this.changed();
  }

  /** The robots of the world, of which the chosen one comes first into view. */
  private fillRobots(): void {
    const robots = this.store.description?.robots ?? [];
    this.robot.replaceChildren(...robots.map(({ robot }) => el("option", { value: robot, text: robot })));
    this.robot.value = this.store.robot;
    this.fillCables();
  }

  /** The cables of the robot: its own, and those of its sensors. */
  private fillCables(): void {
    const found = this.store.description?.robots.find(({ robot }) => robot === this.robot.value);
    const own = found?.description?.onboard ? [] : [["", "robot"] as const];
    const sensors = found?.description?.sensors.filter((sensor) => sensor.port !== undefined) ?? [];
    const cables = [...own, ...sensors.map(({ sensor }) => [sensor, `port of ${sensor}`] as const)];
    this.cable.replaceChildren(...cables.map(([value, text]) => el("option", { value, text })));
    this.begin();
  }

  private begin(): void {
    this.log.reset();
    this.list.replaceChildren();
    const { world } = this.store;
    if (world === "" || this.robot.value === "" || this.cable.options.length === 0) this.watch.close();
    else this.watch.open({ world, robot: this.robot.value, sensor: this.cable.value });
  }

  private togglePause(): void {
    this.log.setPaused(!this.log.isPaused);
    setPressed(this.pause, this.log.isPaused);
    this.throttle.ask(true);
  }

  private setFollowing(on: boolean): void {
    this.isFollowing = on;
    setPressed(this.follow, on);
    this.throttle.ask(true);
  }

  private clear(): void {
    this.log.clear();
    this.list.replaceChildren();
    this.throttle.ask(true);
  }

  /** Adds the rows that are not there yet, and takes away those that are forgotten. */
  private draw(): void {
    const { rows } = this.log;
    const last = Number((this.list.lastElementChild as HTMLElement | null)?.dataset.number ?? 0);
    const first = rows[0]?.number ?? Infinity;
    while (Number((this.list.firstElementChild as HTMLElement | null)?.dataset.number ?? Infinity) < first)
      this.list.firstElementChild?.remove();
    this.list.append(...rows.filter((row) => row.number > last).map(rowElement));
    setText(this.state, this.stateText());
    if (this.isFollowing) this.list.scrollTop = this.list.scrollHeight;
  }

  private stateText(): string {
    const { state } = this.watch;
    const { missed, passed, isPaused, rows } = this.log;
    if (state instanceof Error) return state.message;
    if (state === "off") return "this robot has no cable";
    const parts = [
      isPaused ? `paused, ${count(passed)} skipped` : "",
      missed > 0 ? `${count(missed)} missed` : "",
      rows.length === 0 && !isPaused ? "nothing yet" : "",
      rows.length === MOST_ROWS ? `the last ${count(MOST_ROWS)}` : "",
    ];
    return parts.filter((part) => part !== "").join(", ");
  }
}

function rowElement(row: CableRow): HTMLElement {
  const age = row.age_ns === undefined ? "" : duration(row.age_ns);
  return el(
    "li",
    {
      class: `${row.isDown ? "down" : "up"}${row.understood ? "" : " odd"}`,
      attributes: { "data-number": String(row.number) },
    },
    el("span", { class: "at", text: instantOf(row), title: "Simulated time of its last byte, in ms" }),
    el("span", { class: "way", text: row.isDown ? "↓" : "↑", title: row.isDown ? "to the robot" : "from the robot" }),
    el("code", { class: "hex", text: row.hex, title: row.hex }),
    el("span", { class: "says", text: row.text, title: row.text }),
    el("span", { class: "age", text: age, title: age && "Age of its oldest reading when its last byte arrived" }),
  );
}
