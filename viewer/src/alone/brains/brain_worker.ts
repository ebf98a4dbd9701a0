/** The worker of a brain that was typed into the page: it attaches to robots as any other brain, and drives until it is ended. */
import { create, fromBinary } from "@bufbuild/protobuf";
import {
  AttachResponseSchema,
  BrainLinkService,
  HelloSchema,
  PortMode,
  StepSchema,
  type AttachResponse,
  type RobotDescription,
  type Turn,
} from "../../gen/baudbot/v1/brain_link_pb";
import { Connection } from "../../net/connection";
import type { FromBrain, ToBrain } from "../messages";
import { PortSocket } from "../port_socket";
import { stepOfJavascript, type Step } from "./javascript";
import { stepOfPython } from "./python";
import { BrainTurn, stepOf } from "./turn";

onmessage = ({ data }: MessageEvent<ToBrain>) => {
  void begin(data).catch((error: unknown) => over(error));
};

/** Reads the text first: a brain that cannot step takes no robot. */
async function begin(task: ToBrain): Promise<void> {
  const step = await read(task);
  const { world, robots, name: brain } = task;
  const connection = new Connection(() => new PortSocket(task.port));
  await new Promise<void>((resolve) => {
    connection.changed = () => connection.link.state === "open" && resolve();
    connection.open();
  });
  const hello = create(HelloSchema, { world, robots, mode: PortMode.MESSAGES, brain, thinksAsScenario: true });
  const driver = new Driver(step);
  const call = connection.begin(
    BrainLinkService.method.attach,
    { request: { case: "hello", value: hello } },
    {
      message(bytes) {
        try {
          const answer = driver.hear(fromBinary(AttachResponseSchema, bytes).response);
          if (answer) connection.next(call, BrainLinkService.method.attach, { request: answer });
        } catch (error) {
          connection.end(call);
          over(error);
        }
      },
      over: (error) => over(error),
    },
  );
}

function read({ language, code, pyodide }: ToBrain): Step | Promise<Step> {
  if (language === "javascript") return stepOfJavascript(code);
  tell({ kind: "loading", what: "Python" });
  return stepOfPython(code, pyodide, (text) => tell({ kind: "said", text }));
}

/** The brains of a stream's robots. */
class Driver {
  private robots: RobotDescription[] = [];
  private memories: Record<string, unknown>[] = [];

  constructor(private readonly step: Step) {}

  /** The request that answers, if there is one. */
  hear(response: AttachResponse["response"]) {
    if (response.case === "welcome") {
      this.robots = response.value.robots;
      this.forget();
      tell({ kind: "drives" });
    } else if (response.case === "ended") {
      this.forget();
    } else if (response.case === "turn") {
      return { case: "step" as const, value: this.answer(response.value) };
    }
    return undefined;
  }

  private answer({ turn, tick, robots }: Turn) {
    const answers = robots.map((part) => {
      const shown = new BrainTurn(part, this.robots[part.robot]!, Number(tick));
      return stepOf(part, this.step(shown, this.memories[part.robot]!));
    });
    return create(StepSchema, { turn, robots: answers });
  }

  /** A run begins without what was kept from another one. */
  private forget(): void {
    this.memories = this.robots.map(() => ({}));
  }
}

function over(error?: unknown): void {
  tell({
    kind: "over",
    error: error instanceof Error ? `${error.name}: ${error.message}` : error === undefined ? undefined : String(error),
  });
}

function tell(what: FromBrain): void {
  postMessage(what);
}
