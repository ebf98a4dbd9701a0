/** What the page knows of the server and its worlds. Everything in it is bounded. */
import type { Belief } from "../gen/baudbot/v1/brain_link_pb";
import type { DescribeWorldResponse } from "../gen/baudbot/v1/observe_pb";
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
  note: Note;
  /** Something that is drawn has changed besides a frame. */
  drawn: void;
};

const MOST_BUMPS = 60;

export class Store extends Emitter<Events> {
  worlds: WorldStatus[] = [];
  /** Names of the chosen world and robot; empty if there is none. */
  world = "";
  robot = "";
  description: DescribeWorldResponse | undefined;
  frame: Frame | undefined;
  record: RobotRecord | undefined;
  readonly motion = new Motion();
  readonly trails = new Trails();
  readonly beliefs = new Map<number, Belief>();
  bumps: Bump[] = [];
  /** Frames that came since the page was opened. */
  frames = 0;
  lastError = "";
  /** When each robot last ran into something, by the wall clock in milliseconds. */
  bumpedAt = new Float64Array(0);

  /** The chosen world's status, if it is known. */
  get status(): WorldStatus | undefined {
    return this.worlds.find((status) => status.world === this.world);
  }

  /** The chosen robot's place in the description; -1 if there is none. */
  get robotIndex(): number {
    return this.description?.robots.findIndex((robot) => robot.robot === this.robot) ?? -1;
  }

  setWorlds(worlds: WorldStatus[]): void {
    this.worlds = worlds;
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
    this.frame = undefined;
    this.forget();
    if (this.robotIndex < 0) this.robot = description?.robots[0]?.robot ?? this.robot;
    this.makeRecord();
    this.emit("world", undefined);
    this.emit("robot", undefined);
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
    // A world that was reset or restored begins anew.
    if (this.frame && frame.tick < this.frame.tick) {
      this.forget();
      this.makeRecord();
    }
    this.frame = frame;
    this.motion.take(frame, performance.now());
    for (const { robot, belief } of frame.rest.annotations)
      if (belief && saysSomething(belief)) this.beliefs.set(robot, belief);
      else this.beliefs.delete(robot);
    this.trails.take(frame.poses, (i) => this.description?.robots[i]?.radiusM ?? 0);
    this.record?.take(frame, this.record && this.beliefs.get(this.record.robot), first);
    this.noteBumps(frame);
    this.emit("frame", frame);
  }

  note(text: string, kind: Note["kind"] = "info"): void {
    if (kind === "error") this.lastError = text;
    this.emit("note", { text, kind });
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
    const now = performance.now();
    const bump = (robot: number) => (this.bumpedAt[robot] = now);
    frame.poses.collided.forEach((collided, i) => collided && bump(i));
    if (frame.rest.collisions.length === 0) return;
    const places = new Map(this.description?.robots.map((robot, i) => [robot.robot, i]));
    for (const collision of frame.rest.collisions) {
      const place = places.get(collision.robot);
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
  const { state, utilities, pose, particles, path, map } = belief;
  return state !== "" || [utilities, particles, path].some((list) => list.length > 0) || !!pose || !!map;
}
