/** The panel of the chosen robot. Made anew for each robot; its numbers change ten times a second. */
import type { Theme } from "../arena/palette";
import { el, setText, Throttle } from "../dom";
import { labelOf } from "../model/quantities";
import type { RobotRecord } from "../model/record";
import type { Store } from "../model/store";
import { brief, degrees, fixed, short, withUnit } from "../model/units";
import type { ChartPanel } from "./chart";
import type { HandSection } from "./hand";
import { LinkSection } from "./link";
import { SensorRows } from "./sensor_rows";
import { ValueRow } from "./value_row";

const RATE_HZ = 10;
/** Sensors that have rows; more would not be looked at. */
const MOST_SENSORS = 64;
/** Characters of what a brain says that it does: anybody may attach one, and everybody sees it. */
const MOST_STATE = 200;
const MOST_NAME = 40;

export class RobotPanel {
  readonly element: HTMLElement;
  private readonly choice = el("select", { title: "Robot ([ and ])", label: "Robot", test: "robot-select" });
  private readonly pose = el("p", { class: "pose small" });
  private readonly brain = el("p", { class: "brain small" });
  private readonly body = el("div", { class: "scroll" });
  private sensors: SensorRows[] = [];
  private link: LinkSection | undefined;
  private rows: ValueRow[] = [];
  private readonly utilities = el("div", {});
  private readonly utilityRows = new Map<string, ValueRow>();
  private readonly state = el("p", { class: "small" });
  private readonly throttle = new Throttle(1000 / RATE_HZ, () => this.refresh());

  constructor(
    private readonly store: Store,
    private readonly chart: ChartPanel,
    private readonly hand: HandSection,
    private theme: Theme,
  ) {
    this.choice.addEventListener("change", () => store.chooseRobot(this.choice.value));
    const head = el("div", { class: "panel-head" }, el("h2", { text: "Robot" }), this.choice, this.brain);
    this.element = el("section", { class: "panel robot", test: "robot-panel", label: "Robot" }, head, this.body);
    store.on("world", () => this.listRobots());
    store.on("robot", () => this.rebuild());
    store.on("frame", () => this.throttle.ask());
    chart.changed = () => this.markCharted();
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.refresh();
  }

  private listRobots(): void {
    const robots = this.store.description?.robots ?? [];
    this.choice.replaceChildren(...robots.map(({ robot }) => el("option", { value: robot, text: robot })));
    this.choice.disabled = robots.length === 0;
  }

  private rebuild(): void {
    this.choice.value = this.store.robot;
    const { record } = this.store;
    this.sensors = [];
    this.rows = [];
    this.link = undefined;
    this.utilityRows.clear();
    this.utilities.replaceChildren();
    this.body.replaceChildren();
    if (!record) return void this.body.append(el("p", { class: "hint", text: "No robot is selected." }));
    const chart = (key: string) => this.chart.toggle(key);
    this.rows = motorRows(record, chart);
    this.sensors = record.description.sensors.slice(0, MOST_SENSORS).map((_, i) => new SensorRows(record, i, chart));
    this.link = new LinkSection(record, chart);
    this.hand.reset();
    const { baud, onboard } = record.description;
    const wire = onboard ? "on board" : baud === undefined ? "no baud rate" : `${baud} baud`;
    this.body.append(
      this.hand.element,
      this.pose,
      section("Sensors", ...this.sensors.map((sensor) => sensor.element)),
      section("Motors and body", ...this.rows.map((row) => row.element)),
      section("Behaviour", this.state, this.utilities),
      section(`Link, ${wire}`, this.link.element),
    );
    this.markCharted();
    this.refresh();
  }

  private markCharted(): void {
    const { keys } = this.chart;
    for (const row of this.allRows()) row.charted(keys.includes(row.key));
    for (const sensor of this.sensors) sensor.charted(keys);
  }

  private allRows(): ValueRow[] {
    return [...this.rows, ...(this.link?.rows ?? []), ...this.utilityRows.values()];
  }

