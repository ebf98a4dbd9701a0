/** What an operator can order, in the order in which it has to be asked for. What goes wrong is told to people. */
import { create, type DescMessage, type DescMethodUnary, type MessageInitShape } from "@bufbuild/protobuf";
import { ControlService, type InterveneRequest } from "../gen/baudbot/v1/control_pb";
import { PaceSchema, WorldState, type Pace, type WorldStatus } from "../gen/baudbot/v1/world_pb";
import type { Store } from "../model/store";
import { secondsOf } from "../model/units";
import { ask, CallError, type Connection } from "./connection";
import type { Watcher } from "./watcher";

export type PaceKind = NonNullable<Pace["kind"]["case"]>;
export type Intervention = InterveneRequest["intervention"];

/** A state that the server keeps, as far as this page knows of it. */
export interface Kept {
  snapshot: bigint;
  tick: bigint;
  time_s: number;
}

/** What a world is made from: a scenario, or a state that was saved. */
export type Origin = { scenarioToml: string } | { savedMcap: Uint8Array };

/** As many as the server keeps. */
const MOST_SNAPSHOTS = 64;

export class Orders {
  /** Snapshots that this page took, by world. */
  readonly kept = new Map<string, Kept[]>();
  /** The pace to go back to from single steps, by world. */
  private readonly paceBefore = new Map<string, Pace>();
  /** Ticks that are to be asked for, of worlds that are asked for some now: a world does one such request at a time. */
  private readonly ticksAhead = new Map<string, number>();

  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
    private readonly watcher: Watcher,
  ) {}

  /** Asks for all worlds; quiet if there is no answer, for it is asked again and again. */
  async list(): Promise<boolean> {
    try {
      const { worlds } = await ask(this.connection, ControlService.method.listWorlds, {});
      this.store.setWorlds(worlds);
      return true;
    } catch (error) {
      if (error instanceof CallError && error.code === "PERMISSION_DENIED") this.store.hideWorlds(error.message);
      return false;
    }
  }

  /** Lets the chosen world go on; one that is stepped goes back to the pace that it had. */
  run(): Promise<void> {
    return this.told(async (world) => {
      if (this.store.status?.pace?.kind.case === "stepped") {
        const pace = this.paceBefore.get(world) ?? paceOf("realTime");
        this.store.note(`The pace is ${paceWords(pace)} again.`);
        await this.ask(ControlService.method.setPace, { world, pace });
      }
      await this.ask(ControlService.method.startWorld, { world });
    });
  }

  pause(): Promise<void> {
    return this.told((world) => this.ask(ControlService.method.pauseWorld, { world }));
  }

  /** Runs a world that stands, and stops one that goes. */
  toggle(): Promise<void> {
    return this.store.status?.state === WorldState.RUNNING ? this.pause() : this.run();
  }

  /**
   * Single ticks. Those that are asked for while others are under way are done after them, all at once, unless another world
   * was chosen meanwhile.
   */
  async step(ticks: number): Promise<void> {
    const { world } = this.store;
    const ahead = this.ticksAhead.get(world);
    this.ticksAhead.set(world, (ahead ?? 0) + ticks);
    if (ahead !== undefined) return;
    await this.told(async () => {
      await this.stepped(world);
      // What is known of how a world stands is known of the chosen one.
      for (let asked; this.store.world === world && (asked = this.ticksAhead.get(world));) {
        this.ticksAhead.set(world, 0);
        await this.stepNow(world, asked);
      }
    });
    this.ticksAhead.delete(world);
  }

  /** Only a stepped world does single ticks, so it becomes one. */
  private async stepped(world: string): Promise<void> {
    const pace = this.store.status?.pace;
    if (pace?.kind.case === "stepped") return;
    if (pace) this.paceBefore.set(world, pace);
    await this.ask(ControlService.method.setPace, { world, pace: paceOf("stepped") });
    this.store.note("The pace is now stepped; Run restores the previous one.");
  }

  setPace(pace: Pace): Promise<void> {
    return this.told((world) => this.ask(ControlService.method.setPace, { world, pace }));
  }

  reset(): Promise<void> {
    return this.told((world) => this.ask(ControlService.method.resetWorld, { world }));
  }

  snapshot(): Promise<void> {
    return this.told(async (world) => {
      const { snapshot, status } = await ask(this.connection, ControlService.method.snapshotWorld, { world });
      const kept = { snapshot, tick: status?.tick ?? 0n, time_s: secondsOf(status?.timeNs ?? 0n) };
      this.kept.set(world, [...(this.kept.get(world) ?? []), kept].slice(-MOST_SNAPSHOTS));
      this.store.setStatus(status);
    });
  }

  restore(snapshot: bigint): Promise<void> {
    return this.told((world) => this.ask(ControlService.method.restoreWorld, { world, snapshot }));
  }

  /** Makes a world and chooses it. What is wrong with the scenario is thrown. */
  async create(world: string, from: Origin, paused: boolean): Promise<void> {
    const request = { world, ...from, paused };
    const { status } = await ask(this.connection, ControlService.method.createWorld, request);
    this.store.setStatus(status);
    if (status) this.choose(status.world);
  }

  /** Makes a live world of a replay, at the tick where it is. */
  fork(): Promise<void> {
    return this.told(async (world) => {
      await this.ask(ControlService.method.forkReplay, { world });
      this.store.note(`${world} is live now: brains can attach, and Run starts it.`);
    });
  }

  delete(world: string): Promise<void> {
    return this.told(async () => {
      if (world === this.store.world) this.watcher.stop();
      await ask(this.connection, ControlService.method.deleteWorld, { world });
      this.kept.delete(world);
      this.paceBefore.delete(world);
      await this.list();
      if (world === this.store.world) this.choose(this.store.worlds[0]?.world ?? "");
    });
  }

  /** Looks at another world. */
  choose(world: string, robot = ""): void {
    this.store.chooseWorld(world, robot);
    void this.watcher.begin();
  }

  /** Changes something by hand; whether the server did it. */
  async intervene(intervention: Intervention): Promise<boolean> {
    let done = false;
    await this.told(async (world) => {
      await this.ask(ControlService.method.intervene, { world, intervention });
      done = true;
    });
    return done;
  }

  private async stepNow(world: string, ticks: number): Promise<void> {
    const request = { world, ticks: BigInt(ticks) };
    const { status } = this.store;
    // A stepped world waits for robots that have no brain, for ever if need be, unless it is told to go on without.
    if (!status?.replay && status?.robots.some((robot) => !robot.attached)) {
      await this.ask(ControlService.method.startWorld, { world });
    }
    await this.ask(ControlService.method.stepWorld, request);
  }

  /** Asks for something that is answered by the world's status, and looks at a world that stands. */
  private async ask<I extends DescMessage, O extends DescMessage>(
    method: DescMethodUnary<I, O>,
    request: MessageInitShape<I>,
  ): Promise<void> {
    const answer = (await ask(this.connection, method, request)) as { status?: WorldStatus };
    this.store.setStatus(answer.status);
    if (answer.status?.state !== WorldState.RUNNING) this.watcher.again();
  }

  /** Does something to the chosen world; what goes wrong is told. */
  async told(order: (world: string) => Promise<void>): Promise<void> {
    const { world } = this.store;
    if (world === "") return this.store.note("No world is selected.", "error");
    try {
      await order(world);
    } catch (error) {
      const text = error instanceof Error ? error.message : String(error);
      this.store.note(text, "error");
    }
  }
}

/** A pace of a kind. */
export function paceOf(kind: PaceKind, factor = 1): Pace {
  const value = kind === "scaled" ? { factor } : {};
  return create(PaceSchema, { kind: { case: kind, value } as never });
}

/** A pace in words. */
export function paceWords(pace: Pace | undefined): string {
  const kind = pace?.kind;
  switch (kind?.case) {
    case "realTime":
      return "real time";
    case "scaled":
      return `× ${kind.value.factor}`;
    case "lockstep":
    case "stepped":
    case "free":
      return kind.case;
    default:
      return "";
  }
}
