/** Recordings: those in the server's folder, the one that is made of the chosen world, and single states as files. */
import { download } from "../dom";
import { Emitter } from "../emitter";
import { ControlService, type RecordingFile } from "../gen/baudbot/v1/control_pb";
import type { WorldStatus } from "../gen/baudbot/v1/world_pb";
import type { Store } from "../model/store";
import { bytesText, count } from "../model/units";
import { ask, CallError, type Connection } from "./connection";
import type { Orders } from "./orders";

/** Frames a simulated second that a recording has for other tools to look at. */
const LOOK_HZ = 10;
/** How many names are tried for a recording that is open already. */
const MOST_NAMES = 9;

export class Recordings extends Emitter<{ changed: void }> {
  files: RecordingFile[] = [];
  /** Whether the server has a folder of recordings; undefined as long as it has not said. */
  hasFolder: boolean | undefined;

  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
    private readonly orders: Orders,
  ) {
    super();
  }

  /** Asks what there is; quiet if it fails, for it is asked again. */
  async list(): Promise<void> {
    try {
      const { recordings } = await ask(this.connection, ControlService.method.listRecordings, {});
      [this.files, this.hasFolder] = [recordings, true];
    } catch (error) {
      if (!(error instanceof CallError) || error.code === "UNAVAILABLE") return;
      // Who may not see them is told nothing of the folder.
      [this.files, this.hasFolder] = [[], error.code === "PERMISSION_DENIED" ? undefined : false];
    }
    this.emit("changed", undefined);
  }

  /** Replays a recording, and looks at it. */
  async open(recording: string): Promise<void> {
    try {
      const status = await this.openAs(recording, 1);
      this.store.setStatus(status);
      if (status) this.orders.choose(status.world);
    } catch (error) {
      this.store.note(error instanceof Error ? error.message : String(error), "error");
    }
  }

  /** Begins to record the chosen world, or closes its recording. */
  toggle(): Promise<void> {
    return this.store.status?.recording ? this.stop() : this.start();
  }

  /** The present state as a file. */
  save(): Promise<void> {
    return this.orders.told(async (world) => {
      const { savedMcap, tick } = await ask(this.connection, ControlService.method.saveWorld, { world });
      download(savedMcap, "application/octet-stream", `${world}-${tick}.mcap`);
      this.store.note(`Tick ${count(tick)} of ${world} is in ${world}-${tick}.mcap; New world… continues from it.`);
    });
  }

  /** A recording that is open already under its own name gets another one. */
  private async openAs(recording: string, attempt: number): Promise<WorldStatus | undefined> {
    const world = attempt === 1 ? "" : `${recording.replace(/[^A-Za-z0-9_-]/g, "_").slice(0, 60)}-${attempt}`;
    try {
      const request = { recording, world };
      return (await ask(this.connection, ControlService.method.openRecording, request)).status;
    } catch (error) {
      const isTaken = error instanceof CallError && error.code === "ALREADY_EXISTS";
      if (!isTaken || attempt >= MOST_NAMES) throw error;
      return this.openAs(recording, attempt + 1);
    }
  }

  private start(): Promise<void> {
    return this.orders.told(async (world) => {
      const request = { world, lookHz: LOOK_HZ };
      const { status } = await ask(this.connection, ControlService.method.startRecording, request);
      this.store.setStatus(status);
    });
  }

  private stop(): Promise<void> {
    return this.orders.told(async (world) => {
      const { recording } = await ask(this.connection, ControlService.method.stopRecording, { world });
      if (recording) {
        const what = `${count(recording.ticks)} ticks, ${bytesText(Number(recording.bytes))}`;
        this.store.note(`${recording.recording} is recorded: ${what}.`);
      }
      await Promise.all([this.orders.list(), this.list()]);
    });
  }
}
