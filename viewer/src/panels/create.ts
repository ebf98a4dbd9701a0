/** The dialog that makes a world from a scenario: an editor that marks the line that the server objects to. */
import { button, el, setText } from "../dom";
import type { Orders } from "../net/orders";
import { bytesText } from "../model/units";
import { isMcap, lineOf } from "./words";

/** Height of a line of the editor, in pixels; as in the style sheet. */
const LINE = 18;

const TEMPLATE = `name = "room"
description = "A room, a pillar, and a robot with two IR sensors"
step_ms = 10.0
collision = "stop-robot"

[[arena.polygons]]
name = "wall"
solid = false
points_m = [[-2.0, -1.5], [2.0, -1.5], [2.0, 1.5], [-2.0, 1.5]]

[[robots]]
name = "robot"
start = { x_m = 0.0, y_m = 0.0, heading_rad = 0.0 }
body = { radius_m = 0.15, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
link = { kind = "uart", baud = 38400 }

[robots.sensors.ir_left]
kind = "ir"
bearing_rad = 0.5
rays = 5
opening_rad = 0.5
range_m = 1.0
c1_m2 = 0.03
c2 = 0.1
bits = 8

[robots.sensors.ir_right]
kind = "ir"
bearing_rad = -0.5
rays = 5
opening_rad = 0.5
range_m = 1.0
c1_m2 = 0.03
c2 = 0.1
bits = 8

[robots.sensors.encoders]
kind = "encoders"
counts_per_turn = 500
bits = 16
`;

export class CreateDialog {
  readonly element: HTMLDialogElement;
  private readonly name = el("input", {
    type: "text",
    label: "Name of the world",
    attributes: { placeholder: "the scenario's", maxlength: "64", pattern: "[A-Za-z0-9_\\-]*" },
  });
  private readonly text = el("textarea", {
    label: "Scenario, as TOML",
    test: "scenario",
    attributes: { spellcheck: "false", wrap: "off", autocomplete: "off" },
  });
  private readonly gutter = el("div", { class: "gutter", attributes: { "aria-hidden": "true" } });
  private readonly error = el("p", { class: "error", role: "alert", test: "error" });
  private readonly paused = el("input", { type: "checkbox" });
  private readonly make: HTMLButtonElement;
  private readonly editor: HTMLElement;
  private readonly savedText = el("span", {});
  private readonly savedRow: HTMLElement;
  /** A state that goes on, instead of the scenario in the editor. */
  private saved: Uint8Array | undefined;
  private lines = 0;

  constructor(private readonly orders: Orders) {
    const file = el("input", {
      type: "file",
      label: "Scenario or saved state",
      test: "open-file",
      attributes: { accept: ".toml,.mcap,text/plain" },
    });
    file.addEventListener("change", () => void this.open(file));
    this.make = button("Create", "Make this world", () => void this.create(), { class: "primary", test: "create" });
    const head = el(
      "div",
      { class: "dialog-row" },
      el("label", {}, "Name ", this.name),
      el("label", {}, this.paused, " paused"),
      el("label", {}, "Open ", file),
    );
    const feet = el(
      "div",
      { class: "dialog-row end" },
      button("Cancel", "Close (Escape)", () => this.element.close()),
      this.make,
    );
    this.editor = el("div", { class: "editor" }, this.gutter, this.text);
    const edit = button("Edit a scenario instead", "Discard the saved state", () => {
      file.value = "";
      this.setSaved(undefined, "");
    });
    this.savedRow = el("p", { class: "saved", hidden: true, test: "saved-state" }, this.savedText, edit);
    this.element = el(
      "dialog",
      { class: "create", label: "New world" },
      el("h2", { text: "New world" }),
      head,
      this.editor,
      this.savedRow,
      this.error,
      feet,
    );
    this.text.value = TEMPLATE;
    this.text.addEventListener("input", () => this.edited());
    this.text.addEventListener("scroll", () => (this.gutter.scrollTop = this.text.scrollTop));
    this.number();
  }

  show(): void {
    this.element.showModal();
    this.text.focus();
  }

  private async open(file: HTMLInputElement): Promise<void> {
    const chosen = file.files?.[0];
    if (!chosen) return;
    const bytes = new Uint8Array(await chosen.arrayBuffer());
    if (isMcap(bytes)) return this.setSaved(bytes, chosen.name);
    this.setSaved(undefined, "");
    this.text.value = new TextDecoder().decode(bytes);
    this.edited();
  }

  /** A saved state has its scenario in it, so there is nothing to edit. */
  private setSaved(saved: Uint8Array | undefined, name: string): void {
    this.saved = saved;
    this.editor.hidden = saved !== undefined;
    this.savedRow.hidden = saved === undefined;
    setText(this.savedText, `The world continues from the state in ${name} (${bytesText(saved?.length ?? 0)}). `);
    setText(this.error, "");
  }

  private edited(): void {
    setText(this.error, "");
    this.mark(0);
    this.number();
  }

  private number(): void {
    const lines = this.text.value.split("\n").length;
    if (lines === this.lines) return;
    this.lines = lines;
    this.gutter.replaceChildren(...Array.from({ length: lines }, (_, i) => el("span", { text: String(i + 1) })));
  }

  /** Marks a line, and brings it into sight. */
  private mark(line: number): void {
    this.gutter.querySelector(".marked")?.classList.remove("marked");
    const number = this.gutter.children[line - 1];
    if (!number) return;
    number.classList.add("marked");
    this.text.scrollTop = Math.max(0, line * LINE - this.text.clientHeight / 2);
    const before = this.text.value
      .split("\n")
      .slice(0, line - 1)
      .join("\n").length;
    const start = line === 1 ? 0 : before + 1;
    const end = this.text.value.indexOf("\n", start);
    this.text.focus();
    this.text.setSelectionRange(start, end < 0 ? this.text.value.length : end);
  }

  private async create(): Promise<void> {
    this.make.disabled = true;
    setText(this.error, "");
    try {
      const from = this.saved ? { savedMcap: this.saved } : { scenarioToml: this.text.value };
      await this.orders.create(this.name.value.trim(), from, this.paused.checked);
      this.element.close();
    } catch (error) {
      const message = error instanceof Error ? error.message : String(error);
      setText(this.error, message);
      this.mark(lineOf(message));
    } finally {
      this.make.disabled = false;
    }
  }
}
