/** Recordings of the mock server: those in its folder, and worlds that do again what was recorded. */
import { create } from "@bufbuild/protobuf";
import { ReplayEventKind as K, type DescribeReplayResponse, type ReplayEvent } from "../src/gen/baudbot/v1/control_pb";
import { ReplayStatusSchema, WorldState, type WorldStatus } from "../src/gen/baudbot/v1/world_pb";
import { MockWorld } from "./mock_world";

/** A file of the mock's folder. */
export interface MockFile {
  recording: string;
  bytes: bigint;
  modifiedUnixNs: bigint;
  /** What there is to see in it. */
  last: bigint;
  differs: string;
  cutOff: boolean;
}

export const MAGIC = Uint8Array.of(0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a);

export function files(): Map<string, MockFile> {
  const file = (recording: string, last: bigint, more: Partial<MockFile> = {}): [string, MockFile] => [
    recording,
    {
      recording,
      bytes: 1_234_567n,
      modifiedUnixNs: 1_760_000_000_000_000_000n,
      last,
      differs: "",
      cutOff: false,
      ...more,
    },
  ];
  return new Map([
    file("run-1", 3000n),
    file("killed", 800n, { cutOff: true, differs: "tick 400, robots.bob.x_m: recorded 0x3f, replayed 0x40" }),
  ]);
}

/** A world that replays. The made-up world does the same each time, so it is simulated anew. */
export class MockReplay extends MockWorld {
  readonly first = 0n;
  happened: ReplayEvent[] = [];
  private isLive = false;

  constructor(
    name: string,
    private readonly file: MockFile,
  ) {
    super(name, 3);
    this.state = WorldState.PAUSED;
    this.happened = this.look();
  }

  /** How often it was asked for another tick, for tests. */
  seeks = 0;

  override step(): void {
    if (!this.isLive && this.tick >= this.file.last) return;
    super.step();
    if (!this.isLive && this.tick >= this.file.last) this.state = WorldState.PAUSED;
  }

  seek(tick: bigint): void {
    const { state } = this;
    this.seeks++;
    const to = tick > this.file.last ? this.file.last : tick;
    if (to < this.tick) this.reset();
    while (this.tick < to) this.step();
    this.state = this.tick === this.file.last ? WorldState.PAUSED : state;
  }

  get isReplay(): boolean {
    return !this.isLive;
  }

  fork(): void {
    this.isLive = true;
    this.state = WorldState.PAUSED;
    for (const body of this.bodies) body.brain = "";
  }

  describeReplay(): object {
    return {
      recordedWorld: "arena",
      programVersion: "0.0.0",
      startedUnixNs: this.file.modifiedUnixNs,
      firstTick: this.first,
      lastTick: this.file.last,
      cutOff: this.file.cutOff,
      events: this.happened,
    } satisfies Partial<DescribeReplayResponse>;
  }

  override status(): WorldStatus {
    const status = super.status();
    const replay = { firstTick: this.first, lastTick: this.file.last, differs: this.file.differs };
    if (!this.isLive) status.replay = create(ReplayStatusSchema, replay);
    return status;
  }

  private look(): ReplayEvent[] {
    const { last } = this.file;
    const event = (tick: bigint, kind: K, text: string) => ({ tick, kind, text }) as ReplayEvent;
    const events = [
      event(0n, K.BRAIN, "avoid attached to alice"),
      event(last / 3n, K.CHANGE, "carol was put elsewhere by <b>hand</b>"),
      event(last / 2n, K.BRAIN, "bob's brain was gone"),
      event(last, K.ENDING, "the run ended: time was up"),
    ];
    while (this.tick < last) {
      super.step();
      this.bodies.forEach((body, i) => {
        const name = this.description.robots[i]?.robot ?? "";
        if (body.collided) events.push(event(this.tick, K.COLLISION, `${name} ran into wall`));
      });
    }
    this.reset();
    return events.sort((a, b) => Number(a.tick - b.tick));
  }
}
