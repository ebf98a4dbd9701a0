/** A made-up world that moves: robots on curves, readings that come late, events as on a cable of 9600 baud. */
import { create } from "@bufbuild/protobuf";
import { BeliefSchema, SensorKind, type Belief } from "../src/gen/baudbot/v1/brain_link_pb";
import {
  PinSignalSchema,
  RobotDetailSchema,
  RobotTruthSchema,
  TimelineKind as K,
  WatchResponseSchema,
  type RobotDetail,
  type RobotTruth,
  type WatchResponse,
} from "../src/gen/baudbot/v1/observe_pb";
import { PaceSchema, WorldState, WorldStatusSchema, type Pace, type WorldStatus } from "../src/gen/baudbot/v1/world_pb";
import { MockFloor, SENSED_M } from "./mock_floor";
import { pinEvents, PINS } from "./mock_pins";
import { describe, IRS, LASER, PILLAR, ROOM, STEP_NS, WHEELS } from "./mock_scene";

interface Body {
  x_m: number;
  y_m: number;
  heading_rad: number;
  left: number;
  right: number;
  counts: [number, number];
  collided: boolean;
  brain: string;
  /** How often its brain has started over. */
  restarts: number;
  cable: boolean;
}

export class MockWorld {
  readonly description;
  tick = 0n;
  state = WorldState.RUNNING;
  pace: Pace = create(PaceSchema, { kind: { case: "realTime", value: {} } });
  bodies: Body[] = [];
  box = { xM: 0.6, yM: -0.6, headingRad: 0.3 };
  lost = 0n;
  /** Reads of each sensor that were left out. */
  missed = 0n;
  recording: { recording: string; bytes: bigint; ticks: bigint; problem: string } | undefined;
  baud = 9600;
  readonly floor = new MockFloor();
  /** Whether the last Watch asked for what is on pins. */
  pinsAsked = false;
  /** How often the map of its floor was asked for. */
  mapsAsked = 0;
  readonly snapshots = new Map<bigint, { tick: bigint; bodies: Body[] }>();

  constructor(
    readonly name: string,
    readonly robots: number,
    /** Whether it counts which cells of its floor are covered. */
    readonly counts = true,
  ) {
    this.description = describe(robots);
    const carol = this.description.robots.find(({ robot }) => robot === "carol");
    if (carol) carol.pins = PINS.map((signal) => create(PinSignalSchema, signal));
    this.reset();
  }

  reset(): void {
    this.tick = 0n;
    this.floor.clear();
    this.bodies = this.description.robots.map((robot, i) => ({
      x_m: this.robots === 3 ? ([-1, 0.3, -0.5][i] ?? 0) : -2.6 + 5.2 * frac(i * 0.61803),
      y_m: this.robots === 3 ? ([0, 0.5, -0.9][i] ?? 0) : -1.7 + 3.4 * frac(i * 0.7548),
      heading_rad: i * 1.3,
      left: 0,
      right: 0,
      counts: [0, 0],
      collided: false,
      cable: true,
      restarts: 0,
      brain: robot.robot === "carol" ? "" : "avoid",
    }));
  }

  get time_s(): number {
    return Number(this.tick * STEP_NS) / 1e9;
  }

  /** One tick: brains steer, bodies roll and turn away from walls. */
  step(): void {
    this.tick++;
    if (this.recording) {
      this.recording.ticks++;
      this.recording.bytes += 321n;
    }
    this.bodies.forEach((body, i) => {
      if (body.brain === "avoid") this.steer(body, i);
      const radius_m = this.description.robots[i]?.radiusM ?? 0.2;
      this.roll(body, radius_m);
      this.floor.mark(this.floor.covered, body.x_m, body.y_m, radius_m);
      this.floor.mark(this.floor.sensed, body.x_m, body.y_m, radius_m + SENSED_M);
    });
  }

  private steer(body: Body, i: number): void {
    const ahead = this.cast(body.x_m, body.y_m, body.heading_rad, 1.2);
    const turn = ahead < 0.75 ? 0.45 : 0.12 * Math.sin(0.4 * this.time_s + i);
    body.left = 0.5 - turn;
    body.right = 0.5 + turn;
  }

