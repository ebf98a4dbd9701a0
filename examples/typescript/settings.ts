// What the environment says.
import { existsSync, readFileSync } from "node:fs";

/** A variable of the environment; an empty one counts as unset. */
const env = (name: string): string | undefined => process.env[name] || undefined;

/** HOST:PORT or unix:/PATH of the server. */
export function findAddress(): string {
  const address = env("BAUDBOT_CONNECT") ?? "127.0.0.1:7400";
  if (address.startsWith("https://")) {
    throw new Error(`BAUDBOT_CONNECT=${address}: this example has no TLS; give HOST:PORT or unix:/PATH of a server without TLS`);
  }
  return address.replace(/^http:\/\//, "").replace(/\/$/, "");
}

export const findWorld = (): string => env("BAUDBOT_WORLD") ?? "wander";

export const findRobots = (): string[] => (env("BAUDBOT_ROBOT") ?? "robot").split(",");

/** For how long to try again after a lost connection. */
export function findReconnectS(): number {
  const text = env("BAUDBOT_RECONNECT_S") ?? "600";
  const seconds = Number(text);
  if (Number.isNaN(seconds)) throw new Error(`BAUDBOT_RECONNECT_S must be a number of seconds, is ${text}`);
  return seconds;
}

/** The token of the environment, else that of the user's own server, else undefined. */
export function findToken(address: string): string | undefined {
  const file = env("BAUDBOT_TOKEN_FILE") ?? ownTokenFile(address);
  return (env("BAUDBOT_TOKEN") ?? (file && readFileSync(file, "utf8")))?.trim();
}

/**
 * The file with the token of the user's own server on this machine (docs/reference/trust.md of baudbot). A server that was
 * started again has a new one.
 */
function ownTokenFile(address: string): string | undefined {
  const { XDG_RUNTIME_DIR = "", HOME = "" } = process.env;
  const folders = [`${XDG_RUNTIME_DIR}/baudbot`, `/tmp/baudbot-${process.getuid?.()}`, `${HOME}/.baudbot`];
  const files = folders.map((folder) => `${folder}/${address.replace("localhost:", "127.0.0.1:")}.token`);
  return files.find((file) => existsSync(file));
}

/** These numbers, or the ones in BAUDBOT_PARAMETERS, which a sweep sets. */
export function withParameters<T extends Record<string, number>>(defaults: T): T {
  const given = JSON.parse(env("BAUDBOT_PARAMETERS") ?? "{}") as Record<string, unknown>;
  for (const [name, value] of Object.entries(given)) {
    if (!(name in defaults) || typeof value !== "number") {
      console.error(`follow.ts: there is no number ${name}; there are: ${Object.keys(defaults).join(", ")}`);
      process.exit(1);
    }
  }
  return { ...defaults, ...given };
}
