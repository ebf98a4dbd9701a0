/** A Turn as brains that are typed into the page see it, and what they answer. */
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { RobotDescription, RobotStepSchema, RobotTurn } from "../../gen/baudbot/v1/brain_link_pb";

/** A brain is asked after so long if nothing has come: the cable may have lost its command. */
const WAIT_S = 0.1;

/** What a brain is shown of a robot. */
export class BrainTurn {
  /** Which of the brain's robots this is. */
  readonly robot: string;
  /** The instant of the step, by the robot's clock, in seconds. */
  readonly time_s: number;
  /** The sensors' names. */
  readonly sensors: string[];

  constructor(
    private readonly turn: RobotTurn,
    description: RobotDescription,
    readonly tick: number,
  ) {
    this.robot = description.robot;
    this.time_s = Number(turn.atNs) / 1e9;
    this.sensors = description.sensors.map((sensor) => sensor.sensor);
  }

  /** A sensor's last reading, or its first number if it has several; `unread` as long as none has come. */
  value(sensor: string, unread?: number): number | undefined {
    return this.reading(sensor)?.values[0] ?? unread;
  }

  /** All numbers of a sensor's last reading, such as a laser's; none as long as none has come. */
  values(sensor: string): number[] {
    return this.reading(sensor)?.values ?? [];
  }

  /** Whether a sensor's reading has come since the last step. */
  isNew(sensor: string): boolean {
    return this.reading(sensor)?.readable ?? false;
  }

  private reading(sensor: string) {
    const place = this.sensors.indexOf(sensor);
    if (place < 0) throw new Error(`there is no sensor ${sensor}; there are: ${this.sensors.join(", ")}`);
    return this.turn.readings.find((reading) => reading.sensor === place);
  }
}

/** What a brain gives back: nothing, or signals for the motors. */
export interface Answer {
  /** Of the motors: 1 is full voltage, or full speed, forwards. */
  left: number;
  right: number;
  /** It is asked again when a reading has come, or after so long. */
  wait_s?: number;
}

/** The answer to a Turn, as the contract has it. */
export function stepOf(
  { robot, atNs }: RobotTurn,
  answer: Answer | null | undefined,
): MessageInitShape<typeof RobotStepSchema> & { untilMessage: { atLatestNs: bigint } } {
  const wait_s = number(answer?.wait_s ?? WAIT_S, "wait_s");
  const untilMessage = { atLatestNs: atNs + BigInt(Math.round(Math.max(0, wait_s) * 1e9)) };
  if (answer === null || answer === undefined) return { robot, untilMessage };
  const value = { leftSignal: number(answer.left, "left"), rightSignal: number(answer.right, "right") };
  return { robot, output: { case: "command" as const, value }, untilMessage };
}

function number(value: unknown, name: string): number {
  if (typeof value === "number" && Number.isFinite(value)) return value;
  throw new Error(`${name}: must be a finite number, is ${String(value)}; return { left: 0.4, right: 0.4 }`);
}
