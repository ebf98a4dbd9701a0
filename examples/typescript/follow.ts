// A brain in TypeScript that follows the wall on its right. It attaches where BAUDBOT_CONNECT, BAUDBOT_WORLD and BAUDBOT_ROBOT say,
// which `baudbot run --brain 'exec:npx tsx follow.ts'` sets, and drives until the run is over.
import { create, fromBinary, toBinary, type MessageInitShape } from "@bufbuild/protobuf";
import { existsSync, readFileSync } from "node:fs";
import { Client, Metadata, credentials } from "@grpc/grpc-js";
import * as pb from "./gen/baudbot/v1/brain_link_pb";

const { BAUDBOT_CONNECT = "127.0.0.1:7400", BAUDBOT_WORLD = "wander", BAUDBOT_ROBOT = "robot" } = process.env;

// `wanted` is the nearness of the wall that it keeps: 0 is out of range, 1 is very near.
const { speed, gain, wanted } = withParameters({ speed: 0.4, gain: 1.0, wanted: 0.3 });

/** These numbers, or the ones in BAUDBOT_PARAMETERS, which a sweep sets. */
function withParameters<T extends Record<string, number>>(defaults: T): T {
  const given = JSON.parse(process.env.BAUDBOT_PARAMETERS || "{}") as Record<string, unknown>;
  for (const [name, value] of Object.entries(given)) {
    if (!(name in defaults) || typeof value !== "number") {
      console.error(`follow.ts: there is no number ${name}; there are: ${Object.keys(defaults).join(", ")}`);
      process.exit(1);
    }
  }
  return { ...defaults, ...given };
}

/** The token of the user's own server on this machine (docs/reference/trust.md). */
function ownToken(): string | undefined {
  const { XDG_RUNTIME_DIR, HOME } = process.env;
  const folders = [`${XDG_RUNTIME_DIR}/baudbot`, `/tmp/baudbot-${process.getuid?.()}`, `${HOME}/.baudbot`];
  const files = folders.map((folder) => `${folder}/${BAUDBOT_CONNECT.replace("localhost:", "127.0.0.1:")}.token`);
  return tokenOf(files.find((file) => existsSync(file)));
}

function tokenOf(file: string | undefined): string | undefined {
  return file ? readFileSync(file, "utf8").trim() : undefined;
}

/** What the brain does in a step. `value` gives a sensor's last reading, or `unread` if none has arrived yet. */
function step(value: (sensor: string, unread: number) => number): MessageInitShape<typeof pb.CommandSchema> {
  const ahead = Math.max(value("ir_front", 1), value("ir_front_left", 1));
  if (ahead > wanted) {
    return { leftSignal: -0.5 * speed, rightSignal: 0.5 * speed }; // a corner: to the left, on the spot
  }
  const right = Math.max(value("ir_right", 0), value("ir_front_right", 0));
  const turning = gain * speed * (right - wanted); // too near: to the left
  return { leftSignal: speed - turning, rightSignal: speed + turning };
}

const server = new Client(BAUDBOT_CONNECT, credentials.createInsecure());
const metadata = new Metadata();
const token = process.env.BAUDBOT_TOKEN ?? tokenOf(process.env.BAUDBOT_TOKEN_FILE) ?? ownToken();
if (token) metadata.set("authorization", `Bearer ${token}`);
const stream = server.makeBidiStreamRequest(
  "/baudbot.v1.BrainLinkService/Attach",
  (request: pb.AttachRequest) => Buffer.from(toBinary(pb.AttachRequestSchema, request)),
  (bytes) => fromBinary(pb.AttachResponseSchema, bytes),
  metadata,
);
const send = (request: MessageInitShape<typeof pb.AttachRequestSchema>["request"]) =>
  stream.write(create(pb.AttachRequestSchema, { request }));
let bodies: pb.RobotDescription[] = [];
process.exitCode = 1; // until the run is over

send({
  case: "hello",
  value: {
    world: BAUDBOT_WORLD,
    robots: BAUDBOT_ROBOT.split(","),
    mode: pb.PortMode.MESSAGES,
    brain: "follow.ts",
    thinksAsScenario: true,
  },
});
stream.on("data", ({ response }: pb.AttachResponse) => {
  if (response.case === "welcome") {
    bodies = response.value.robots;
  } else if (response.case === "turn") {
    const { turn, robots } = response.value;
    send({ case: "step", value: { turn, robots: robots.map(answer) } });
  } else if (response.case === "ended") {
    console.log(`the run is over at tick ${response.value.tick}`);
    process.exitCode = 0;
    stream.end();
  }
});
stream.on("end", () => server.close());
stream.on("error", (error: Error) => {
  console.error(`follow.ts: ${error.message}`);
  process.exit(1);
});

/** When each robot gets a command though no message has come, by its place: the cable may have lost the last one. */
const repeatNs: bigint[] = [];

/** One command for each message, and another after 0.1 s without any: the server asks in ticks without news, too. */
function answer({ robot, atNs, readings, hasMessage }: pb.RobotTurn): MessageInitShape<typeof pb.RobotStepSchema> {
  const isNews = hasMessage || readings.some(({ readable }) => readable);
  if (!isNews && atNs < (repeatNs[robot] ?? 0n)) {
    return { robot, untilMessage: { atLatestNs: repeatNs[robot] } };
  }
  const atLatestNs = (repeatNs[robot] = atNs + 100_000_000n);
  const sensors = bodies[robot]?.sensors ?? [];
  const value = (name: string, unread: number) =>
    readings.find((reading) => sensors[reading.sensor]?.sensor === name)?.values[0] ?? unread;
  return { robot, output: { case: "command", value: step(value) }, untilMessage: { atLatestNs } };
}
