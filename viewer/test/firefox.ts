/**
 * The pages in Firefox: the one that needs no installation, and that of a server. `build-page`, then `npm run test:firefox`. Needs the
 * program, in BAUDBOT or where `cargo build --release` puts it, and a Firefox, in FIREFOX or where Debian has it.
 */
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtemp, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import puppeteer, { type Browser, type Page } from "puppeteer-core";
import { HASH, SINGLE, hashOf, isAccessible, site } from "./built_page";

const PROGRAM = process.env.BAUDBOT ?? new URL("../../target/release/baudbot", import.meta.url).pathname;
const BROWSER = process.env.FIREFOX ?? "/usr/bin/firefox-esr";
const options = { timeout: 300_000 };

let folder: string;
let web: { address: string; stop: () => void };
let light: Browser;
let dark: Browser;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "baudbot-firefox-"));
  web = await site();
  [light, dark] = [await launch(1), await launch(0)];
  console.log(await light.version());
});

after(async () => {
  await light?.close();
  await dark?.close();
  web?.stop();
  if (folder) await rm(folder, { recursive: true });
});

/** A browser whose user likes it dark (0) or light (1). */
function launch(scheme: 0 | 1): Promise<Browser> {
  const extraPrefsFirefox = {
    "layout.css.prefers-color-scheme.content-override": scheme,
    "browser.download.dir": folder,
    "browser.download.folderList": 2,
  };
  return puppeteer.launch({ browser: "firefox", executablePath: BROWSER, extraPrefsFirefox });
}

/** A page that fails the test if anything is thrown in it. */
async function visit(where: string, { browser = light, width = 1280, height = 900 } = {}): Promise<Page> {
  const page = await browser.newPage();
  await page.setViewport({ width, height });
  page.on("pageerror", (error) => assert.fail(error as Error));
  await page.goto(where);
  return page;
}

/** The page without a world. */
async function open(where: string, look = {}): Promise<Page> {
  const page = await visit(`${where}#empty`, look);
  await page.waitForFunction(() => document.querySelector<HTMLTextAreaElement>("[data-testid=scenario-text]")?.value);
  return page;
}

const id = (name: string) => `[data-testid=${name}]`;
const text = (page: Page, name: string) => page.$eval(id(name), (part) => part.textContent ?? "");

/** Runs the main job with this brain, as fast as possible. Gives what the page says of it. */
async function run(page: Page, brain: string): Promise<string> {
  await page.click(id("open-start"));
  await page.select(id("brain"), brain);
  await page.select(id("pace-choice"), "lockstep");
  await page.click(id("start-run"));
  await page.waitForFunction(
    () =>
      document.querySelector("[data-testid=result]")?.textContent?.includes("hash") ||
      document.querySelector("[data-testid=start-error]")?.textContent,
    { timeout: 120_000 },
  );
  assert.equal(await text(page, "start-error"), "");
  return text(page, "result");
}

test("the main job has README's hash in a file from a disk", options, async () => {
  const page = await open(SINGLE);
  assert.equal(hashOf(await run(page, ":avoid")), HASH);
  await page.close();
});

test("the same from a web server, and the program replays its recording to the same hash", options, async () => {
  const page = await open(web.address);
  await page.$eval(id("records"), (box) => ((box as HTMLInputElement).checked = true));
  assert.equal(hashOf(await run(page, ":avoid")), HASH);
  await page.click(id("save-recording"));
  let files: string[] = [];
  while (files.length !== 1 || !files[0]!.endsWith(".mcap")) {
    await sleep(100);
    files = await readdir(folder);
  }
  const said = execFileSync(PROGRAM, ["replay", join(folder, files[0]!), "--json"], { encoding: "utf8" });
  assert.ok(said.includes(HASH), said);
  await page.close();
});

test("a brain in JavaScript drives as the same one in Python", options, async () => {
  const page = await open(web.address);
  const javascript = hashOf(await run(page, "javascript"));
  assert.match(javascript ?? "", /^[0-9a-f]{16}$/);
  await page.keyboard.press("Escape");
  assert.equal(hashOf(await run(page, "python")), javascript);
  await page.close();
});

