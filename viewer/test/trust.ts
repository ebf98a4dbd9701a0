/**
 * The page over TLS, before a server that asks for tokens, in browsers that know its authority and in ones that do not:
 * `npm run test:server`. Needs what `server.ts` needs, and openssl and certutil.
 */
import assert from "node:assert/strict";
import { execFileSync, spawn, type ChildProcess } from "node:child_process";
import { once } from "node:events";
import { mkdir, mkdtemp, rm, writeFile } from "node:fs/promises";
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { chromium, type Browser, type Page } from "playwright-core";

const PROGRAM = process.env.BAUDBOT ?? new URL("../../target/release/baudbot", import.meta.url).pathname;
const BROWSER = process.env.CHROMIUM ?? "/usr/bin/chromium";

let folder: string;
let server: ChildProcess;
/** With the server's own token. */
let link: string;
let page: string;
let stranger: Server;
let tokens: { observer: string; alice: string };

/** A browser whose user knows the authority, or does not. */
let knowing: Browser;
let unknowing: Browser;

const at = (name: string) => join(folder, name);
const openssl = (...args: string[]) => execFileSync("openssl", args, { stdio: ["ignore", "ignore", "pipe"] });

/** An authority, and a certificate of a server by it. */
async function certificates() {
  const key = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"];
  const authority = [
    "-x509",
    "-days",
    "2",
    "-subj",
    "/CN=laboratory",
    "-keyout",
    at("ca-key.pem"),
    "-out",
    at("ca.pem"),
  ];
  openssl("req", ...key, ...authority, "-addext", "basicConstraints=critical,CA:TRUE");
  openssl("req", ...key, "-subj", "/CN=robots", "-keyout", at("key.pem"), "-out", at("request.pem"));
  await writeFile(at("names"), "subjectAltName=DNS:localhost,IP:127.0.0.1\n");
  const signed = ["-CA", at("ca.pem"), "-CAkey", at("ca-key.pem"), "-days", "2", "-extfile", at("names")];
  openssl("x509", "-req", "-in", at("request.pem"), ...signed, "-out", at("cert.pem"));
  execFileSync("chmod", ["600", at("key.pem")]);
}

const token = (name: string, ...rights: string[]) =>
  execFileSync(PROGRAM, ["token", "new", "--file", at("tokens.toml"), "--name", name, ...rights], {
    stdio: ["ignore", "pipe", "ignore"],
    encoding: "utf8",
  }).trim();

/** A browser of a user with such a home. */
async function browserAt(home: string, authority?: string): Promise<Browser> {
  const database = join(home, ".pki/nssdb");
  await mkdir(database, { recursive: true });
  execFileSync("certutil", ["-d", `sql:${database}`, "-N", "--empty-password"]);
  if (authority)
    execFileSync("certutil", ["-d", `sql:${database}`, "-A", "-t", "C,,", "-n", "laboratory", "-i", authority]);
  return chromium.launch({ executablePath: BROWSER, args: ["--no-sandbox"], env: { ...process.env, HOME: home } });
}

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "baudbot-trust-"));
  await certificates();
  // A server looks at the file once a second at most.
  tokens = { observer: token("observer", "--observe"), alice: token("alice", "--drive", "wander/robot") };
  const guards = ["--tokens", at("tokens.toml"), "--tls", `${at("cert.pem")},${at("key.pem")}`];
  const free = ["--listen", "127.0.0.1:0", "--viewer", "127.0.0.1:0"];
  server = spawn(PROGRAM, ["serve", "wander", ...guards, ...free], { stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: server.stdout! })) {
    link = /^open in a browser: (\S+)/.exec(line)?.[1] ?? "";
    if (link) break;
  }
  page = new URL("/", link).href;
  assert.match(page, /^https:/);
  knowing = await browserAt(at("knowing"), at("ca.pem"));
  unknowing = await browserAt(at("unknowing"));
  stranger = createServer((_, response) =>
    response.setHeader("content-type", "text/html").end("<title>stranger</title>"),
  );
  await once(stranger.listen(0, "127.0.0.1"), "listening");
});

after(async () => {
  await knowing?.close();
  await unknowing?.close();
  stranger?.close();
  if (server?.exitCode === null) {
    server.kill("SIGINT");
    await once(server, "exit");
  }
  if (folder) await rm(folder, { recursive: true });
});

async function visit(browser: Browser, address: string): Promise<Page> {
  const page = await (await browser.newContext()).newPage();
  await page.goto(address);
  return page;
}

const moves = (page: Page) => page.waitForFunction(() => window.baudbotViewer?.frames > 5);

test("who knows the authority and has the link sees the robot", { timeout: 60_000 }, async () => {
  const page = await visit(knowing, link);
  await moves(page);
  assert.equal(new URL(page.url()).hash.includes("token"), false, "the token does not stay in the address");
  assert.equal(await page.evaluate(() => document.cookie), "", "no script can read the session");
  await page.context().close();
});

test("who does not know the authority is warned by the browser", { timeout: 60_000 }, async () => {
  await assert.rejects(visit(unknowing, link), /ERR_CERT_AUTHORITY_INVALID/);
});

test("a wrong token gets words, and a right one lets in", { timeout: 60_000 }, async () => {
  const visitor = await visit(knowing, page);
  const enter = async (token: string) => {
    await visitor.getByTestId("token").fill(token);
    await visitor.getByTestId("token").press("Enter");
  };
  await visitor.getByTestId("token-dialog").waitFor();
  await enter(`baudbot_${"A".repeat(43)}`);
  await visitor.getByText("the token is not valid on this server").waitFor();
  await enter(tokens.observer);
  await visitor.getByTestId("token-dialog").waitFor({ state: "hidden" });
  await moves(visitor);
  await visitor.getByTestId("pause").click();
  await visitor.getByText("the token `observer` has no right to").first().waitFor();
  await visitor.context().close();
});

test("a driver sees nothing of the world, and is told so", { timeout: 60_000 }, async () => {
  const visitor = await visit(knowing, `${page}#token=${tokens.alice}`);
  await visitor
    .getByTestId("no-worlds")
    .getByText("the token `alice` has no right to this, which needs `observe`")
    .waitFor();
  assert.equal(await visitor.evaluate(() => window.baudbotViewer?.pose), undefined);
  await visitor.context().close();
});

test("a page of another origin gets nothing, also in a browser with a session", { timeout: 60_000 }, async () => {
  const visitor = await visit(knowing, link);
  await moves(visitor);
  const { port } = stranger.address() as AddressInfo;
  await visitor.goto(`http://127.0.0.1:${port}/`);
  const got = await visitor.evaluate(async (page) => {
    const socket = new WebSocket(`${page.replace("https", "wss")}page`);
    const opened = await new Promise((told) => {
      socket.onopen = () => told("open");
      socket.onclose = () => told("refused");
    });
    const answers = ["metrics", "session"].map((path) =>
      fetch(page + path, { credentials: "include" }).then(
        (response) => response.text(),
        () => "unreadable",
      ),
    );
    return [opened, ...(await Promise.all(answers))];
  }, page);
  assert.deepEqual(got, ["refused", "unreadable", "unreadable"]);
  await visitor.context().close();
});
