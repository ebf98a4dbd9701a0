/** The replay of the chosen world: what is in it, where it is, and how it is taken elsewhere. */
import { Emitter } from "../emitter";
import { ControlService, type DescribeReplayResponse, type ReplayEvent } from "../gen/baudbot/v1/control_pb";
import { WorldState } from "../gen/baudbot/v1/world_pb";
import { eventFrom, within, type Range } from "../model/replay";
import type { Store } from "../model/store";
import { ask, CallError, type Connection } from "./connection";
import type { Orders } from "./orders";
import { SeekQueue } from "./seek";

export class Replayer extends Emitter<{ changed: void }> {
  description: DescribeReplayResponse | undefined;
  private described = "";
  private readonly queue = new SeekQueue(
    (tick) => this.seekNow(tick),
    (error) => this.store.note(error instanceof Error ? error.message : String(error), "error"),
  );
  /** Where the world is, though its frame has not come yet. */
  private awaited: bigint | undefined;
  /** It went on before somebody began to scrub. */
  private goesOnAfter = false;

  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
    private readonly orders: Orders,
  ) {
    super();
    for (const event of ["world", "worlds"] as const) store.on(event, () => this.look());
    store.on("frame", () => {
      this.awaited = undefined;
      this.emit("changed", undefined);
    });
  }

  /** Whether the chosen world is a replay. */
  get isOn(): boolean {
    return this.store.status?.replay !== undefined;
  }

  get range(): Range {
    const replay = this.store.status?.replay;
    return { first: replay?.firstTick ?? 0n, last: replay?.lastTick ?? 0n };
  }

  get events(): readonly ReplayEvent[] {
    return this.description?.events ?? [];
  }

  /** Where it is, or is on its way to. */
  get tick(): bigint {
    return this.queue.wished ?? this.awaited ?? this.store.frame?.tick ?? this.store.status?.tick ?? 0n;
  }

  get runs(): boolean {
    return this.store.status?.state === WorldState.RUNNING;
  }

  /** Goes to a tick. */
  async seek(tick: bigint): Promise<void> {
    if (!this.isOn) return;
    const done = this.queue.want(within(tick, this.range));
    this.emit("changed", undefined);
    await done;
    this.emit("changed", undefined);
  }

  /** Runs or stops; at its end it starts over. */
  async toggle(): Promise<void> {
    if (!this.runs && this.tick >= this.range.last) await this.seek(this.range.first);
    await this.orders.toggle();
  }

  /** A tick forwards or backwards; it stands there. */
  async step(direction: 1 | -1): Promise<void> {
    const ran = this.runs;
    if (ran) await this.orders.pause();
    const to = ((ran && this.store.status?.tick) || this.tick) + BigInt(direction);
    if (to > this.range.last) return;
    // Behind a seek that is under way a step would be taken from elsewhere.
    if (direction > 0 && this.queue.wished === undefined) await this.orders.step(1);
    else await this.seek(to);
  }

  async toEvent(direction: 1 | -1): Promise<void> {
    const event = eventFrom(this.events, this.tick, direction);
    if (!event) return this.store.note(direction > 0 ? "There is no later event." : "There is no earlier event.");
    await this.seek(event.tick);
  }

  /** A finger is on the time line: the world stands while it is. */
  async grab(): Promise<void> {
    this.goesOnAfter ||= this.runs;
    if (this.runs) await this.orders.pause();
  }

  async letGo(): Promise<void> {
    const goesOn = this.goesOnAfter;
    this.goesOnAfter = false;
    if (this.queue.wished !== undefined) await this.seek(this.queue.wished);
    if (goesOn) await this.orders.run();
  }

  private async seekNow(tick: bigint): Promise<void> {
    const { world } = this.store;
    const { status } = await ask(this.connection, ControlService.method.seekReplay, { world, tick });
    if (world !== this.store.world) return;
    // The frame may have come before this answer.
    if (status && this.store.frame?.tick !== status.tick) this.awaited = status.tick;
    this.store.setStatus(status);
  }

  /** Another world, or it is live now. */
  private look(): void {
    const { world } = this.store;
    const wanted = this.isOn ? world : "";
    if (wanted !== this.described) {
      this.described = wanted;
      this.description = this.awaited = undefined;
      this.goesOnAfter = false;
      this.queue.drop();
      if (wanted !== "") void this.describe(wanted);
    }
    this.emit("changed", undefined);
  }

  private async describe(world: string): Promise<void> {
    try {
      const description = await ask(this.connection, ControlService.method.describeReplay, { world });
      if (world !== this.described) return;
      this.description = description;
      this.emit("changed", undefined);
    } catch (error) {
      // It is asked again with the next list of worlds.
      if (world === this.described) this.described = "";
      if (!(error instanceof CallError && error.code === "UNAVAILABLE")) this.store.note(String(error), "error");
    }
  }
}
