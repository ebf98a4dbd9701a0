/** The time line of a replay, below the arena: where it is, what happened, and the ways to go elsewhere. */
import type { Theme } from "../arena/palette";
import { button, el, setText } from "../dom";
import { wordsAt } from "../model/replay";
import type { Store } from "../model/store";
import { clock, count, fixed, secondsOf } from "../model/units";
import type { Orders } from "../net/orders";
import type { Replayer } from "../net/replayer";
import { EventMarks } from "./event_marks";

const CUT_OFF = "The file is cut off; it is replayed as far as it goes.";
const FORK = "Continue from this tick as a live world, to which brains can attach. The recording does not change.";

export class ReplayBar {
  readonly element: HTMLElement;
  private readonly marks: EventMarks;
  private readonly slider = el("input", {
    type: "range",
    class: "replay-slider",
    label: "Time of the replay",
    test: "replay-slider",
    attributes: { step: "1", role: "slider" },
  });
  private readonly time = el("span", { class: "replay-time", test: "replay-time" });
  private readonly event = el("span", {
    class: "replay-event",
    test: "replay-event",
    attributes: { "aria-live": "polite" },
  });
  private readonly play: HTMLButtonElement;
  private readonly differs = el("p", { class: "differs", role: "alert", hidden: true, test: "replay-differs" });
  private readonly cutOff = el("p", { class: "cut-off", text: CUT_OFF, hidden: true, test: "replay-cut-off" });
  private isHeld = false;
  private shown: unknown;

  constructor(
    private readonly store: Store,
    private readonly orders: Orders,
    private readonly replayer: Replayer,
    film: () => void,
    theme: Theme,
  ) {
    this.marks = new EventMarks(replayer, (tick) => this.seconds(tick), theme);
    this.play = button("▶", "", () => void replayer.toggle(), { test: "replay-play", class: "primary" });
    const more = [
      button("Film…", "Save part of the replay as a film", film, { test: "film-open" }),
      button("Go on from here", FORK, () => void this.orders.fork(), { test: "replay-fork" }),
    ];
    this.element = el(
      "section",
      { class: "replay", label: "Replay", hidden: true, test: "replay-bar" },
      this.differs,
      this.marks.element,
      this.slider,
      el("div", { class: "replay-row" }, this.buttons(), this.time, this.event, el("div", { class: "tools" }, ...more)),
      this.cutOff,
    );
    this.listen();
    replayer.on("changed", () => this.refresh());
  }

  setTheme(theme: Theme): void {
    this.marks.setTheme(theme);
  }

  private buttons(): HTMLElement {
    const { replayer } = this;
    const made = (text: string, title: string, label: string, test: string, click: () => unknown) =>
      button(text, title, () => void click(), { label, test });
    return el(
      "div",
      { class: "group", role: "group", label: "Move through the replay" },
      made("|◂", "To its beginning", "To the beginning", "replay-first", () => replayer.seek(replayer.range.first)),
      made("◆◂", "Previous event (<)", "Previous event", "replay-previous-event", () => replayer.toEvent(-1)),
      made("◂", "One tick back (,)", "One tick back", "replay-back", () => replayer.step(-1)),
      this.play,
      made("▸", "One tick forward (.)", "One tick forward", "replay-forward", () => replayer.step(1)),
      made("▸◆", "Next event (>)", "Next event", "replay-next-event", () => replayer.toEvent(1)),
      made("▸|", "To its end", "To the end", "replay-last", () => replayer.seek(replayer.range.last)),
    );
  }

  private listen(): void {
    const { slider, replayer } = this;
    slider.addEventListener("pointerdown", () => {
      this.isHeld = true;
      void replayer.grab();
    });
    slider.addEventListener("input", () => void replayer.seek(BigInt(slider.value)));
    for (const kind of ["pointerup", "pointercancel"] as const) {
      slider.addEventListener(kind, () => {
        this.isHeld = false;
        void replayer.letGo();
      });
    }
  }

  private seconds(tick: bigint): number {
    return Number(tick) * secondsOf(this.store.description?.stepNs ?? this.store.status?.stepNs ?? 0n);
  }

  private refresh(): void {
    const { replayer, element } = this;
    element.hidden = !replayer.isOn;
    if (!replayer.isOn) return;
    const { tick, range } = replayer;
    const [min, max] = [String(range.first), String(range.last)];
    if (this.slider.min !== min || this.slider.max !== max) [this.slider.min, this.slider.max] = [min, max];
    if (!this.isHeld) this.slider.value = String(tick);
    const end = fixed(this.seconds(range.last), 2);
    setText(this.time, `${fixed(this.seconds(tick), 2)} / ${end} s`);
    this.time.title = `Tick ${count(tick)} of ${count(range.last)}`;
    const words = wordsAt(replayer.events, tick);
    this.slider.setAttribute("aria-valuetext", `${clock(this.seconds(tick))}${words && `, ${words}`}`);
    setText(this.event, words);
    this.event.title = words;
    setText(this.play, replayer.runs ? "❚❚" : "▶");
    this.play.title = replayer.runs ? "Stop (space)" : "Run (space)";
    this.play.setAttribute("aria-label", replayer.runs ? "Stop" : "Run");
    this.notices();
    // Marks stay where they are as long as events and ends do.
    const marks = `${min} ${max} ${replayer.description === undefined} ${this.store.world}`;
    if (marks !== this.shown) this.marks.draw();
    this.shown = marks;
  }

  private notices(): void {
    const differs = this.store.status?.replay?.differs ?? "";
    this.differs.hidden = differs === "";
    setText(this.differs, `The replay differs from the recording: ${differs}`);
    this.cutOff.hidden = !this.replayer.description?.cutOff;
  }
}
