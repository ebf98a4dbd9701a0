// A real server for tests. BAUDBOT names the program.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { setTimeout as sleep } from "node:timers/promises";

/** Serves the scenario wander until the test `t` is over, and gives the address. */
export async function startServer(t, ...options) {
  const folder = mkdtempSync("/tmp/baudbot-test-");
  const portFile = `${folder}/port`;
  const place = ["--listen", "127.0.0.1:0", "--port-file", portFile, "--viewer", "off"];
  const server = spawn(process.env.BAUDBOT || "baudbot", ["serve", "wander", ...place, ...options]);
  t.after(() => {
    server.kill("SIGKILL");
    rmSync(folder, { recursive: true });
  });
  let text = "";
  for (const output of [server.stdout, server.stderr]) output.on("data", (data) => (text += data));
  server.on("error", (error) => (text += `${error.message}; BAUDBOT names the program`));
  for (const begin = performance.now(); performance.now() - begin < 30_000 && server.exitCode === null; await sleep(20)) {
    if (existsSync(portFile)) return readFileSync(portFile, "utf8").trim();
  }
  throw new Error(`the server ended, or was not ready after 30 s; it says:\n${text}`);
}
