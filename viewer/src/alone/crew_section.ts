/** The brains of the page below its worlds: another one for the chosen robot, and what they said. */
import { button, el, setText } from "../dom";
import type { Store } from "../model/store";
import { BrainChoice } from "./brain_choice";
import type { Crew } from "./crew";
import type { WorldHost } from "./world_host";

export class CrewSection {
  readonly element: HTMLElement;
  readonly dialog: HTMLDialogElement;
  private readonly names = el("ul", { class: "world-list", label: "Brains of your own that drive" });
  private readonly log = el("pre", { class: "log", label: "What brains said", attributes: { tabindex: "0" } });
  private readonly error = el("p", { class: "error", role: "alert" });
  private readonly choice: BrainChoice;

  constructor(
    host: WorldHost,
    private readonly crew: Crew,
    private readonly store: Store,
    start: () => void,
  ) {
    this.choice = new BrainChoice(host);
    this.dialog = el(
      "dialog",
      { class: "start", label: "Brain of the selected robot" },
      el("h2", { text: "Brain of the selected robot" }),
      this.choice.element,
      this.error,
      el(
        "div",
        { class: "dialog-row end" },
        button("Close", "Close (Escape)", () => this.dialog.close()),
        button("Drive", "Let this brain drive the robot", () => void this.drive(), { class: "primary" }),
      ),
    );
    this.element = el(
      "details",
      { class: "section", attributes: { open: "" } },
      el("summary", { text: "Scenarios and brains" }),
      el(
        "div",
        { class: "dialog-row" },
        button("Run a scenario…", "Choose a scenario and a brain", start, { test: "open-start" }),
        button("Brain…", "Choose the selected robot's brain", () => this.dialog.showModal(), { test: "open-brain" }),
        button("End your brains", "End all brains that were typed into the page", () => crew.endAll()),
      ),
      this.names,
      this.log,
    );
    crew.on("changed", () => this.refresh());
    this.refresh();
  }

  async fill(host: WorldHost): Promise<void> {
    this.choice.fill(await host.catalogue());
  }

  private refresh(): void {
    this.names.replaceChildren(...this.crew.names().map((text) => el("li", { text })));
    this.log.hidden = this.crew.log.length === 0;
    setText(this.log, this.crew.log.join("\n"));
    this.log.scrollTop = this.log.scrollHeight;
  }

  private async drive(): Promise<void> {
    setText(this.error, "");
    try {
      await this.crew.begin(this.choice.choice, this.store.world, [this.store.robot]);
      this.dialog.close();
    } catch (error) {
      setText(this.error, error instanceof Error ? error.message : String(error));
    }
  }
}
