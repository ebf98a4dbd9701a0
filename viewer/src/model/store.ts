/** What the page knows of the server and its worlds. Everything in it is bounded. */
import type { Belief } from "../gen/baudbot/v1/brain_link_pb";
import type { DescribeWorldResponse, GetCoverageResponse } from "../gen/baudbot/v1/observe_pb";
import type { WorldStatus } from "../gen/baudbot/v1/world_pb";
import { Emitter } from "../emitter";
import type { Frame } from "../net/frames";
import { Motion } from "./motion";
import { RobotRecord } from "./record";
import { Trails } from "./trail";
import { secondsOf } from "./units";

/** Something that was worth telling people. */
export interface Note {
  text: string;
  kind: "error" | "info";
}

/** A collision, for the list of the last ones. */
export interface Bump {
  time_s: number;
  robot: string;
  with: string;
}

type Events = {
  /** The list of worlds, or the status of one. */
  worlds: void;
  /** Another world, or its description has come. */
  world: void;
  /** Another robot, or none. */
  robot: void;
  frame: Frame;
  /** The pins of chips are looked at, or no longer. */
  pins: void;
  /** The next frame is of quite another tick. */
  leap: void;
  /** The world was reset or restored: another run goes on, perhaps in another arena. */
  restart: void;
  note: Note;
  /** Something that is drawn has changed besides a frame. */
  drawn: void;
};

const MOST_BUMPS = 60;
/** In a replay, frames that are farther apart are not of one way, in seconds: somebody sought. */
const LONGEST_S = 0.5;

export class Store extends Emitter<Events> {
  worlds: WorldStatus[] = [];
  /** Why the worlds are not shown, if somebody has no right to see them. */
  hidden = "";
  /** Names of the chosen world and robot; empty if there is none. */
  world = "";
  robot = "";
  /** Whether the pins of the chosen robot's chip are looked at, if it has one. */
  showsPins = true;
  description: DescribeWorldResponse | undefined;
  frame: Frame | undefined;
  record: RobotRecord | undefined;
  readonly motion = new Motion();
  readonly trails = new Trails();
  readonly beliefs = new Map<number, Belief>();
  /** Which cells of the floor are covered, as it was not long ago; undefined if the world does not count that. */
  coverage: GetCoverageResponse | undefined;
  bumps: Bump[] = [];
  /** Frames that came since the page was opened. */
  frames = 0;
  lastError = "";
  /** Ticks between two frames, as they are asked for, and as they were asked for before. */
  stride = 1;
  private formerStride = 1;
  /** The same while a film is made. */
  filmStride = 0;
  /** The time that shows how old what is drawn is, in milliseconds. */
  clock: () => number = () => performance.now();
  /** Robots' places in the description, by name. */
  private places = new Map<string, number>();
  /** When each robot last ran into something, by `clock`. */
  bumpedAt = new Float64Array(0);

  /** The chosen world's status, if it is known. */
  get status(): WorldStatus | undefined {
    return this.worlds.find((status) => status.world === this.world);
  }

  /** The chosen robot's place in the description; -1 if there is none. */
  get robotIndex(): number {
    return this.places.get(this.robot) ?? -1;
  }

  /** Over more ticks than this it is not known how things came to where they are. */
  get longest(): number {
    if (!this.status?.replay) return Infinity;
    const step_s = secondsOf(this.description?.stepNs ?? 0n) || LONGEST_S;
    return Math.max(3 * this.stride, 3 * this.filmStride, LONGEST_S / step_s);
  }

  /** A Watch begins, with so many ticks between two frames. */
  setStride(ticks: number): void {
    [this.formerStride, this.stride] = [this.stride, ticks];
  }

  /** Frames that are farther apart than this, in seconds, do not follow on each other: others were missed. */
  private get near_s(): number {
    const ticks = Math.max(this.stride, this.formerStride, this.filmStride);
    return 1.5 * ticks * secondsOf(this.description?.stepNs ?? 0n) || Infinity;
  }

  setWorlds(worlds: WorldStatus[]): void {
    [this.worlds, this.hidden] = [worlds, ""];
    this.emit("worlds", undefined);
  }

  /** The server does not show its worlds. */
  hideWorlds(why: string): void {
    [this.worlds, this.hidden] = [[], why];
    this.emit("worlds", undefined);
  }

  /** One world has answered. */
  setStatus(status: WorldStatus | undefined): void {
    if (!status) return;
    const others = this.worlds.filter((other) => other.world !== status.world);
    this.setWorlds([...others, status].sort((a, b) => (a.world < b.world ? -1 : 1)));
  }