  private roll(body: Body, radius_m: number): void {
    const dt = 0.01;
    const [left_m, right_m] = [body.left * 0.6 * dt, body.right * 0.6 * dt];
    body.heading_rad += (right_m - left_m) / (2 * WHEELS.half_track_m);
    const [x_m, y_m] = [
      body.x_m + ((left_m + right_m) / 2) * Math.cos(body.heading_rad),
      body.y_m + ((left_m + right_m) / 2) * Math.sin(body.heading_rad),
    ];
    body.collided = this.hits(x_m, y_m, radius_m);
    if (body.collided) body.heading_rad += 0.7;
    else [body.x_m, body.y_m] = [x_m, y_m];
    // A wheel slips a little, so that dead reckoning goes astray.
    const perMetre = WHEELS.counts / (2 * Math.PI * WHEELS.radius_m);
    body.counts = [body.counts[0] + left_m * perMetre * 1.01, body.counts[1] + right_m * perMetre];
  }

  /** Whether there is no room for a disc. */
  hits(x_m: number, y_m: number, radius_m: number): boolean {
    const isOut = Math.abs(x_m) > ROOM.x_m - radius_m || Math.abs(y_m) > ROOM.y_m - radius_m;
    return isOut || Math.hypot(x_m - PILLAR.x_m, y_m - PILLAR.y_m) < PILLAR.radius_m + radius_m;
  }

  /** How far a ray runs. */
  cast(x_m: number, y_m: number, angle: number, range_m: number): number {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const wall = Math.min(
      ((cos > 0 ? ROOM.x_m : -ROOM.x_m) - x_m) / (cos || 1e-9),
      ((sin > 0 ? ROOM.y_m : -ROOM.y_m) - y_m) / (sin || 1e-9),
    );
    const [dx, dy] = [PILLAR.x_m - x_m, PILLAR.y_m - y_m];
    const along = dx * cos + dy * sin;
    const off2 = PILLAR.radius_m ** 2 - (dx * dx + dy * dy - along * along);
    const pillar = along > 0 && off2 > 0 ? along - Math.sqrt(off2) : Infinity;
    return Math.min(wall, pillar, range_m);
  }

  truth(i: number): RobotTruth {
    const body = this.bodies[i] as Body;
    const samples = this.robots === 3 ? this.sample(i).flat() : body.counts;
    return create(RobotTruthSchema, {
      xM: body.x_m,
      yM: body.y_m,
      headingRad: wrap(body.heading_rad),
      speedMS: 0.3 * (body.left + body.right),
      turnRateRadS: body.right - body.left,
      leftSignal: body.left,
      rightSignal: body.right,
      collided: body.collided,
      samples,
      battery: i === 1 ? { charge: Math.max(0, 1 - this.time_s / 600), voltageV: 11.8, currentA: 0.4 } : undefined,
      actuators:
        i === 0 && this.robots === 3 ? [{ signal: Math.sin(this.time_s), angleRad: Math.sin(this.time_s) }] : [],
    });
  }

  /** The readings of each sensor now. */
  private sample(i: number): number[][] {
    const body = this.bodies[i] as Body;
    const ray = (k: number) => body.heading_rad + LASER.opening_rad * (k / (LASER.rays - 1) - 0.5);
    return (this.description.robots[i]?.description?.sensors ?? []).map((sensor) => {
      if (sensor.kind === SensorKind.ENCODERS)
        return body.counts.map((count) => ((Math.round(count) % 65536) + 65536) % 65536);
      if (sensor.kind === SensorKind.COMPASS) return [wrap(body.heading_rad)];
      if (sensor.kind === SensorKind.LASER)
        return Array.from({ length: LASER.rays }, (_, k) => {
          const length_m = this.cast(body.x_m, body.y_m, ray(k), LASER.range_m);
          return length_m < LASER.range_m ? length_m : -1;
        });
      const length_m = this.cast(body.x_m, body.y_m, body.heading_rad + (sensor.mount?.headingRad ?? 0), 1.2) - 0.2;
      return [Math.max(0, 1 - length_m)];
    });
  }

