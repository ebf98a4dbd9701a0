/**
 * Drives the chosen robot: this page is its brain, at the end of its cable like any other. A Turn is answered at once
 * with what keys, gamepad or pad say at that moment, so that a world in lockstep is not held up. But one Step at most is
 * on its way: of the Turns that come before the server has it, the newest waits, and the others are void.
 *
 * That the robot stands when the page is gone the server sees to (`Hello.stop_when_gone`): a page cannot.
 */
import { create, fromBinary } from "@bufbuild/protobuf";
import {
  AttachResponseSchema,
  BrainLinkService,
  CommandSchema,
  HelloSchema,
  PortMode,
  RobotStepSchema,
  StepSchema,
  UntilMessageSchema,
  type AttachResponse,
  type RobotDescription,
  type RobotTurn,
  type Turn,
} from "../gen/baudbot/v1/brain_link_pb";
import { Emitter } from "../emitter";
import { CENTRED, signals, stickOfAxes, stickOfKeys, type Stick } from "../model/stick";
import type { Store } from "../model/store";
import type { CallError, Connection } from "./connection";

/** Without news the brain wants to be asked after so long all the same: hands move. */
const ASK_AGAIN_NS = 50_000_000n;
/** A command is repeated after so long even if no reading asks for it: robots may stop without one. */
const REPEAT_NS = 200_000_000n;
/** Bytes of a command with all that is around it, at most; commands must not queue on a slow cable. */
const COMMAND_BYTES = 16;

export class Drive extends Emitter<{ changed: void; rest: void }> {
  state: "off" | "asking" | "driving" = "off";
  /** Share of the largest signal that full stick means. */
  gain = 0.6;
  /** What the pad on the page says. */
  pad: Stick = CENTRED;
  readonly keys = new Set<string>();
  private call = 0;
  private driven = { world: "", robot: "" };
  private description: RobotDescription | undefined;
  private last = { left: NaN, right: NaN, at_ns: 0n };
  /** The server does not have the last Step yet. */
  private isUnderWay = false;
  /** The newest Turn that came meanwhile. */
  private waiting: Turn | undefined;
  /** Nobody looks at the page; a gamepad may lie on the floor. */
  private isAway = false;

  constructor(
    private readonly connection: Connection,
    private readonly store: Store,
  ) {
    super();
    store.on("robot", () => {
      const { world, robot } = this.driven;
      if (this.state !== "off" && (world !== store.world || robot !== store.robot)) this.stop();
    });
  }

  toggle(): void {
    if (this.state === "off") this.start();
    else this.stop();
  }

  start(): void {
    const { world, robot } = this.store;
    if (this.state !== "off" || robot === "") return;
    this.driven = { world, robot };
    this.last = { left: NaN, right: NaN, at_ns: 0n };
    [this.isUnderWay, this.waiting, this.isAway] = [false, undefined, false];
    const mode = PortMode.MESSAGES;
    const hello = create(HelloSchema, { world, robots: [robot], mode, brain: "page", stopWhenGone: true });
    const request = { request: { case: "hello" as const, value: hello } };
    const call = this.connection.begin(BrainLinkService.method.attach, request, {
      message: (bytes) => this.hear(fromBinary(AttachResponseSchema, bytes).response),
      taken: () => this.goOn(),
      over: (error) => call === this.call && this.over(error),
    });
    this.call = call;
    this.set("asking");
  }

  /** Lets the robot go, and the server stops it. */
  stop(): void {
    if (this.state === "off") return;
    this.tellWaiting();
    this.connection.end(this.call);
    this.over();
  }

  /** Nobody is at the keys any more, nor at the pad: the robot is told to stand until somebody is. */
  rest(): void {
    this.isAway = true;
    this.keys.clear();
    this.pad = CENTRED;
    this.emit("rest", undefined);
  }

  /** Somebody is back. */
  wake(): void {
    this.isAway = false;
  }

  /** In lockstep the world waits for a brain that has gone. */
  private tellWaiting(): void {
    const kind = this.store.status?.pace?.kind.case;
    if (kind === "lockstep") this.store.note("In lockstep the world now waits for a brain; Run continues without one.");
  }

  /** What is wanted now: the first of pad, keys and gamepad that is not at rest. */
  stick(): Stick {
    const pads = this.isAway ? [] : (globalThis.navigator?.getGamepads?.() ?? []);
    const axes = pads.find((pad) => pad?.connected)?.axes ?? [];
    const all = [this.pad, stickOfKeys(this.keys), stickOfAxes(axes)];
    return all.find((stick) => stick.forward !== 0 || stick.left !== 0) ?? CENTRED;
  }

  private hear(response: AttachResponse["response"]): void {
    if (response.case === "welcome") {
      this.description = response.value.robots[0];
      if (this.state === "asking") this.set("driving");
    } else if (response.case === "turn") {
      this.waiting = response.value;
      if (!this.isUnderWay) this.answer();
    } else if (response.case === "ended") {
      this.store.note("The run is over; Reset takes the world back to its start.");
    }
  }

  /** The server has the last Step. */
  private goOn(): void {
    this.isUnderWay = false;
    this.answer();
  }

  private answer(): void {
    const turn = this.waiting;
    if (!turn) return;
    this.waiting = undefined;
    const own = turn.robots.find((robot) => robot.robot === 0);
    const step = create(StepSchema, { turn: turn.turn, robots: own ? [this.part(own)] : [] });
    const request = { request: { case: "step" as const, value: step } };
    this.isUnderWay = this.connection.next(this.call, BrainLinkService.method.attach, request);
  }

  /** The robot's part of a Step: a command if there is something to say, and the wish to be asked at news. */
  private part(turn: RobotTurn) {
    const untilMessage = create(UntilMessageSchema, { atLatestNs: turn.atNs + ASK_AGAIN_NS });
    const limit = this.description?.signalLimit ?? 1;
    const wanted = signals(this.stick(), this.gain, limit);
    if (!this.isDue(turn, wanted)) return create(RobotStepSchema, { robot: 0, untilMessage });
    this.last = { ...wanted, at_ns: turn.atNs };
    const command = create(CommandSchema, { leftSignal: wanted.left, rightSignal: wanted.right });
    return create(RobotStepSchema, { robot: 0, output: { case: "command", value: command }, untilMessage });
  }

  private isDue(turn: RobotTurn, wanted: { left: number; right: number }): boolean {
    const since_ns = turn.atNs - this.last.at_ns;
    if (since_ns < 0n || Number.isNaN(this.last.left)) return true;
    const { bitsPerCharacter } = this.description ?? {};
    // Somebody may have changed it since the Welcome.
    const baud = this.store.record?.description.baud ?? this.description?.baud;
    const wire_ns = baud ? BigInt(Math.ceil((COMMAND_BYTES * (bitsPerCharacter ?? 10) * 1e9) / baud)) : 0n;
    if (since_ns < wire_ns) return false;
    const isChanged = wanted.left !== this.last.left || wanted.right !== this.last.right;
    return isChanged || since_ns >= REPEAT_NS || turn.readings.some((reading) => reading.readable);
  }

  private over(error?: CallError): void {
    this.call = 0;
    if (error) this.store.note(error.message, "error");
    this.keys.clear();
    this.pad = CENTRED;
    this.set("off");
  }

  private set(state: Drive["state"]): void {
    this.state = state;
    this.emit("changed", undefined);
  }
}
