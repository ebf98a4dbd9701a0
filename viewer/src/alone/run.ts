/** A run: a world is made, brains take hold of its robots, and it begins. */
import { WorldState, type WorldStatus } from "../gen/baudbot/v1/world_pb";
import { ControlService } from "../gen/baudbot/v1/control_pb";
import { secondsOf } from "../model/units";
import { ask, CallError, type Connection } from "../net/connection";
import { paceOf, type Orders, type PaceKind } from "../net/orders";
import type { Choice, Crew } from "./crew";

export interface Parts {
  connection: Connection;
  orders: Orders;
  crew: Crew;
}

export interface What {
  toml: string;
  brain: Choice;
  pace: PaceKind;
  /** When the run ends; without it the scenario says. */
  seconds: number | undefined;
  /** Whether all of it is recorded. */
  records: boolean;
}

/** How a run went that is over. */
export interface Result {
  simulated_s: number;
  took_s: number;
  ending: string;
  /** Fingerprint of the state, in hexadecimal digits. */
  hash: string;
  /** The name of its recording, if it has one. */
  recording: string | undefined;
}

/** Frames a simulated second that a recording has for other tools to look at. */
const LOOK_HZ = 10;

/** How often it is asked whether a run is over. */
const ASK_MS = 20;

/** Begins a run. One in lockstep is awaited, and its result given. */
export async function run(
  { connection, orders, crew }: Parts,
  { toml, brain, pace, seconds, records }: What,
): Promise<Result | undefined> {
  const made = await make(connection, toml, pace, seconds);
  const { world } = made;
  const robots = made.robots.map(({ robot }) => robot);
  try {
    await crew.begin(brain, world, robots);
  } catch (error) {
    await ask(connection, ControlService.method.deleteWorld, { world });
    throw error;
  }
  if (records) await ask(connection, ControlService.method.startRecording, { world, lookHz: LOOK_HZ });
  const begun = performance.now();
  await ask(connection, ControlService.method.startWorld, { world });
  const over = pace === "lockstep" && brain.kind !== "none" ? await end(connection, world) : undefined;
  const took_s = (performance.now() - begun) / 1000;
  await orders.list();
  orders.choose(world);
  if (!over) return undefined;
  const closed = records ? await ask(connection, ControlService.method.stopRecording, { world }) : undefined;
  const [simulated_s, hash] = [secondsOf(over.timeNs), hex(over.stateHash)];
  return { simulated_s, took_s, ending: over.ending, hash, recording: closed?.recording?.recording };
}

/** A paused world, under the scenario's name or one like it. */
async function make(
  connection: Connection,
  scenarioToml: string,
  pace: PaceKind,
  seconds: number | undefined,
): Promise<WorldStatus> {
  const overrides =
    seconds === undefined ? [] : [`end.after_s=${Number.isInteger(seconds) ? seconds.toFixed(1) : seconds}`];
  const name = /^name\s*=\s*"([^"]*)"/m.exec(scenarioToml)?.[1] ?? "";
  for (let number = 1; ; number++) {
    try {
      const world = number === 1 ? "" : `${name.slice(0, 58)}-${number}`;
      const request = { world, scenarioToml, overrides, pace: paceOf(pace), paused: true };
      const { status } = await ask(connection, ControlService.method.createWorld, request);
      if (!status) throw new Error("the server made no world");
      return status;
    } catch (error) {
      if (!(error instanceof CallError) || error.code !== "ALREADY_EXISTS" || name === "") throw error;
    }
  }
}

/** Waits for the end of a run. */
async function end(connection: Connection, world: string): Promise<WorldStatus> {
  for (;;) {
    const { status } = await ask(connection, ControlService.method.getWorld, { world });
    if (!status || status.state === WorldState.ENDED) return status!;
    if (status.robots.some((robot) => !robot.attached))
      throw new Error("a brain has released its robot; the world waits");
    await new Promise((resolve) => setTimeout(resolve, ASK_MS));
  }
}

function hex(hash: bigint): string {
  return hash.toString(16).padStart(16, "0");
}
