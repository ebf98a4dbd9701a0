/** The list of worlds, and what the referee counted in the chosen one. */
import { button, el, setText } from "../dom";
import type { WorldStatus } from "../gen/baudbot/v1/world_pb";
import type { Store } from "../model/store";
import { clock, count, fixed, secondsOf } from "../model/units";
import { paceWords, type Orders } from "../net/orders";
import type { RecordingsSection } from "./recordings";
import { stateWords } from "./words";

interface Row {
  element: HTMLElement;
  name: HTMLElement;
  pill: HTMLElement;
  line: HTMLElement;
}

export class WorldsPanel {
  readonly element: HTMLElement;
  private readonly list = el("ul", { class: "world-list", test: "world-list", label: "Worlds" });
  private readonly empty = el("p", { class: "hint", test: "no-worlds" });
  private readonly about = el("p", { class: "about" });
  private readonly score = el("dl", { class: "facts" });
  private readonly bumps = el("ol", { class: "bumps", label: "Last collisions" });
  private readonly rows = new Map<string, Row>();
  private told: string[] = [];
  private bumpsShown: unknown;

  constructor(
    private readonly store: Store,
    private readonly orders: Orders,
    recordings: RecordingsSection,
    create: () => void,
  ) {
    const add = button("New world…", "Make a world from a scenario", create, { test: "new-world" });
    this.element = el(
      "section",
      { class: "panel worlds", label: "Worlds" },
      el("div", { class: "panel-head" }, el("h2", { text: "Worlds" }), el("div", { class: "tools" }, add)),
      el("div", { class: "scroll" }, this.list, this.empty, this.about, this.score, this.bumps, recordings.element),
    );
    store.on("worlds", () => this.refresh());
    store.on("world", () => this.refresh());
    setInterval(() => this.facts(), 500);
  }

  private refresh(): void {
    const { worlds } = this.store;
    const names = new Set(worlds.map((status) => status.world));
    for (const [name, row] of this.rows) {
      if (names.has(name)) continue;
      row.element.remove();
      this.rows.delete(name);
    }
    worlds.forEach((status, i) => {
      const row = this.rows.get(status.world) ?? this.makeRow(status.world);
      if (this.list.children[i] !== row.element) this.list.insertBefore(row.element, this.list.children[i] ?? null);
      this.fill(row, status);
    });
    setText(this.empty, this.store.hidden || "This server has no worlds. Make one from a scenario.");
    this.empty.hidden = worlds.length > 0;
    this.facts();
  }

  private makeRow(world: string): Row {
    const name = el("strong", { text: world });
    const [pill, line] = [el("span", { class: "pill" }), el("span", { class: "world-line" })];
    const choose = el(
      "button",
      { type: "button", class: "world-choose", title: `Look at ${world}`, click: () => this.orders.choose(world) },
      el("span", { class: "world-name" }, name, pill),
      line,
    );
    const remove = button(
      "×",
      `Delete ${world}`,
      () => {
        if (confirm(`Delete the world “${world}”? Its brains' streams end.`)) void this.orders.delete(world);
      },
      { class: "quiet", label: `Delete ${world}` },
    );
    const row = { element: el("li", {}, choose, remove), name, pill, line };
    this.rows.set(world, row);
    return row;
  }

  private fill(row: Row, status: WorldStatus): void {
    const { text, style } = stateWords(status);
    setText(row.pill, status.replay ? "replay" : text);
    row.pill.className = `pill ${status.replay ? "replays" : style}`;
    const robots = `${count(status.robots.length)} ${status.robots.length === 1 ? "robot" : "robots"}`;
    setText(
      row.line,
      `${clock(secondsOf(status.timeNs))} · tick ${count(status.tick)} · ${paceWords(status.pace)} · ${robots}`,
    );
    const isChosen = status.world === this.store.world;
    row.element.classList.toggle("chosen", isChosen);
    row.element.firstElementChild?.setAttribute("aria-current", String(isChosen));
  }

  /** What there is to tell of the chosen world besides. */
  private facts(): void {
    const { description, frame, status } = this.store;
    const ending = frame?.rest.ending || status?.ending || "";
    setText(this.about, ending ? `The run ended because ${ending}.` : (description?.description ?? ""));
    this.about.classList.toggle("ending", ending !== "");
    const score = frame?.rest.score ?? status?.score;
    const facts: [string, string][] = [];
    if (score?.covered !== undefined) facts.push(["floor covered", `${fixed(100 * score.covered, 1)} %`]);
    if (score?.sensed !== undefined) facts.push(["floor sensed", `${fixed(100 * score.sensed, 1)} %`]);
    if (score && score.goals > 0) facts.push(["goals reached", `${score.goalsReached} of ${score.goals}`]);
    for (const zone of score?.zones.slice(0, 12) ?? [])
      facts.push([zone.zone, zone.visited ? "visited" : "not visited"]);
    this.tell(facts);
    if (this.bumpsShown === this.store.bumps) return;
    this.bumpsShown = this.store.bumps;
    const last = this.store.bumps.slice(-8).reverse();
    this.bumps.replaceChildren(
      ...last.map((bump) => el("li", { text: `${clock(bump.time_s)}  ${bump.robot} × ${bump.with}` })),
    );
  }

  /** Makes the list of facts again if there is another one: while a world stands nothing is laid out. */
  private tell(facts: [string, string][]): void {
    const words = facts.flat();
    if (words.length === this.told.length && words.every((word, i) => word === this.told[i])) return;
    this.told = words;
    this.score.replaceChildren(
      ...facts.flatMap(([name, value]) => [el("dt", { text: name }), el("dd", { text: value })]),
    );
  }
}
