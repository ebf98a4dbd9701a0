/** The dialog that runs a scenario with a brain: what is chosen, what it costs, and how it went. */
import { button, download, el, setText } from "../dom";
import type { Connection } from "../net/connection";
import type { Orders, PaceKind } from "../net/orders";
import { BrainChoice } from "./brain_choice";
import { BudgetView } from "./budget_view";
import type { Crew } from "./crew";
import { run, type Result } from "./run";
import type { Catalogue, WorldHost } from "./world_host";

const PACES: [PaceKind, string][] = [
  ["realTime", "in real time"],
  ["lockstep", "as fast as possible, to the end (lockstep)"],
];

/** How long runs are whose scenario has no end. */
const USUAL_S = 60;

export class StartDialog {
  readonly element: HTMLDialogElement;
  private readonly scenario = el("select", { label: "Scenario", test: "scenario-choice" });
  private readonly about = el("p", { class: "small" });
  private readonly toml = el("textarea", {
    class: "code",
    label: "Text of the scenario",
    test: "scenario-text",
    attributes: { spellcheck: "false", wrap: "off", rows: "14" },
  });
  private readonly pace = el("select", { label: "Pace", test: "pace-choice" });
  private readonly seconds = el("input", {
    type: "number",
    label: "Simulated seconds",
    test: "seconds",
    attributes: { min: "0.01", step: "any", placeholder: "the scenario's" },
  });
  /** Whether the user has said how long the run is. */
  private secondsAreOwn = false;
  private readonly records = el("input", { type: "checkbox", test: "records" });
  private readonly save: HTMLButtonElement;
  private readonly presets = el("ul", { class: "presets", label: "Presets", attributes: { tabindex: "0" } });
  private readonly error = el("p", { class: "error", role: "alert", test: "start-error" });
  private readonly result = el("p", { role: "status", test: "result" });
  private readonly begin: HTMLButtonElement;
  private readonly brain: BrainChoice;
  private readonly budget: BudgetView;
  /** The name of the last run's recording. */
  private recording = "";
  private catalogue: Catalogue = { scenarios: [], brains: [], presets: [] };

  constructor(
    private readonly host: WorldHost,
    readonly crew: Crew,
    readonly connection: Connection,
    readonly orders: Orders,
  ) {
    this.brain = new BrainChoice(host);
    this.budget = new BudgetView(connection, () => this.toml.value);
    this.begin = button("Run", "Make the world, and let the brain drive", () => void this.run(), {
      class: "primary",
      test: "start-run",
    });
    this.save = button(
      "Save the recording",
      "Save the recording of this run as a file",
      () => void this.saveRecording(),
      {
        hidden: true,
        test: "save-recording",
      },
    );
    this.pace.append(...PACES.map(([value, text]) => el("option", { value, text })));
    this.scenario.addEventListener("change", () => void this.chosen());
    this.toml.addEventListener("input", () => {
      this.proposeSeconds();
      this.budget.clear();
    });
    this.seconds.addEventListener("input", () => (this.secondsAreOwn = true));
    this.element = el(
      "dialog",
      { class: "start", label: "Run a scenario", test: "start" },
      el("h2", { text: "Run a scenario" }),
      el("div", { class: "dialog-row" }, el("label", {}, "Scenario ", this.scenario)),
      this.about,
      more("Its text, in TOML", this.toml),
      more("Presets that it can name", this.presets),
      this.brain.element,
      more("Budget of the control cycle", this.budget.element),
      el(
        "div",
        { class: "dialog-row" },
        el("label", {}, "Pace ", this.pace),
        el("label", {}, "Seconds ", this.seconds),
        el("label", {}, this.records, " record it"),
      ),
      this.error,
      this.result,
      this.save,
      el(
        "div",
        { class: "dialog-row end" },
        button("Close", "Close (Escape)", () => this.element.close()),
        this.begin,
      ),
    );
  }

  async fill(): Promise<void> {
    this.catalogue = await this.host.catalogue();
    const { scenarios, presets } = this.catalogue;
    this.scenario.replaceChildren(...scenarios.map(({ name }) => el("option", { value: name, text: name })));
    this.scenario.value = "wander";
    this.presets.replaceChildren(
      ...presets.map(({ name, kind, about }) => el("li", {}, el("code", { text: name }), ` (${kind}) ${about}`)),
    );
    this.brain.fill(this.catalogue);
    await this.chosen();
  }

  show(): void {
    this.element.showModal();
    this.scenario.focus();
  }

  /** Lets a robot drive that nobody has asked for, for as long as somebody looks. */
  async demonstrate(): Promise<void> {
    const what = {
      toml: this.toml.value,
      brain: this.brain.choice,
      pace: "realTime" as const,
      seconds: undefined,
      records: false,
    };
    await run(this, what);
  }

  /** Runs what is chosen. */
  private async run(): Promise<void> {
    this.begin.disabled = true;
    setText(this.error, "");
    setText(this.result, "Making the world…");
    try {
      const pace = this.pace.value as PaceKind;
      const [seconds, records] = [this.seconds_wanted, this.records.checked];
      const what = { toml: this.toml.value, brain: this.brain.choice, pace, seconds, records };
      const result = await run(this, what);
      setText(this.result, result ? words(result) : "");
      this.recording = result?.recording ?? "";
      this.save.hidden = this.recording === "";
      if (!result) this.element.close();
    } catch (error) {
      setText(this.result, "");
      setText(this.error, error instanceof Error ? error.message : String(error));
    } finally {
      this.begin.disabled = false;
    }
  }

  private async saveRecording(): Promise<void> {
    download(await this.host.recording(this.recording), "application/octet-stream", `${this.recording}.mcap`);
  }

  private get seconds_wanted(): number | undefined {
    return this.seconds.value === "" ? undefined : Number(this.seconds.value);
  }

  private async chosen(): Promise<void> {
    const { value } = this.scenario;
    setText(this.about, this.catalogue.scenarios.find(({ name }) => name === value)?.about ?? "");
    this.toml.value = await this.host.scenario(value);
    this.secondsAreOwn = false;
    this.proposeSeconds();
    this.budget.clear();
  }

  /** What does not end by itself ends after a minute, as with `baudbot run`, unless the user has said when. */
  private proposeSeconds(): void {
    if (this.secondsAreOwn) return;
    this.seconds.value = /^\s*(\[end\]|end\b)/m.test(this.toml.value) ? "" : String(USUAL_S);
  }
}

function more(title: string, content: HTMLElement): HTMLElement {
  return el("details", { class: "section" }, el("summary", { text: title }), content);
}

function words({ simulated_s, took_s, ending, hash }: Result): string {
  const times = Math.round(simulated_s / took_s);
  return (
    `${simulated_s} s simulated in ${took_s.toFixed(3)} s of wall-clock time, ${times} times real time; ` +
    `the run ended because ${ending}; state hash ${hash}`
  );
}
