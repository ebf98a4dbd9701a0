/** What is kept of the chosen robot: values over time, freshness, timeline, where it was, dead reckoning. */
import type { Belief, RobotDescription } from "../gen/baudbot/v1/brain_link_pb";
import type { RobotDetail, RobotTruth } from "../gen/baudbot/v1/observe_pb";
import type { Frame } from "../net/frames";
import { DeadReckoning, wheelSensor, type Reckoned } from "./odometry";
import type { Pose } from "./pose";
import { agesOf, joined, quantities, sentBy, type Ages, type Sent, type Snapshot, type Values } from "./quantities";
import { Ring, SeriesTable } from "./ring";
import { PinLog } from "./pins";
import { Timeline } from "./timeline";
import { Trail } from "./trail";
import { numberOf, secondsOf } from "./units";

/** Frames that are kept: over two minutes at 25 a second. */
const FRAMES = 4096;
const COLUMNS = 200;
/** Frames that a strip of freshness shows. */
export const STRIP = 96;
/** Sensors that have a strip. */
const MOST_STRIPS = 64;
/** True poses that are kept, to know where the robot was when an old reading was taken. */
const POSES = 256;
/** Rates are those over so long: bytes come in bursts, and a shorter time would show nothing else. */
const RATE_SPAN_NS = 1_000_000_000n;
const MOST_SENT = 128;
/** Instants of dead reckoning that are kept, to go back to. */
const MOST_RECKONED = 1024;

export class RobotRecord {
  readonly series = new SeriesTable(FRAMES, COLUMNS);
  readonly timeline = new Timeline();
  readonly pins = new PinLog();
  readonly strips: Ring[];
  private readonly stripTimes = new Ring(STRIP);
  /** How old each sensor's readings were since somebody looked. */
  private ages: (Ages | undefined)[] = [];
  readonly ghostTrail = new Trail(900);
  readonly ghost: DeadReckoning | undefined;
  now: Snapshot | undefined;
  values: Values = new Map();
  private readonly history = [new Ring(POSES), new Ring(POSES), new Ring(POSES), new Ring(POSES)] as const;
  private ghostSampledAt: bigint | undefined;
  private reckoned: { tick: number; state: Reckoned }[] = [];
  private lastTick = -Infinity;
  private sent: Sent[] = [];

  constructor(
    /** Its place in DescribeWorld. */
    readonly robot: number,
    readonly description: RobotDescription,
    readonly radius_m: number,
  ) {
    this.strips = description.sensors.slice(0, MOST_STRIPS).map(() => new Ring(STRIP));
    const source = wheelSensor(description);
    this.ghost = source && new DeadReckoning(source);
  }

  /**
   * A frame has come; `first` of its Watch, it may be one that is here already. Over more than `longest` ticks nothing is
   * reckoned on. One that is more than `near_s` after the one before does not follow on it: frames between were missed.
   */
  take(frame: Frame, belief: Belief | undefined, first: boolean, longest = Infinity, near_s = Infinity): void {
    const tick = Number(frame.tick);
    if (tick - this.lastTick > longest) this.leap();
    this.lastTick = tick;
    const detail = frame.rest.details.find((detail) => detail.robot === this.robot);
    const now: Snapshot = { time_ns: frame.timeNs, truth: frame.truth(this.robot), detail, belief };
    const before = this.now;
    const isNew = before === undefined || before.time_ns !== now.time_ns;
    this.values = quantities(this.description, now, this.sent[0]);
    this.now = now;
    this.ages = this.description.sensors.map((_, i) => joined(this.ages[i], agesOf(now, i)));
    if (detail) this.timeline.take(detail.events, first);
    if (detail) this.pins.take(detail.pinEvents, detail.missedPinEvents, Number(frame.timeNs));
    if (isNew) {
      this.series.push(secondsOf(now.time_ns), this.values, near_s);
      if (now.truth) this.remember(now.time_ns, now.truth);
      if (detail) this.freshness(detail, before?.detail, now.time_ns);
      this.rememberSent(now);
    }
    if (detail && now.truth) this.reckon(detail, now.truth, tick, longest);
  }

