/** Keeps a Watch open on the chosen world, with details of the chosen robot, as often as frames are looked at. */
import { equals } from "@bufbuild/protobuf";
import { DescribeWorldResponseSchema, ObserveService } from "../gen/baudbot/v1/observe_pb";
import { WorldState, type Pace } from "../gen/baudbot/v1/world_pb";
import type { Store } from "../model/store";
import { secondsOf } from "../model/units";
import { ask, CallError, type Connection } from "./connection";
import { decodeFrame, type Frame } from "./frames";
import { firstEvery, nextEvery } from "./rate";

const MEASURE_MS = 1000;
/** A Watch that fails is tried again after this, unless the world is gone. */
const RETRY_MS = 1000;
/** A world that is reset again and again, as by a trainer, is described no more often. */
const DESCRIBE_MS = 1000;

/** Pulses whose period is shorter than this part of Δt are told together. */
const PULSES_A_STEP = 32n;

export class Watcher {
  /** Frames that came in the last second. */
  frames_per_s = 0;
  /** Simulated seconds that went by in the last second of wall-clock time. */
  speed = 0;
  private call = 0;
  private every = 1;
  private isFirst = true;
  /** The second in which a Watch begins is not measured. */
  private isSettling = true;
  private frames = 0;
  /** Whether the world was reset or restored since it was described, and whether that is being looked into. */
  private isStale = false;
  private isDescribing = false;
  private measured = { at_ms: performance.now(), tick: 0n, time_ns: 0n };

  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
  ) {
    store.on("robot", () => store.description && this.watch());
    store.on("pins", () => this.again());
    // What is leapt over is no speed.
    store.on("leap", () => (this.isSettling = true));
    store.on("restart", () => {
      this.isStale = true;
      if (!this.isDescribing) void this.describeAgain();
    });
    setInterval(() => this.measure(), MEASURE_MS);
  }

  /** Begins with the chosen world: what it is, then its frames. */
  async begin(): Promise<void> {
    this.stop();
    const { world } = this.store;
    if (world === "") return;
    try {
      const description = await ask(this.connection, ObserveService.method.describeWorld, { world });
      if (world !== this.store.world) return;
      this.every = firstEvery(this.pace, secondsOf(description.stepNs));
      this.store.describe(description);
    } catch (error) {
      if (world === this.store.world) this.failed(error);
    }
  }

  /** After a reset: takes the description if that has made another of it, with other walls for instance. */
  private async describeAgain(): Promise<void> {
    this.isDescribing = true;
    while (this.isStale) {
      this.isStale = false;
      const { world, description: former } = this.store;
      try {
        const description = await ask(this.connection, ObserveService.method.describeWorld, { world });
        const isCurrent = former !== undefined && former === this.store.description;
        if (isCurrent && !equals(DescribeWorldResponseSchema, former, description)) this.store.describe(description);
      } catch {
        // A world that is gone, and a lost connection, end the Watch, too, which says so.
      }
      await new Promise((resolve) => setTimeout(resolve, DESCRIBE_MS));
    }
    this.isDescribing = false;
  }

  /** Looks anew, so that a world that stands shows what was changed in it. */
  again(): void {
    if (this.call !== 0) this.watch();
  }

  stop(): void {
    if (this.call !== 0) this.connection.end(this.call);
    this.call = 0;
  }

  private get pace(): Pace | undefined {
    return this.store.status?.pace;
  }

  private watch(): void {
    this.stop();
    const { world, robot } = this.store;
    this.isFirst = this.isSettling = true;
    this.store.setStride(this.every);
    const details = robot === "" ? [] : [robot];
    const pins = this.store.hasChip && this.store.showsPins;
    // Of three Δt, nearer pulses could not be told apart.
    const pinsFinestNs = (this.store.description?.stepNs ?? 0n) / PULSES_A_STEP;
    const request = { world, everyTicks: BigInt(this.every), details, pins, pinsFinestNs };
    const call = this.connection.begin(ObserveService.method.watch, request, {
      message: (bytes) => this.take(decodeFrame(bytes)),
      over: (error) => this.over(call, error),
    });
    this.call = call;
  }

  private take(frame: Frame): void {
    this.frames++;
    const first = this.isFirst;
    this.isFirst = false;
    // What went by before this page looked is no speed.
    if (first) this.measured = { ...this.measured, tick: frame.tick, time_ns: frame.timeNs };
    this.store.take(frame, first);
  }

  private over(call: number, error?: CallError): void {
    if (call !== this.call) return;
    this.call = 0;
    if (error && error.code !== "UNAVAILABLE") this.failed(error);
  }

  private failed(error: unknown): void {
    if (error instanceof CallError && error.code === "UNAVAILABLE") return; // the status line says so
    this.store.note(String(error instanceof Error ? error.message : error), "error");
    const isGone = error instanceof CallError && error.code === "NOT_FOUND";
    if (!isGone) setTimeout(() => this.call === 0 && void this.begin(), RETRY_MS);
  }

  /** Once a second: how fast it goes, and whether another rate would be better. */
  private measure(): void {
    const now_ms = performance.now();
    const [span_s, frame] = [(now_ms - this.measured.at_ms) / 1000, this.store.frame];
    const load = this.connection.busy_ms / 1000 / span_s;
    const ticks = Number((frame?.tick ?? 0n) - this.measured.tick);
    this.frames_per_s = this.frames / span_s;
    const went_ns = (frame?.timeNs ?? 0n) - this.measured.time_ns;
    if (!this.isSettling || went_ns === 0n) this.speed = Math.max(0, secondsOf(went_ns) / span_s);
    this.connection.busy_ms = 0;
    this.frames = 0;
    this.measured = { at_ms: now_ms, tick: frame?.tick ?? 0n, time_ns: frame?.timeNs ?? 0n };
    if (this.call === 0 || !frame) return;
    const ticks_per_s = this.isSettling ? 0 : Math.max(0, ticks) / span_s;
    this.isSettling = false;
    const next = nextEvery(this.every, this.pace, { ticks_per_s, load });
    const stands = this.store.status?.state === WorldState.PAUSED;
    const isBehind = stands && this.store.status !== undefined && this.store.status.tick !== frame.tick;
    if (next !== this.every || isBehind) {
      this.every = next;
      this.watch();
    }
  }
}
