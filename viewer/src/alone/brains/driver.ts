/** The brains of a stream's robots: which of them are asked in a Turn, and that each run has new ones. */
import { create } from "@bufbuild/protobuf";
import {
  StepSchema,
  type AttachResponse,
  type RobotDescription,
  type RobotTurn,
  type Turn,
} from "../../gen/baudbot/v1/brain_link_pb";
import type { Make, Step } from "./javascript";
import { BrainTurn, stepOf } from "./turn";

/** What is kept of a robot in a run. */
interface Seat {
  memory: Record<string, unknown>;
  /** What its brain waits for ends then, by the robot's clock. */
  deadline_ns: bigint;
  /** In which tick it stepped last. */
  tick: bigint;
}

export class Driver {
  private robots: RobotDescription[] = [];
  private seats: Seat[] = [];
  private step: Step;

  /** Makes a first brain at once: one that cannot be made takes no robot. */
  constructor(private readonly make: Make) {
    this.step = make();
  }

  /** The request that answers, if there is one. */
  hear(response: AttachResponse["response"]) {
    if (response.case === "welcome") {
      this.robots = response.value.robots;
      this.seat();
    } else if (response.case === "turn") {
      return { case: "step" as const, value: this.answer(response.value) };
    }
    return undefined;
  }

  private answer({ turn, tick, robots }: Turn) {
    // Nobody tells a brain that its world was reset or restored: a robot steps once in a tick.
    if (robots.some((part) => tick <= this.seats[part.robot]!.tick)) {
      this.step = this.make();
      this.seat();
    }
    return create(StepSchema, { turn, robots: robots.map((part) => this.part(part, tick)) });
  }

  private part(part: RobotTurn, tick: bigint) {
    const seat = this.seats[part.robot]!;
    seat.tick = tick;
    // A server asks brains that wait, too, unless it waits for them. Without a message there is nothing to answer; one may come without readings.
    const hasNews = part.hasMessage || part.readings.some((reading) => reading.readable);
    if (part.atNs < seat.deadline_ns && !hasNews) {
      return { robot: part.robot, untilMessage: { atLatestNs: seat.deadline_ns } };
    }
    const shown = new BrainTurn(part, this.robots[part.robot]!, Number(tick));
    const answer = stepOf(part, this.step(shown, seat.memory));
    seat.deadline_ns = answer.untilMessage.atLatestNs;
    return answer;
  }

  /** A run begins without what was kept from another one, and with nothing to wait for longer than usual. */
  private seat(): void {
    this.seats = this.robots.map(() => ({ memory: {}, deadline_ns: 0n, tick: -1n }));
  }
}
