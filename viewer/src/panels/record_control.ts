/** Records the chosen world, and keeps its state as a file. */
import { button, el, setClass, setPressed, setText } from "../dom";
import type { Store } from "../model/store";
import { bytesText, count } from "../model/units";
import type { Recordings } from "../net/recordings";

export class RecordControl {
  readonly elements: HTMLElement[];
  private readonly toggle: HTMLButtonElement;
  private readonly state = el("span", { class: "record-state", hidden: true, test: "record-state", role: "status" });

  constructor(
    private readonly store: Store,
    private readonly recordings: Recordings,
  ) {
    this.toggle = button("Record", "", () => void recordings.toggle(), { test: "record-toggle" });
    const save = button(
      "Save to a file",
      "The current state as a file; New world… continues from it",
      () => void recordings.save(),
      { test: "save-file" },
    );
    this.elements = [this.toggle, this.state, save];
    for (const event of ["world", "worlds"] as const) store.on(event, () => this.refresh());
    recordings.on("changed", () => this.refresh());
    this.refresh();
  }

  private refresh(): void {
    const recording = this.store.status?.recording;
    const problem = recording?.problem ?? "";
    const isReplay = this.store.status?.replay !== undefined;
    this.toggle.hidden = isReplay;
    // A world that is recorded elsewhere can be stopped without a folder of the server's.
    this.toggle.disabled = this.recordings.hasFolder === false && !recording;
    setText(this.toggle, recording ? "■ Stop" : "● Record");
    const begin = this.toggle.disabled ? "This server has no folder for recordings" : "Record this world from now on";
    this.toggle.title = recording ? `Close the recording ${recording.recording}` : begin;
    setPressed(this.toggle, recording !== undefined && problem === "");
    this.state.hidden = !recording;
    setClass(this.state, "bad", problem !== "");
    setText(this.state, problem || bytesText(Number(recording?.bytes ?? 0n)));
    this.state.title = recording ? `${recording.recording}: ${count(recording.ticks)} ticks. ${problem}` : "";
  }
}