  private refresh(): void {
    const { record } = this.store;
    if (!record || this.element.offsetParent === null) return;
    const truth = record.now?.truth;
    // That it has a battery is known with its first frame.
    if (truth?.battery && !this.rows.some((row) => row.key === "battery:charge")) return this.rebuild();
    if (truth)
      setText(
        this.pose,
        `x ${fixed(truth.xM, 3)} m   y ${fixed(truth.yM, 3)} m   heading ${degrees(truth.headingRad)}`,
      );
    const detail = record.now?.detail;
    setText(this.brain, detail?.attached ? `brain: ${detail.brain || "unnamed"}` : "no brain is attached");
    for (const row of this.rows) {
      const value = record.values.get(row.key);
      row.set(value, value === undefined ? "–" : bodyText(row.key, value));
    }
    for (const sensor of this.sensors) sensor.refresh(this.theme.robot, this.theme.gridStrong);
    this.link?.refresh();
    this.refreshBelief(record);
    this.hand.refresh();
  }

  private refreshBelief(record: RobotRecord): void {
    const belief = this.store.beliefs.get(record.robot);
    setText(
      this.state,
      belief ? brief(belief.state, MOST_STATE) || "publishes no state" : "The brain publishes nothing.",
    );
    this.state.classList.toggle("belief-text", belief !== undefined);
    const utilities = belief?.utilities.slice(0, 32) ?? [];
    this.dropUtilities(new Set(utilities.map((utility) => utility.name)));
    for (const utility of utilities) {
      const row = this.utilityRows.get(utility.name) ?? this.makeUtility(utility.name);
      row.set(utility.value, short(utility.value));
      row.element.classList.toggle("active", utility.active);
    }
  }

  /** Those that the brain does not name any more. */
  private dropUtilities(named: Set<string>): void {
    for (const [name, row] of this.utilityRows) {
      if (named.has(name)) continue;
      row.element.remove();
      this.utilityRows.delete(name);
    }
  }

  private makeUtility(name: string): ValueRow {
    const row = new ValueRow(`utility:${name}`, brief(name, MOST_NAME), { kind: "bar", range: [0, 1] }, (key) =>
      this.chart.toggle(key),
    );
    row.charted(this.chart.keys.includes(row.key));
    this.utilityRows.set(name, row);
    this.utilities.append(row.element);
    return row;
  }
}

function section(title: string, ...children: Node[]): HTMLElement {
  return el("details", { class: "section", attributes: { open: "" } }, el("summary", { text: title }), ...children);
}

function motorRows(record: RobotRecord, chart: (key: string) => void): ValueRow[] {
  const limit = record.description.signalLimit ?? 1;
  const bar = (key: string, range: [number, number], label = labelOf(key)) =>
    new ValueRow(key, label, { kind: "bar", range }, chart);
  const plain = (key: string, label = labelOf(key)) => new ValueRow(key, label, { kind: "none" }, chart);
  const truth = record.now?.truth;
  return [
    bar("signal:left", [-limit, limit]),
    bar("signal:right", [-limit, limit]),
    ...record.description.actuators.map(({ actuator }) => bar(`actuator:${actuator}`, [-1, 1], actuator)),
    plain("speed"),
    plain("turn"),
    plain("pose:x"),
    plain("pose:y"),
    plain("pose:heading"),
    ...(truth?.battery
      ? [bar("battery:charge", [0, 1], "battery charge"), plain("battery:voltage"), plain("battery:current")]
      : []),
  ];
}

function bodyText(key: string, value: number): string {
  if (key === "battery:charge") return `${fixed(100 * value, 1)} %`;
  if (key === "pose:heading") return degrees(value);
  if (key === "speed") return `${fixed(value, 3)} m/s`;
  if (key === "turn") return `${fixed(value, 3)} rad/s`;
  const units: Record<string, string> = {
    "pose:x": "m",
    "pose:y": "m",
    "battery:voltage": "V",
    "battery:current": "A",
  };
  return withUnit(value, units[key] ?? "");
}
