/** Takes a replay to a tick, and waits for the frame of it. */
import { ControlService } from "../gen/baudbot/v1/control_pb";
import type { Store } from "../model/store";
import { ask, type Connection } from "../net/connection";
import type { Surveyor } from "../net/surveyor";
import type { Watcher } from "../net/watcher";
import type { Projector } from "./film";

/** A frame that has not come by then is asked for. */
const ASK_MS = 500;
const MOST_MS = 20_000;

export class ReplayProjector implements Projector {
  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
    private readonly watcher: Watcher,
    private readonly surveyor: Surveyor,
  ) {}

  async show(tick: bigint): Promise<void> {
    const { world } = this.store;
    const frame = this.frameOf(tick);
    try {
      await ask(this.connection, ControlService.method.seekReplay, { world, tick });
      await frame.come();
      await this.surveyor.survey();
    } finally {
      frame.stop();
    }
  }

  /** Listens before it is asked for: the frame may come before the answer. */
  private frameOf(tick: bigint): { come(): Promise<void>; stop(): void } {
    const { store, watcher } = this;
    let arrive: () => void = () => {};
    let isHere = store.frame?.tick === tick;
    const stop = store.on("frame", (frame) => {
      isHere = frame.tick === tick;
      if (isHere) arrive();
    });
    const come = () =>
      new Promise<void>((resolve, reject) => {
        if (isHere) return resolve();
        const again = setInterval(() => watcher.again(), ASK_MS);
        const most = setTimeout(() => {
          clearInterval(again);
          reject(new Error(`no frame of tick ${tick} has arrived`));
        }, MOST_MS);
        arrive = () => {
          clearInterval(again);
          clearTimeout(most);
          resolve();
        };
      });
    return { come, stop };
  }
}
