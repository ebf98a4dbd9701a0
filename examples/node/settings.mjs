// What the environment says.
import { existsSync, readFileSync } from "node:fs";

/** A variable of the environment; an empty one counts as unset. */
function env(name, unset) {
  return process.env[name] || unset;
}

/** HOST:PORT or unix:/PATH of the server. */
export function findAddress() {
  const address = env("BAUDBOT_CONNECT", "127.0.0.1:7400");
  if (address.startsWith("https://")) {
    throw new Error(`BAUDBOT_CONNECT=${address}: this example has no TLS; give HOST:PORT or unix:/PATH of a server without TLS`);
  }
  return address.replace(/^http:\/\//, "").replace(/\/$/, "");
}

/** For how long to try again after a lost connection. */
export function findReconnectS() {
  const text = env("BAUDBOT_RECONNECT_S", "600");
  const seconds = Number(text);
  if (Number.isNaN(seconds)) throw new Error(`BAUDBOT_RECONNECT_S must be a number of seconds, is ${text}`);
  return seconds;
}

export function helloOf(program) {
  return {
    world: env("BAUDBOT_WORLD", "wander"),
    robots: env("BAUDBOT_ROBOT", "robot").split(","),
    mode: "PORT_MODE_MESSAGES",
    brain: program,
    thinksAsScenario: true,
  };
}

/** The token of the environment, else that of the user's own server, else undefined. */
export function findToken(address) {
  const file = env("BAUDBOT_TOKEN_FILE") ?? ownTokenFile(address);
  return (env("BAUDBOT_TOKEN") ?? (file && readFileSync(file, "utf8")))?.trim();
}

/**
 * The file with the token of the user's own server on this machine (docs/reference/trust.md of baudbot). A server that was
 * started again has a new one.
 */
function ownTokenFile(address) {
  const { XDG_RUNTIME_DIR = "", HOME = "" } = process.env;
  const folders = [`${XDG_RUNTIME_DIR}/baudbot`, `/tmp/baudbot-${process.getuid()}`, `${HOME}/.baudbot`];
  const files = folders.map((folder) => `${folder}/${address.replace("localhost:", "127.0.0.1:")}.token`);
  return files.find((file) => existsSync(file));
}
