/** The worker of a brain that was typed into the page: it attaches to robots as any other brain, and drives until it is ended. */
import { create, fromBinary } from "@bufbuild/protobuf";
import { AttachResponseSchema, BrainLinkService, HelloSchema, PortMode } from "../../gen/baudbot/v1/brain_link_pb";
import { Connection } from "../../net/connection";
import type { FromBrain, ToBrain } from "../messages";
import { PortSocket } from "../port_socket";
import { makerOfJavascript, type Make } from "./javascript";
import { makerOfPython } from "./python";
import { Driver } from "./driver";

onmessage = ({ data }: MessageEvent<ToBrain>) => {
  void begin(data).catch((error: unknown) => over(error));
};

/** Reads the text first: a brain that cannot step takes no robot. */
async function begin(task: ToBrain): Promise<void> {
  const make = await read(task);
  const { world, robots, name: brain } = task;
  const connection = new Connection(() => new PortSocket(task.port));
  await new Promise<void>((resolve) => {
    connection.changed = () => connection.link.state === "open" && resolve();
    connection.open();
  });
  const hello = create(HelloSchema, { world, robots, mode: PortMode.MESSAGES, brain, thinksAsScenario: true });
  const driver = new Driver(make);
  const call = connection.begin(
    BrainLinkService.method.attach,
    { request: { case: "hello", value: hello } },
    {
      message(bytes) {
        try {
          const { response } = fromBinary(AttachResponseSchema, bytes);
          const answer = driver.hear(response);
          if (response.case === "welcome") tell({ kind: "drives" });
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

function read({ language, code, pyodide }: ToBrain): Make | Promise<Make> {
  if (language === "javascript") return makerOfJavascript(code);
  tell({ kind: "loading", what: "Python" });
  return makerOfPython(code, pyodide, (text) => tell({ kind: "said", text }));
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
