/** The line at the bottom: how the connection is and how much comes over it; and notes, which go by themselves. */
import { el, setText } from "../dom";
import type { Store } from "../model/store";
import { count, fixed } from "../model/units";
import type { Connection } from "../net/connection";
import type { Watcher } from "../net/watcher";

const NOTE_MS = 5000;
const ERROR_MS = 12_000;
const MOST_NOTES = 4;

export class StatusBar {
  readonly element = el("footer", { class: "status", label: "Status" });
  /** Over the page. */
  readonly notes = el("div", { class: "notes", role: "status", attributes: { "aria-live": "polite" } });
  readonly banner = el("div", { class: "banner", hidden: true, role: "alert", test: "banner" });
  private readonly link = el("span", { class: "link", test: "connection" });
  private readonly parts = ["frames", "missed", "speed", "robots", "let-go"].map((name) =>
    el("span", { class: `part ${name}`, test: `status-${name}` }),
  );

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
    private readonly watcher: Watcher,
  ) {
    this.element.append(this.link, ...this.parts);
    store.on("note", ({ text, kind }) => this.note(text, kind === "error"));
    setInterval(() => this.refresh(), 500);
    this.refresh();
  }

  refresh(): void {
    const { link } = this.connection;
    const isOpen = link.state === "open";
    setText(this.link, isOpen ? "connected" : link.state);
    this.link.className = `link ${link.state}`;
    this.banner.hidden = isOpen;
    const wait_s = link.state === "waiting" ? Math.max(0, Math.ceil((link.retryAt - Date.now()) / 1000)) : 0;
    setText(
      this.banner,
      wait_s > 0 ? `No connection to the server. Trying again in ${wait_s} s.` : "Connecting to the server…",
    );
    const { frame, description, status } = this.store;
    const letGo_s = Number(status?.pacing?.letGoWallNs ?? 0n) / 1e9;
    const missed = frame?.rest.missedFrames ?? 0n;
    const texts = [
      `${fixed(this.watcher.frames_per_s, 0)} frames/s`,
      `${count(missed)} missed`,
      `${fixed(this.watcher.speed, 2)} × real time`,
      description ? `${count(description.robots.length)} ${description.robots.length === 1 ? "robot" : "robots"}` : "",
      letGo_s > 0 ? `${fixed(letGo_s, 1)} s dropped` : "",
    ];
    this.parts.forEach((part, i) => setText(part, texts[i] ?? ""));
  }

  private note(text: string, isError: boolean): void {
    const note = el(
      "div",
      { class: isError ? "note bad" : "note", test: isError ? "error" : "note" },
      el("span", { text }),
    );
    const close = el("button", {
      type: "button",
      class: "quiet",
      text: "×",
      title: "Close",
      label: "Close this note",
      click: () => note.remove(),
    });
    note.append(close);
    this.notes.append(note);
    while (this.notes.childElementCount > MOST_NOTES) this.notes.firstElementChild?.remove();
    setTimeout(() => note.remove(), isError ? ERROR_MS : NOTE_MS);
  }
}
