/** The part of a dialog in which a brain is chosen, or typed. */
import { el, setText } from "../dom";
import { JAVASCRIPT } from "./brains/javascript_example";
import { PYTHON } from "./brains/python_example";
import type { Choice } from "./crew";
import type { Catalogue, WorldHost } from "./world_host";

const OWN: [kind: "toml" | "javascript" | "python", words: string][] = [
  ["toml", "your own, in TOML"],
  ["javascript", "your own, in JavaScript"],
  ["python", "your own, in Python (loads Pyodide, 13 MB)"],
];

export class BrainChoice {
  readonly element: HTMLElement;
  private readonly select = el("select", { label: "Brain", test: "brain" });
  private readonly settings = el("input", {
    type: "text",
    label: "Parameters of the brain",
    test: "brain-settings",
    attributes: { placeholder: "NAME=NUMBER,…", spellcheck: "false" },
  });
  private readonly about = el("p", { class: "small", id: "brain-about" });
  private readonly text = el("textarea", {
    class: "code",
    label: "Text of the brain",
    test: "brain-text",
    attributes: { spellcheck: "false", wrap: "off", rows: "14" },
  });
  private readonly editor: HTMLElement;
  private readonly row: HTMLElement;
  /** What was typed of each kind. */
  private readonly texts = { toml: "", javascript: JAVASCRIPT, python: PYTHON };
  private catalogue: Catalogue = { scenarios: [], brains: [], presets: [] };

  constructor(private readonly host: WorldHost) {
    this.row = el("label", {}, "Parameters ", this.settings);
    this.editor = el("div", {}, this.text);
    this.element = el(
      "div",
      { class: "brain-choice" },
      el("div", { class: "dialog-row" }, el("label", {}, "Brain ", this.select), this.row),
      this.about,
      this.editor,
    );
    this.select.addEventListener("change", () => void this.show());
    this.text.addEventListener("input", () => {
      const { kind } = this;
      if (kind === "toml" || kind === "javascript" || kind === "python") this.texts[kind] = this.text.value;
    });
  }

  fill(catalogue: Catalogue): void {
    this.catalogue = catalogue;
    const option = (value: string, text: string) => el("option", { value, text });
    const group = (label: string, ...options: Node[]) => el("optgroup", { attributes: { label } }, ...options);
    this.select.replaceChildren(
      option("none", "none"),
      group("Your own", ...OWN.map(([kind, words]) => option(kind, words))),
      group("Repertoire", ...catalogue.brains.map(({ name }) => option(`:${name}`, name))),
    );
    this.select.value = ":avoid";
    void this.show();
  }

  /** What is chosen. */
  get choice(): Choice {
    const { kind } = this;
    if (kind === "none") return { kind };
    if (kind === "toml" || kind === "javascript" || kind === "python") return { kind, text: this.text.value };
    const settings = this.settings.value.trim();
    return { kind: "repertoire", brain: settings === "" ? kind : `${kind}:${settings}` };
  }

  /** The name of a brain of the repertoire, or what kind of one it is. */
  private get kind(): string {
    return this.select.value.replace(/^:/, "");
  }

  private async show(): Promise<void> {
    const { kind } = this;
    const isOwn = kind === "toml" || kind === "javascript" || kind === "python";
    const known = this.catalogue.brains.find(({ name }) => `:${name}` === this.select.value);
    this.row.hidden = known === undefined;
    this.editor.hidden = !isOwn;
    const parameters = known?.parameters.length ? ` Parameters: ${known.parameters.join(", ")}.` : "";
    setText(this.about, known ? known.about + parameters : "");
    // A brain in TOML begins as one of the repertoire.
    if (kind === "toml" && this.texts.toml === "") this.texts.toml = (await this.host.brain("sweeper")) ?? "";
    if (isOwn && this.kind === kind) this.text.value = this.texts[kind];
  }
}
