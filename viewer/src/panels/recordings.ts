/** The recordings that the server has, below its worlds. */
import { button, download, el } from "../dom";
import type { RecordingFile } from "../gen/baudbot/v1/control_pb";
import { host } from "../host";
import type { Store } from "../model/store";
import { bytesText } from "../model/units";
import type { Recordings } from "../net/recordings";

const NO_FOLDER = "This server has no folder for recordings; start it with baudbot serve --recordings FOLDER.";

export class RecordingsSection {
  readonly element: HTMLElement;
  private readonly list = el("ul", { class: "world-list", test: "recording-list", label: "Recordings" });
  private readonly empty = el("p", { class: "hint", text: "None yet; use Record in the bar above." });
  private readonly section: HTMLElement;
  private readonly hint = el("p", { class: "about", text: NO_FOLDER, hidden: true, test: "recordings-hint" });
  private shown = "";

  constructor(
    private readonly recordings: Recordings,
    private readonly store: Store,
  ) {
    this.section = el(
      "details",
      { class: "section", hidden: true, test: "recordings", attributes: { open: "" } },
      el("summary", { text: "Recordings" }),
      this.list,
      this.empty,
    );
    this.element = el("div", {}, this.section, this.hint);
    recordings.on("changed", () => this.refresh());
  }

  private refresh(): void {
    const { files, hasFolder } = this.recordings;
    this.section.hidden = hasFolder !== true;
    this.hint.hidden = hasFolder !== false;
    this.empty.hidden = files.length > 0;
    const key = files.map((file) => `${file.recording} ${file.bytes} ${file.modifiedUnixNs}`).join("\n");
    if (key === this.shown) return;
    this.shown = key;
    this.list.replaceChildren(...files.map((file) => this.row(file)));
  }

  private row({ recording, bytes, modifiedUnixNs }: RecordingFile): HTMLElement {
    const when = new Date(Number(modifiedUnixNs / 1_000_000n));
    const text = when.toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
    const open = button("Open", `Replay ${recording}`, () => void this.recordings.open(recording), {
      test: `recording-open-${recording}`,
      label: `Replay ${recording}`,
    });
    const save = button("Save", `Save the file ${recording}.mcap`, () => void this.save(recording), {
      test: `recording-save-${recording}`,
      label: `Save ${recording}`,
      hidden: !host.recording,
    });
    return el(
      "li",
      { class: "recording" },
      el(
        "span",
        { class: "recording-name" },
        el("strong", { text: recording }),
        el("span", { class: "world-line", text: `${bytesText(Number(bytes))} · ${text}` }),
      ),
      save,
      open,
    );
  }

  private async save(recording: string): Promise<void> {
    try {
      const bytes = await host.recording?.(recording);
      if (bytes) download(bytes, "application/octet-stream", `${recording}.mcap`);
    } catch (error) {
      this.store.note(error instanceof Error ? error.message : String(error), "error");
    }
  }
}
