/** The link and the control cycles in the robot panel. */
import { el, setClass, setText } from "../dom";
import type { LineStatus } from "../gen/baudbot/v1/world_pb";
import type { RobotRecord } from "../model/record";
import { messagesText } from "../model/quantities";
import { count, duration, fixed, numberOf } from "../model/units";
import { ValueRow } from "./value_row";

/** What can be lost on a line. */
const LOSSES: [keyof LineStatus & string, string][] = [
  ["corruptedBytes", "corrupted"],
  ["overrunBytes", "overrun"],
  ["refusedBytes", "refused"],
  ["lostBytes", "lost"],
  ["badFrames", "bad frames"],
  ["badMessages", "bad messages"],
];

export class LinkSection {
  readonly element: HTMLElement;
  readonly rows: ValueRow[];
  private readonly losses = el("dl", { class: "facts losses", test: "losses" });
  private readonly cells = new Map<string, HTMLElement>();
  private readonly messages = el("p", { class: "small" });
  private readonly cycles = el("dl", { class: "facts", test: "cycles" });
  private cycleText = "";

  constructor(
    private readonly record: RobotRecord,
    chart: (key: string) => void,
  ) {
    const most = this.bytesPerSecond ?? 2000;
    const bar = (key: string, label: string, range: [number, number]) =>
      new ValueRow(key, label, { kind: "bar", range }, chart);
    this.rows = [
      bar("rate:up", "up", [0, most]),
      bar("rate:down", "down", [0, most]),
      bar("waiting:up", "waiting up", [0, 64]),
      bar("waiting:down", "waiting down", [0, 64]),
    ];
    this.losses.append(
      el("dt", { text: "losses" }),
      el("dd", { class: "head", text: "up" }),
      el("dd", { class: "head", text: "down" }),
    );
    for (const [field, label] of LOSSES) {
      const [up, down] = [el("dd", { text: "0" }), el("dd", { text: "0" })];
      this.cells.set(`up.${field}`, up).set(`down.${field}`, down);
      this.losses.append(el("dt", { text: label }), up, down);
    }
    this.element = el(
      "div",
      {},
      ...this.rows.map((row) => row.element),
      this.messages,
      this.losses,
      el("h3", { text: "Control cycles" }),
      this.cycles,
    );
  }

  /** What the wire carries at most, if it has a baud rate. */
  private get bytesPerSecond(): number | undefined {
    const { baud, bitsPerCharacter } = this.record.description;
    return baud === undefined ? undefined : baud / (bitsPerCharacter ?? 10);
  }

  refresh(): void {
    const detail = this.record.now?.detail;
    for (const row of this.rows) {
      const value = this.record.values.get(row.key);
      row.set(value, this.text(row.key, value));
    }
    if (!detail) return;
    for (const [name, line] of [
      ["up", detail.uplink],
      ["down", detail.downlink],
    ] as const) {
      for (const [field] of LOSSES) {
        const cell = this.cells.get(`${name}.${field}`);
        const lost = (line?.[field] as bigint | undefined) ?? 0n;
        if (!cell) continue;
        setText(cell, count(lost));
        setClass(cell, "bad", lost > 0n);
      }
    }
    setText(this.messages, messagesText(detail.uplink?.messages ?? 0n, detail.downlink?.messages ?? 0n));
    this.refreshCycles();
  }

  private text(key: string, value: number | undefined): string {
    if (value === undefined) return "–";
    if (key.startsWith("waiting")) return `${count(value)} B`;
    const most = this.bytesPerSecond;
    const share = most ? ` ${fixed((100 * value) / most, 0)} %` : "";
    return `${count(Math.round(value))} B/s${share}`;
  }

  private refreshCycles(): void {
    const cycles = this.record.now?.detail?.cycles;
    if (!cycles) return;
    const { kept, late, unanswered, durations } = cycles;
    const all = numberOf(kept + late);
    const facts: [string, string, boolean][] = [
      ["deadline", duration(numberOf(cycles.deadlineNs)), false],
      ["in time", all > 0 ? `${count(kept)} (${fixed((100 * numberOf(kept)) / all, 1)} %)` : "0", false],
      ["late", count(late), late > 0n],
      ["unanswered", count(unanswered), false],
    ];
    if (durations)
      facts.push(
        ["median", duration(numberOf(durations.p50Ns)), false],
        ["95th percentile", duration(numberOf(durations.p95Ns)), false],
      );
    const text = facts.join();
    if (text === this.cycleText) return;
    this.cycleText = text;
    this.cycles.replaceChildren(
      ...facts.flatMap(([name, value, bad]) => [
        el("dt", { text: name }),
        el("dd", { text: value, class: bad ? "bad" : "" }),
      ]),
    );
  }
}
