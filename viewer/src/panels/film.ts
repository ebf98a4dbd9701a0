/** The dialog that makes a film of a replay: what of it, how fast, and how far it is. */
import type { Arena } from "../arena/arena";
import { button, download, el, setText } from "../dom";
import { encoderFor, hasVideo, shoot, TYPES, type Format } from "../film/film";
import { planFilm } from "../film/plan";
import { ReplayProjector } from "../film/projector";
import { scaledView, Stage } from "../film/stage";
import type { Store } from "../model/store";
import { bytesText, count, fixed, secondsOf } from "../model/units";
import type { Connection } from "../net/connection";
import type { Orders } from "../net/orders";
import type { Replayer } from "../net/replayer";
import type { Surveyor } from "../net/surveyor";
import type { Watcher } from "../net/watcher";

/** What a film is made with. */
export interface FilmTools {
  store: Store;
  connection: Connection;
  watcher: Watcher;
  surveyor: Surveyor;
  orders: Orders;
  replayer: Replayer;
  arena: Arena;
}

export class FilmDialog {
  readonly element: HTMLDialogElement;
  private readonly format = el("select", { label: "Format", test: "film-format" });
  private readonly from = field("From, in s", "film-from", "0");
  private readonly to = field("To, in s", "film-to", "0");
  private readonly speed = field("Simulated seconds per second", "film-speed", "1");
  private readonly fps = field("Pictures per second", "film-fps", "20");
  private readonly width = field("Width in pixels", "film-width", "800");
  private readonly progress = el("progress", { label: "Progress", hidden: true, attributes: { max: "1" } });
  private readonly state = el("p", { class: "hint", role: "status", test: "film-state" });
  private readonly error = el("p", { class: "error", role: "alert", test: "film-error" });
  private readonly make: HTMLButtonElement;
  private under: AbortController | undefined;

  constructor(private readonly tools: FilmTools) {
    this.format.append(el("option", { value: "gif", text: "GIF" }));
    if (hasVideo()) this.format.prepend(el("option", { value: "webm", text: "WebM" }));
    this.format.selectedIndex = 0;
    this.make = button("Make it", "Run the replay and make the film", () => void this.run(), {
      class: "primary",
      test: "film-make",
    });
    const cancel = button("Cancel", "Stop, and close (Escape)", () => this.close(), { test: "film-cancel" });
    const labelled = (text: string, input: HTMLElement) => el("label", {}, `${text} `, input);
    const row = (...children: Node[]) => el("div", { class: "dialog-row" }, ...children);
    this.element = el(
      "dialog",
      { class: "film", label: "Film", test: "film" },
      el("h2", { text: "Save as a film" }),
      row(labelled("Format", this.format), labelled("Width", this.width)),
      row(labelled("From", this.from), labelled("to", this.to)),
      row(labelled("Speed ×", this.speed), labelled("Pictures/s", this.fps)),
      el("p", { class: "hint", text: "It shows what the arena shows now, with the same layers." }),
      this.progress,
      this.state,
      this.error,
      el("div", { class: "dialog-row end" }, cancel, this.make),
    );
    this.element.addEventListener("cancel", () => this.under?.abort(new Error("cancelled")));
  }

  show(): void {
    const { first, last } = this.tools.replayer.range;
    this.from.value = fixed(Number(first) * this.step_s, 2);
    this.to.value = fixed(Number(last) * this.step_s, 2);
    setText(this.state, "");
    setText(this.error, "");
    this.element.showModal();
  }

  private get step_s(): number {
    return secondsOf(this.tools.store.description?.stepNs ?? 0n);
  }

  private close(): void {
    this.under?.abort(new Error("cancelled"));
    this.element.close();
  }

  private async run(): Promise<void> {
    const under = new AbortController();
    this.under = under;
    this.make.disabled = true;
    this.progress.hidden = false;
    setText(this.error, "");
    const { replayer } = this.tools;
    const tick = replayer.tick;
    try {
      const film = await this.shoot(under.signal);
      const format = this.format.value as Format;
      download(film, TYPES[format], `${this.tools.store.world}.${format}`);
      setText(this.state, `Done: ${bytesText(film.length)}.`);
    } catch (error) {
      setText(this.error, error instanceof Error ? error.message : String(error));
    } finally {
      this.make.disabled = false;
      this.progress.hidden = true;
      this.under = undefined;
      await replayer.seek(tick);
    }
  }

  private async shoot(signal: AbortSignal): Promise<Uint8Array> {
    const { store, connection, watcher, surveyor, orders, replayer, arena } = this.tools;
    const wish = {
      from_s: Number(this.from.value),
      to_s: Number(this.to.value),
      speed: Number(this.speed.value),
      fps: Number(this.fps.value),
    };
    const ticks = planFilm(replayer.range, this.step_s, wish);
    if (replayer.runs) await orders.pause();
    const width = Math.min(3840, Math.max(64, Number(this.width.value) || 800));
    const view = scaledView(arena.view, width);
    return shoot({
      ticks,
      fps: wish.fps,
      projector: new ReplayProjector(connection, store, watcher, surveyor),
      stage: new Stage(store, arena.look, view),
      encoder: await encoderFor(this.format.value as Format, view, wish.fps),
      signal,
      progress: (done, all) => {
        this.progress.value = done / all;
        setText(this.state, `${count(done)} of ${count(all)} pictures`);
      },
    });
  }
}

function field(title: string, test: string, value: string): HTMLInputElement {
  return el("input", {
    type: "number",
    class: "factor",
    title,
    label: title,
    test,
    value,
    attributes: { step: "any", min: "0" },
  });
}