  detail(i: number, since: bigint, pins: boolean): RobotDetail {
    const body = this.bodies[i] as Body;
    const cycles = this.tick / 2n;
    const sensors = this.description.robots[i]?.description?.sensors ?? [];
    const samples = this.sample(i);
    const line = { bytes: cycles * 19n, messages: cycles, lostBytes: this.lost };
    return create(RobotDetailSchema, {
      robot: i,
      attached: body.brain !== "",
      cablePulled: !body.cable,
      brain: body.brain,
      sensors: sensors.map((sensor, s) => {
        const period = sensor.periodNs / STEP_NS;
        const at = this.tick - (this.tick % period) - 1n;
        const known = at >= 0n && body.brain !== "" && this.tick > 20n;
        return {
          values: known ? samples[s] : [],
          sampledAtNs: known ? at * STEP_NS : undefined,
          leastAgeNs: known ? (this.tick - at) * STEP_NS : undefined,
          mostAgeNs: known ? (this.tick - at) * STEP_NS : undefined,
          readable: known && this.tick % period < 1n,
          samples: this.tick / period,
          missed: this.missed,
          readableSteps: this.tick / period,
          rays: this.rays(body, sensor.kind, s, sensors.length),
        };
      }),
      uplink: line,
      downlink: { bytes: cycles * 8n, messages: cycles, badFrames: 0n },
      uplinkWaitingBytes: BigInt(Number(this.tick) % 20),
      downlinkWaitingBytes: 0n,
      cycles: {
        deadlineNs: STEP_NS,
        kept: 0n,
        late: cycles,
        unanswered: 2n,
        durations: { count: cycles, p50Ns: 28_805_000n, p95Ns: 28_805_000n },
      },
      events: body.brain === "" ? [] : this.events(since, sensors.length),
      pinEvents: pins && this.description.robots[i]?.pins.length ? pinEvents(since, this.tick) : [],
    });
  }

  private rays(body: Body, kind: SensorKind, s: number, sensors: number) {
    if (kind !== SensorKind.IR && kind !== SensorKind.LASER) return undefined;
    const isLaser = kind === SensorKind.LASER;
    const bearing = isLaser
      ? 0
      : (IRS[sensors === 6 && IRS.length === 5 && s < 5 && !this.isBob(body) ? s : s + 1] ?? 0);
    const from = isLaser ? 0.05 : 0.2;
    const [x_m, y_m] = [
      body.x_m + from * Math.cos(body.heading_rad + bearing),
      body.y_m + from * Math.sin(body.heading_rad + bearing),
    ];
    const [count, opening_rad, range_m] = isLaser ? [LASER.rays, LASER.opening_rad, LASER.range_m] : [5, 0.5, 1];
    const heading_rad = body.heading_rad + bearing;
    const lengthsM = Array.from({ length: count }, (_, k) =>
      this.cast(x_m, y_m, heading_rad + opening_rad * (k / (count - 1) - 0.5), range_m),
    );
    return { xM: x_m, yM: y_m, headingRad: heading_rad, openingRad: opening_rad, lengthsM };
  }

  private isBob(body: Body): boolean {
    return this.bodies[1] === body;
  }

  /** As in the diagram of `wander`: 19 bytes up and 8 down at 9600 baud, every 20 ms. */
  private events(since: bigint, sensors: number) {
    const events: { startNs: bigint; endNs: bigint; kind: K; part?: number; bytes?: number }[] = [];
    for (let cycle = since / 2n; cycle < this.tick / 2n; cycle++) {
      const at = (us: number) => BigInt(Math.max(0, Math.round(us * 1000))) + (cycle - 1n) * 20_000_000n;
      const add = (from: number, until: number, kind: K, part?: number, bytes = 0) =>
        events.push({ startNs: at(from), endNs: at(until), kind, part, bytes });
      if (cycle < 2n) continue;
      for (let s = 0; s < Math.min(5, sensors); s++) add(112 * s, 112 * (s + 1), K.ACQUIRE, s);
      add(600, 695, K.FRAME, undefined, 19);
      add(695, 20_487, K.UP, undefined, 19);
      add(20_487 - 10_487, 20_487 - 10_487, K.THINK, 0);
      add(20_487, 21_900, K.THINK, 1);
      add(21_900, 30_200, K.DOWN, undefined, 8);
      add(22_940, 30_260, K.OBEY);
      add(31_000, 31_000, K.ACT);
      add(10_000, 10_000, K.LATE);
    }
    return events;
  }

