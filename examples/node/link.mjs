// The connection to the server. It knows nothing of the brain.
import { basename, extname } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { Metadata, credentials, loadPackageDefinition, status } from "@grpc/grpc-js";
import { loadSync } from "@grpc/proto-loader";
import { findAddress, findReconnectS, findToken, helloOf } from "./settings.mjs";

const includeDirs = ["./proto", "../../proto"].map((folder) => fileURLToPath(new URL(folder, import.meta.url)));
// Numbers of 64 bits are texts, as JavaScript's own numbers are exact only up to 2^53.
const definition = loadSync("baudbot/v1/brain_link.proto", { includeDirs, longs: String, defaults: true });
const { BrainLinkService } = loadPackageDefinition(definition).baudbot.v1;

// No proxy between a robot and its brain, and pings, which notice a server that is gone without a word.
const CHANNEL = { "grpc.enable_http_proxy": 0, "grpc.keepalive_time_ms": 20_000, "grpc.keepalive_timeout_ms": 20_000 };

/**
 * Drives the robots that the environment names until the run is over, and gives its last tick. Each connection gets a new
 * brain from `makeBrain`, since the world may have changed. The server shows the program's name.
 */
export async function drive(program, makeBrain) {
  const address = findAddress();
  const reconnectS = findReconnectS();
  let wasAttached = false;
  let lostAtMs;
  for (;;) {
    const token = findToken(address);
    try {
      return await attach(address, token, program, makeBrain(), () => {
        wasAttached = true;
        lostAtMs = undefined;
      });
    } catch (error) {
      const message = error.details ?? error.message;
      if (reconnectS <= 0 || !isLost(error, wasAttached, token !== findToken(address))) throw new Error(message);
      if (lostAtMs === undefined) {
        lostAtMs = performance.now();
        const name = basename(program, extname(program));
        console.error(`${name}: connection lost (${message}); trying again for ${reconnectS} s`);
      } else if (performance.now() - lostAtMs >= reconnectS * 1000) {
        throw new Error(message);
      }
      await sleep(500);
    }
  }
}

/** Whether another try may succeed. */
function isLost({ code, metadata }, wasAttached, isTokenNew) {
  // A robot that has a brain may have this program's last connection, which the server takes to be alive.
  if (code === status.ALREADY_EXISTS) return wasAttached;
  // A server may write its token just after it has begun to listen.
  if (code === status.UNAUTHENTICATED) return isTokenNew;
  return code === status.UNAVAILABLE || metadata?.get("baudbot-reason").includes("restart");
}

/** Drives in one connection, which is new since gRPC would wait longer and longer before it tried again. */
function attach(address, token, program, brain, onAttached) {
  const metadata = new Metadata();
  if (token) metadata.set("authorization", `Bearer ${token}`);
  const server = new BrainLinkService(address, credentials.createInsecure(), CHANNEL);
  return new Promise((resolve, reject) => {
    const stream = server.attach(metadata);
    let bodies;
    stream.write({ hello: helloOf(program) });
    stream.on("data", ({ welcome, turn, ended }) => {
      if (welcome) {
        bodies = welcome.robots;
        onAttached();
      } else if (turn) {
        const robots = turn.robots.map((robot) => brain(turnOf(robot, bodies[robot.robot])));
        stream.write({ step: { turn: turn.turn, robots } });
      } else if (ended) {
        stream.end();
        resolve(ended.tick);
      }
    });
    stream.on("error", reject);
    const details = "the server closed the connection before the run was over";
    stream.on("end", () => reject({ code: status.UNAVAILABLE, details }));
  }).finally(() => server.close());
}

/** What a robot's brain learns in a step, and the robot's data sheet. */
function turnOf({ robot, atNs, readings, hasMessage }, body) {
  const isNews = hasMessage || readings.some(({ readable }) => readable); // the server asks in ticks without news, too
  const value = (name, unread) =>
    readings.find(({ sensor }) => body.sensors[sensor].sensor === name)?.values[0] ?? unread;
  return { robot, atNs: BigInt(atNs), readings, isNews, value, body };
}