test("each scenario that is built in becomes a world", options, async () => {
  const page = await open(SINGLE);
  const names = await page.$$eval(`${id("scenario-choice")} option`, (all) => all.map((option) => option.textContent!));
  assert.ok(names.length > 40, `${names.length}`);
  await page.evaluate(() => (window.confirm = () => true));
  for (const name of names) {
    await page.click(id("open-start"));
    await page.select(id("brain"), "none");
    const before = await page.$eval(id("scenario-text"), (area) => (area as HTMLTextAreaElement).value);
    await page.select(id("scenario-choice"), name);
    if (name !== "wander") {
      const isOther = (before: string) =>
        document.querySelector<HTMLTextAreaElement>("[data-testid=scenario-text]")!.value !== before;
      await page.waitForFunction(isOther, {}, before);
    }
    await page.select(id("pace-choice"), "realTime");
    await page.click(id("start-run"));
    await page.waitForSelector(id("start"), { hidden: true });
    await page.waitForFunction(() => window.baudbotViewer.frames > 0);
    await page.click(".world-list li.chosen button.quiet");
    await page.waitForSelector(id("no-worlds"), { visible: true });
  }
  await page.close();
});

test("a budget is computed, and a run goes without a mouse", options, async () => {
  const page = await open(SINGLE);
  const press = async (selector: string) => {
    await page.focus(selector);
    await page.keyboard.press("Enter");
  };
  await press(id("open-start"));
  await press(`summary ::-p-text(Budget)`);
  await press(id("budget-compute"));
  await page.waitForSelector(`${id("budget")} table`);
  assert.match(await text(page, "budget"), /whole cycle/);
  await press(id("start-run"));
  await page.waitForSelector(id("start"), { hidden: true });
  await page.waitForFunction(() => window.baudbotViewer.frames > 5);
  await page.close();
});

for (const [name, width, height] of [
  ["small", 320, 640],
  ["large", 1280, 900],
  ["4K", 3840, 2160],
] as const) {
  for (const scheme of ["light", "dark"] as const) {
    test(`axe finds nothing serious, and nothing is beyond the edge: ${name}, ${scheme}`, options, async () => {
      const page = await visit(SINGLE, { browser: scheme === "dark" ? dark : light, width, height });
      await page.waitForFunction(() => window.baudbotViewer?.frames > 5);
      assert.equal(await page.evaluate(() => matchMedia("(prefers-color-scheme: dark)").matches), scheme === "dark");
      await isAccessible((script) => page.evaluate(script), "the page");
      await page.close();
    });
  }
}

test("the page of a server shows its worlds, and a person drives a robot", options, async () => {
  const free = ["--listen", "127.0.0.1:0", "--viewer", "127.0.0.1:0"];
  const server = spawn(PROGRAM, ["serve", "wander", ...free], { stdio: ["ignore", "pipe", "inherit"] });
  let link = "";
  for await (const line of createInterface({ input: server.stdout! })) {
    link = /^open in a browser: (\S+)/.exec(line)?.[1] ?? "";
    if (link) break;
  }
  assert.ok(link, "the server says where its page is");
  const page = await visit(link);
  await page.waitForFunction(() => window.baudbotViewer?.frames > 5);
  const from = await page.evaluate(() => window.baudbotViewer.pose);
  await page.click(id("drive"));
  await page.focus(id("arena-canvas"));
  await page.keyboard.down("w");
  const hasMoved = (from: typeof window.baudbotViewer.pose) => {
    const now = window.baudbotViewer.pose;
    return now !== undefined && from !== undefined && Math.hypot(now.x_m - from.x_m, now.y_m - from.y_m) > 0.03;
  };
  await page.waitForFunction(hasMoved, {}, from);
  await page.keyboard.up("w");
  await page.close();
  server.kill("SIGINT");
  assert.deepEqual(await once(server, "exit"), [0, null]);
});
