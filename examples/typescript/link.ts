// The connection to the server. It knows nothing of the brain.
import { create, fromBinary, toBinary, type MessageInitShape } from "@bufbuild/protobuf";
import { Client, Metadata, credentials, status } from "@grpc/grpc-js";
import { setTimeout as sleep } from "node:timers/promises";
import * as pb from "./gen/baudbot/v1/brain_link_pb";
import { findAddress, findReconnectS, findRobots, findToken, findWorld } from "./settings";

/** A sensor's last reading, or `unread` if none has arrived yet. */
export type Value = (sensor: string, unread: number) => number;

/** What a robot's brain learns in a step, and the robot's data sheet. */
export interface RobotTurn {
  robot: number;
  atNs: bigint;
  isNews: boolean;
  value: Value;
  body: pb.RobotDescription | undefined;
}

export type Brain = (turn: RobotTurn) => MessageInitShape<typeof pb.RobotStepSchema>;

// No proxy between a robot and its brain, and pings, which notice a server that is gone without a word.
const channel = { "grpc.enable_http_proxy": 0, "grpc.keepalive_time_ms": 20_000, "grpc.keepalive_timeout_ms": 20_000 };

/** An error of gRPC's. */
type Lost = Error & { code?: status; details?: string; metadata?: Metadata };

/**
 * Drives the robots that the environment names until the run is over, and gives its last tick. Each connection gets a new
 * brain from `makeBrain`, since the world may have changed. The server shows the program's name.
 */
export async function drive(program: string, makeBrain: () => Brain): Promise<bigint> {
  const address = findAddress();
  const reconnectS = findReconnectS();
  let wasAttached = false;
  let lostAtMs: number | undefined;
  for (;;) {
    const token = findToken(address);
    try {
      return await attach(address, token, program, makeBrain(), () => {
        wasAttached = true;
        lostAtMs = undefined;
      });
    } catch (error) {
      const lost = error as Lost;
      const message = lost.details ?? lost.message;
      if (reconnectS <= 0 || !isLost(lost, wasAttached, token !== findToken(address))) throw new Error(message);
      if (lostAtMs === undefined) {
        lostAtMs = performance.now();
        console.error(`${program}: connection lost (${message}); trying again for ${reconnectS} s`);
      } else if (performance.now() - lostAtMs >= reconnectS * 1000) {
        throw new Error(message);
      }
      await sleep(500);
    }
  }
}

/** Whether another try may succeed. */
function isLost({ code, metadata }: Lost, wasAttached: boolean, isTokenNew: boolean): boolean {
  // A robot that has a brain may have this program's last connection, which the server takes to be alive.
  if (code === status.ALREADY_EXISTS) return wasAttached;
  // A server may write its token just after it has begun to listen.
  if (code === status.UNAUTHENTICATED) return isTokenNew;
  return code === status.UNAVAILABLE || (metadata?.get("baudbot-reason").includes("restart") ?? false);
}

/** Drives in one connection, which is new since gRPC would wait longer and longer before it tried again. */
function attach(
  address: string,
  token: string | undefined,
  program: string,
  brain: Brain,
  onAttached: () => void,
): Promise<bigint> {
  const metadata = new Metadata();
  if (token) metadata.set("authorization", `Bearer ${token}`);
  const server = new Client(address, credentials.createInsecure(), channel);
  return new Promise<bigint>((resolve, reject) => {
    const stream = server.makeBidiStreamRequest(
      "/baudbot.v1.BrainLinkService/Attach",
      (request: pb.AttachRequest) => Buffer.from(toBinary(pb.AttachRequestSchema, request)),
      (bytes) => fromBinary(pb.AttachResponseSchema, bytes),
      metadata,
    );
    const send = (request: MessageInitShape<typeof pb.AttachRequestSchema>["request"]) =>
      stream.write(create(pb.AttachRequestSchema, { request }));
    let bodies: pb.RobotDescription[] = [];
    const [world, robots, mode] = [findWorld(), findRobots(), pb.PortMode.MESSAGES];
    send({ case: "hello", value: { world, robots, mode, brain: program, thinksAsScenario: true } });
    stream.on("data", ({ response }: pb.AttachResponse) => {
      if (response.case === "welcome") {
        bodies = response.value.robots;
        onAttached();
      } else if (response.case === "turn") {
        const { turn, robots } = response.value;
        send({ case: "step", value: { turn, robots: robots.map((robot) => brain(turnOf(robot, bodies[robot.robot]))) } });
      } else if (response.case === "ended") {
        stream.end();
        resolve(response.value.tick);
      }
    });
    stream.on("error", reject);
    const details = "the server closed the connection before the run was over";
    stream.on("end", () => reject(Object.assign(new Error(details), { code: status.UNAVAILABLE, details })));
  }).finally(() => server.close());
}

/** The server asks in ticks without news, too. */
function turnOf({ robot, atNs, readings, hasMessage }: pb.RobotTurn, body: pb.RobotDescription | undefined): RobotTurn {
  const isNews = hasMessage || readings.some(({ readable }) => readable);
  const value: Value = (name, unread) =>
    readings.find((reading) => body?.sensors[reading.sensor]?.sensor === name)?.values[0] ?? unread;
  return { robot, atNs, isNews, value, body };
}