  /** The world went back: what is not before this tick, and its instant, has not happened. */
  cut(tick: number, time_ns: number): void {
    const [poses, marks] = [laterThan(this.history[0], time_ns), laterThan(this.stripTimes, time_ns)];
    for (const ring of this.history) ring.drop(poses);
    for (const strip of [...this.strips, this.stripTimes]) strip.drop(marks);
    let seen = 0;
    this.series.cut(time_ns / 1e9, time_ns > -Infinity);
    this.timeline.cut(time_ns);
    this.pins.cut(time_ns);
    this.ghostTrail.cut(tick);
    while (seen < this.reckoned.length && (this.reckoned[seen]?.tick ?? 0) <= tick) seen++;
    this.reckoned = this.reckoned.slice(0, seen);
    const last = this.reckoned.at(-1);
    this.ghost?.goOn(last?.state);
    this.lastTick = last?.tick ?? -Infinity;
    this.now = this.ghostSampledAt = undefined;
    this.ages = [];
    this.values = new Map();
    this.sent = [];
  }

  /** It is elsewhere all at once: dead reckoning starts over where it truly is. */
  private leap(): void {
    this.ghost?.goOn(undefined);
    this.ghostSampledAt = undefined;
    this.sent = [];
    for (const ring of this.history) ring.drop(POSES);
  }

  /** How old a sensor's readings were since the last call for it; undefined if no frame has come since then that knows it. */
  takeAges(sensor: number): Ages | undefined {
    const ages = this.ages[sensor];
    this.ages[sensor] = undefined;
    return ages;
  }

  /** Where it truly was at an instant, as far as that is remembered. */
  poseAt(time_ns: bigint): Pose | undefined {
    const [times, xs, ys, headings] = this.history;
    const wanted = numberOf(time_ns);
    let i = times.length - 1;
    while (i > 0 && times.at(i) > wanted) i--;
    return i < 0 ? undefined : { x_m: xs.at(i), y_m: ys.at(i), heading_rad: headings.at(i) };
  }

  private remember(time_ns: bigint, truth: RobotTruth): void {
    const values = [numberOf(time_ns), truth.xM, truth.yM, truth.headingRad];
    this.history.forEach((ring, i) => ring.push(values[i] ?? NaN));
  }

  private rememberSent(now: Snapshot): void {
    const sent = sentBy(now);
    if (!sent) return;
    this.sent.push(sent);
    const isOld = ({ time_ns }: Sent) => now.time_ns - time_ns > RATE_SPAN_NS;
    while (this.sent.length > MOST_SENT || (this.sent[1] && isOld(this.sent[1]))) this.sent.shift();
  }

  /** 1 if a sensor was readable since the last frame, 0 if not, NaN if nothing of it has come yet. */
  private freshness(detail: RobotDetail, before: RobotDetail | undefined, time_ns: bigint): void {
    this.stripTimes.push(numberOf(time_ns));
    this.strips.forEach((strip, i) => {
      const [sensor, last] = [detail.sensors[i], before?.sensors[i]];
      const came = sensor !== undefined && last !== undefined && sensor.readableSteps > last.readableSteps;
      const known = sensor !== undefined && sensor.values.length > 0;
      strip.push(known ? Number(sensor.readable || came) : NaN);
    });
  }

  private reckon(detail: RobotDetail, truth: RobotTruth, tick: number, longest: number): void {
    const sensor = this.ghost && detail.sensors[this.ghost.source.sensor];
    if (!this.ghost || !sensor || sensor.values.length === 0) return;
    const at_ns = sensor.sampledAtNs;
    if (at_ns !== undefined && at_ns === this.ghostSampledAt) return;
    this.ghostSampledAt = at_ns;
    const here = { x_m: truth.xM, y_m: truth.yM, heading_rad: truth.headingRad };
    this.ghost.take(sensor.values, (at_ns !== undefined && this.poseAt(at_ns)) || here);
    const state = this.ghost.reckoned;
    if (!state) return;
    this.ghostTrail.add(state.pose.x_m, state.pose.y_m, 0.15 * this.radius_m, tick, longest);
    this.reckoned.push({ tick, state });
    if (this.reckoned.length > 2 * MOST_RECKONED) this.reckoned = this.reckoned.slice(-MOST_RECKONED);
  }
}

/** How many of the newest instants are not before this one. */
function laterThan(times: Ring, time_ns: number): number {
  let later = 0;
  while (later < times.length && times.at(times.length - 1 - later) >= time_ns) later++;
  return later;
}
