/**
 * Asks for the map of the floor about once a second while the world that is shown counts coverage, with one request under
 * way at a time. A world that stands is asked once.
 */
import { ObserveService } from "../gen/baudbot/v1/observe_pb";
import type { Store } from "../model/store";
import { ask, type Connection } from "./connection";

const WAIT_MS = 1000;
/** The same when the world is at quite another tick, and the map of nothing that is shown. */
const SHORT_WAIT_MS = 200;

export class Surveyor {
  private work: Promise<void> | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private due_ms = 0;
  private answered_ms = -Infinity;
  private wait_ms = WAIT_MS;

  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
    /** Whether anybody looks at the map. */
    private readonly isShown: () => boolean,
  ) {
    store.on("leap", () => (this.wait_ms = SHORT_WAIT_MS));
    store.on("frame", () => this.look());
  }

  /** Asks when enough time has gone by since the last answer, if there may be something new. */
  look(): void {
    const { coverage, frame, filmStride } = this.store;
    // Who makes a film asks for the map of each picture.
    if (this.work || filmStride > 0 || !this.isWanted || coverage?.tick === frame?.tick) return;
    const now_ms = performance.now();
    const due_ms = Math.max(now_ms, this.answered_ms + this.wait_ms);
    if (this.timer !== undefined && due_ms >= this.due_ms) return;
    clearTimeout(this.timer);
    this.due_ms = due_ms;
    this.timer = setTimeout(() => {
      this.timer = undefined;
      if (!this.work) void this.survey();
    }, due_ms - now_ms);
  }

  /** The map as the world is now, if anybody looks at it. */
  async survey(): Promise<void> {
    // What is under way may be of another tick.
    while (this.work) await this.work;
    if (!this.isWanted) return;
    this.work = this.ask();
    await this.work;
    this.work = undefined;
    this.look();
  }

  private get isWanted(): boolean {
    return this.isShown() && this.store.frame?.rest.score?.covered !== undefined;
  }

  private async ask(): Promise<void> {
    const { world } = this.store;
    this.wait_ms = WAIT_MS;
    try {
      const map = await ask(this.connection, ObserveService.method.getCoverage, { world });
      if (world === this.store.world) this.store.setCoverage(map);
    } catch {
      // The next frame asks again; why there is none, other calls say.
    }
    this.answered_ms = performance.now();
  }
}
