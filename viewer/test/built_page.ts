/** The page that needs no installation, as `build-page` made it, for browsers: PAGE is where it was built (target/page). */
import axe from "axe-core";
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { extname, join } from "node:path";

const ROOT = new URL("../../", import.meta.url).pathname;
export const BUILT = process.env.PAGE ?? join(ROOT, "target/page");
/** The page in one file, from a disk. */
export const SINGLE = `file://${BUILT}/baudbot.html`;
/** The main job's, as README.md says it. */
export const HASH = /^state hash +([0-9a-f]{16})$/m.exec(readFileSync(join(ROOT, "README.md"), "utf8"))![1]!;
const TYPES: Record<string, string> = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".mjs": "text/javascript",
  ".css": "text/css",
  ".wasm": "application/wasm",
};

export const hashOf = (result: string) => /state hash ([0-9a-f]{16})/.exec(result)?.[1];
export const tookOf = (result: string) => Number(/simulated in ([0-9.]+) s/.exec(result)?.[1]);

/** Serves the page's files, as any web server does. */
export async function site(): Promise<{ address: string; stop: () => void }> {
  const server = createServer((request, response) => void answer(request.url ?? "/", response));
  server.listen(0, "127.0.0.1");
  await new Promise((resolve) => server.once("listening", resolve));
  const address = `http://127.0.0.1:${(server.address() as AddressInfo).port}/`;
  return { address, stop: () => void server.close() };
}

async function answer(url: string, response: import("node:http").ServerResponse): Promise<void> {
  const path = new URL(url, "http://site").pathname.replace(/\/$/, "/index.html");
  try {
    const bytes = await readFile(join(BUILT, "site", path));
    response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream" }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
}

/** Fails if axe finds something serious or critical in a page, or if the page is wider than its window. */
export async function isAccessible(evaluate: (script: string) => Promise<unknown>, what: string): Promise<void> {
  await evaluate(axe.source);
  const found = await evaluate(`axe.run().then(({ violations }) => violations
    .filter(({ impact }) => impact === "serious" || impact === "critical")
    .map(({ id, nodes }) => id + ": " + nodes.map(({ html, failureSummary }) => html + " " + failureSummary).join("\\n")))`);
  assert.deepEqual(found, [], what);
  const wide = (await evaluate("document.documentElement.scrollWidth - innerWidth")) as number;
  assert.ok(wide <= 0, `${what}: ${wide} pixels are beyond the edge`);
}