  belief(): Belief {
    const body = this.bodies[0] as Body;
    const off = { x_m: 0.12 * Math.sin(this.time_s / 3), y_m: 0.1 * Math.cos(this.time_s / 4) };
    const [x, y] = [body.x_m + off.x_m, body.y_m + off.y_m];
    const near = this.cast(body.x_m, body.y_m, body.heading_rad, 1.2) < 0.75;
    return create(BeliefSchema, {
      state: near ? "avoid <b>wall</b>" : "explore",
      utilities: [
        { name: "explore", value: near ? 0.3 : 0.7, active: !near },
        { name: "avoid", value: near ? 0.9 : 0.1, active: near },
        { name: "charge", value: 0.2 },
      ],
      pose: { xM: x, yM: y, headingRad: body.heading_rad + 0.05, covarianceM2: [0.012, 0.006, 0.008] },
      particles: Array.from({ length: 60 }, (_, i) => ({
        xM: x + 0.3 * (frac(i * 0.618) - 0.5),
        yM: y + 0.3 * (frac(i * 0.754) - 0.5),
        headingRad: body.heading_rad + frac(i * 0.31) - 0.5,
        weight: frac(i * 0.77),
      })),
      path: [
        { xM: x, yM: y },
        { xM: 0.2, yM: 0.2 },
        { xM: 1.0, yM: 0.2 },
        { xM: 2.3, yM: 1.3 },
      ],
      map: { xM: -3, yM: -2, cellM: 0.2, columns: 30, cells: this.map() },
    });
  }

  private map(): Uint8Array {
    return Uint8Array.from({ length: 600 }, (_, i) => {
      const [column, row] = [i % 30, Math.floor(i / 30)];
      if (column * 0.2 - 3 > -1.5 + this.time_s / 10) return 255;
      return column === 0 || row === 0 || row === 19 || (column > 3 && column < 6 && row > 14 && row < 17) ? 254 : 10;
    });
  }

  frame(details: number[], since: bigint, pins = false): WatchResponse {
    const collisions = this.bodies.flatMap((body, i) =>
      body.collided ? [{ robot: this.description.robots[i]?.robot ?? "", with: "wall" }] : [],
    );
    return create(WatchResponseSchema, {
      tick: this.tick,
      timeNs: this.tick * STEP_NS,
      robots: this.bodies.map((_, i) => this.truth(i)),
      collisions,
      things: [
        { thing: "box", ...this.box },
        { thing: "door", xM: -0.2, yM: 1.3, headingRad: 0.8 * Math.sin(this.time_s / 2) },
      ],
      score: {
        ...(this.counts && this.floor.score),
        goals: 1,
        goalsReached: 0,
        zones: [{ zone: "goal", goal: true }, { zone: "dock" }],
      },
      details: details.map((i) => this.detail(i, since, pins)),
      annotations: this.robots === 3 ? [{ robot: 0, belief: this.belief() }] : [],
    });
  }

  status(): WorldStatus {
    return create(WorldStatusSchema, {
      world: this.name,
      scenario: "mock",
      state: this.state,
      pace: this.pace,
      tick: this.tick,
      timeNs: this.tick * STEP_NS,
      stepNs: STEP_NS,
      recording: this.recording,
      robots: this.description.robots.map(({ robot }, i) => ({
        robot,
        brain: this.bodies[i]?.brain ?? "",
        attached: this.bodies[i]?.brain !== "",
      })),
    });
  }
}

function frac(value: number): number {
  return value - Math.floor(value);
}

function wrap(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}