  chooseWorld(world: string, robot = ""): void {
    if (world === this.world) return;
    this.world = world;
    this.robot = robot;
    this.describe(undefined);
  }

  describe(description: DescribeWorldResponse | undefined): void {
    this.description = description;
    this.places = new Map(description?.robots.map((robot, i) => [robot.robot, i]));
    this.frame = this.coverage = undefined;
    this.forget();
    if (this.robotIndex < 0) this.robot = description?.robots[0]?.robot ?? this.robot;
    this.makeRecord();
    this.emit("world", undefined);
    this.emit("robot", undefined);
  }

  /** Whether the chosen robot's microcontroller runs a program of the user's own. */
  get hasChip(): boolean {
    return (this.description?.robots[this.robotIndex]?.pins.length ?? 0) > 0;
  }

  showPins(on: boolean): void {
    this.showsPins = on;
    this.emit("pins", undefined);
  }

  chooseRobot(robot: string): void {
    if (robot === this.robot) return;
    this.robot = robot;
    this.makeRecord();
    this.emit("robot", undefined);
  }

  /** A frame has come; `first` of its Watch. */
  take(frame: Frame, first: boolean): void {
    this.frames++;
    const ticks = Number(frame.tick - (this.frame?.tick ?? frame.tick));
    if (ticks < 0) this.goBack(frame);
    else if (ticks > this.longest) this.leap();
    this.frame = frame;
    this.motion.take(frame, this.clock());
    for (const { robot, belief } of frame.rest.annotations)
      if (belief && saysSomething(belief)) this.beliefs.set(robot, belief);
      else this.beliefs.delete(robot);
    const { longest, near_s } = this;
    if (!this.status?.replay) this.record?.series.forgetLater();
    this.trails.take(frame.poses, (i) => this.description?.robots[i]?.radiusM ?? 0, Number(frame.tick), longest);
    this.record?.take(frame, this.record && this.beliefs.get(this.record.robot), first, longest, near_s);
    if (!first) this.formerStride = this.stride;
    this.noteBumps(frame);
    this.emit("frame", frame);
  }

  setCoverage(map: GetCoverageResponse): void {
    this.coverage = map;
    this.emit("drawn", undefined);
  }

  note(text: string, kind: Note["kind"] = "info"): void {
    if (kind === "error") this.lastError = text;
    this.emit("note", { text, kind });
  }

  /** A replay does again what was before; a world that was reset or restored starts over. */
  private goBack(frame: Frame): void {
    const isReplay = this.status?.replay !== undefined;
    const [tick, time_ns] = isReplay ? [Number(frame.tick), Number(frame.timeNs)] : [-Infinity, -Infinity];
    this.leap();
    this.beliefs.clear();
    this.trails.cut(tick);
    this.record?.cut(tick, time_ns);
    this.bumps = this.bumps.filter((bump) => bump.time_s < time_ns / 1e9);
    if (!isReplay) this.emit("restart", undefined);
  }

  private leap(): void {
    this.motion.reset();
    this.bumpedAt.fill(-Infinity);
    this.emit("leap", undefined);
  }

  private forget(): void {
    const robots = this.description?.robots.length ?? 0;
    this.motion.reset();
    this.trails.reset(robots);
    this.beliefs.clear();
    this.bumps = [];
    this.bumpedAt = new Float64Array(robots).fill(-Infinity);
  }

  private makeRecord(): void {
    const index = this.robotIndex;
    const robot = this.description?.robots[index];
    const description = robot?.description;
    this.record = description && new RobotRecord(index, description, robot.radiusM);
  }

  private noteBumps(frame: Frame): void {
    const now = this.clock();
    const bump = (robot: number) => (this.bumpedAt[robot] = now);
    frame.poses.collided.forEach((collided, i) => collided && bump(i));
    if (frame.rest.collisions.length === 0) return;
    for (const collision of frame.rest.collisions) {
      const place = this.places.get(collision.robot);
      if (place !== undefined) bump(place);
    }
    const time_s = secondsOf(frame.timeNs);
    const bumps = frame.rest.collisions
      .slice(-MOST_BUMPS)
      .map(({ robot, with: what }) => ({ time_s, robot, with: what }));
    this.bumps = [...this.bumps, ...bumps].slice(-MOST_BUMPS);
  }
}

/** An empty belief says that what was said before is void. */
function saysSomething(belief: Belief): boolean {
  const { state, utilities, pose, particles, path, map, motivation } = belief;
  return (
    state !== "" || [utilities, particles, path].some((list) => list.length > 0) || !!pose || !!map || !!motivation
  );
}
