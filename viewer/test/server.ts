/**
 * The page that is built into the program, in a browser, before a server with a robot and its brain:
 * `npm run test:server`. Needs the program, in BAUDBOT or where `cargo build --release` puts it, and a Chromium: in
 * CHROMIUM, or where Debian has it. With SHOTS it leaves pictures in that folder.
 */
import assert from "node:assert/strict";
import { spawn, type ChildProcess } from "node:child_process";
import { once } from "node:events";
import { mkdtemp, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { chromium, type Browser, type Page } from "playwright-core";
import { other, settled } from "./settled";

const PROGRAM = process.env.BAUDBOT ?? new URL("../../target/release/baudbot", import.meta.url).pathname;
const BROWSER = process.env.CHROMIUM ?? "/usr/bin/chromium";
const shots = process.env.SHOTS;

let server: ChildProcess;
let brain: ChildProcess;
/** What the brain's program complains of. */
let complaints = "";
let browser: Browser;
let link: string;
/** The server's recordings. */
let folder: string;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "baudbot-recordings-"));
  const free = ["--listen", "127.0.0.1:0", "--viewer", "127.0.0.1:0", "--recordings", folder];
  // A robot whose cable is out may run into something, and the others want to go on.
  const worlds = ["wander", "khepera", "--set", "collision=stop-robot", "--set", "metrics.cell_m=0.02"];
  server = spawn(PROGRAM, ["serve", ...worlds, ...free], { stdio: ["ignore", "pipe", "inherit"] });
  const lines = createInterface({ input: server.stdout! });
  let address = "";
  for await (const line of lines) {
    address ||= /^listening on (\S+)/.exec(line)?.[1] ?? "";
    link = /^open in a browser: (\S+)/.exec(line)?.[1] ?? "";
    if (link) break;
  }
  assert.ok(address && link, "the server says where it is");
  const who = ["--connect", address, "--world", "wander", "--robot", "robot"];
  brain = spawn(PROGRAM, ["brain", "avoid", ...who], { stdio: ["ignore", "ignore", "pipe"] });
  brain.stderr?.on("data", (text) => (complaints += text));
  browser = await chromium.launch({ executablePath: BROWSER, args: ["--no-sandbox"] });
});

after(async () => {
  await browser?.close();
  for (const program of [brain, server]) {
    if (program?.exitCode === null) {
      program.kill("SIGINT");
      await once(program, "exit");
    }
  }
  if (folder) await rm(folder, { recursive: true });
});

/** A page that fails the test if anything is refused by its policy or thrown in it. */
async function open(hash: string, colorScheme: "light" | "dark" = "light"): Promise<Page> {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme });
  const page = await context.newPage();
  page.on("console", (message) => message.type() === "error" && assert.fail(message.text()));
  page.on("pageerror", (error) => assert.fail(error));
  // The link ends with the token.
  await page.goto(`${link}&${hash.slice(1)}`);
  await page.waitForFunction(() => window.baudbotViewer?.frames > 5);
  return page;
}

const text = async (page: Page, id: string) => (await page.getByTestId(id).textContent()) ?? "";

/** What a canvas shows. */
const picture = (page: Page, id: string) =>
  page.getByTestId(id).evaluate((canvas) => (canvas as HTMLCanvasElement).toDataURL());

/** How many pixels of a canvas differ from its first one. */
const inked = (page: Page, id: string) =>
  page.getByTestId(id).evaluate((element) => {
    const canvas = element as HTMLCanvasElement;
    const words = new Uint32Array(canvas.getContext("2d")!.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
    return words.filter((word) => word !== words[0]).length;
  });

const WANDER = "#world=wander&robot=robot";

test("a robot moves, its readings have ages, its cycles are drawn", { timeout: 60_000 }, async () => {
  const page = await open(WANDER);
  const [at, arena] = [await page.evaluate(() => window.baudbotViewer.pose), await picture(page, "arena-canvas")];
  assert.ok(at);
  await page.waitForFunction((at) => {
    const now = window.baudbotViewer.pose;
    return now !== undefined && Math.hypot(now.x_m - at.x_m, now.y_m - at.y_m) > 0.1;
  }, at);
  await other(arena, () => picture(page, "arena-canvas"), "the robot moves");
  assert.ok((await inked(page, "arena-canvas")) > 10_000);
  assert.match(await text(page, "sensor-age-ir_front"), /^\d+(\.\d+)?(–\d+(\.\d+)?)? ms$/);
  assert.ok((await inked(page, "timing-canvas")) > 2_000);
  const timing = await picture(page, "timing-canvas");
  await other(timing, () => picture(page, "timing-canvas"), "the diagram is live");
  if (shots) await page.screenshot({ path: `${shots}/viewer-light.png` });
  await page.close();
});

test("the floor that the robot has covered is tinted", { timeout: 60_000 }, async () => {
  const page = await open(WANDER);
  await page.waitForFunction(() => window.baudbotViewer.coverageTick !== undefined);
  await page.getByTestId("pause").click();
  const still = () => page.evaluate(() => [window.baudbotViewer.tick, window.baudbotViewer.coverageTick]);
  const [tick, coverageTick] = await settled(still, 2500);
  assert.equal(coverageTick, tick, "a world that stands is asked for its last map");
  const tinted = await picture(page, "arena-canvas");
  await page.getByTestId("layer-coverage").click();
  await other(tinted, () => picture(page, "arena-canvas"), "the layer is gone");
  await page.getByTestId("layer-coverage").click();
  await page.waitForFunction(
    (tinted) => document.querySelector<HTMLCanvasElement>("[data-testid=arena-canvas]")?.toDataURL() === tinted,
    tinted,
  );
  await page.getByTestId("run").click();
  await page.close();
});

test("a world is paused and stepped", { timeout: 60_000 }, async () => {
  const page = await open(WANDER);
  await page.getByTestId("pause").click();
  await page.waitForFunction(() => document.title.includes("paused"));
  // The world may stand between two frames; the page asks for the last tick when it sees after a second that it stands.
  const tick = await settled(() => page.evaluate(() => window.baudbotViewer.tick), 2500);
  await page.getByTestId("step-10").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick === tick + 10, tick);
  await page.getByTestId("step").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick === tick + 11, tick);
  await page.getByTestId("run").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick > tick + 50, tick);
  await page.close();
});

test(
  "a cable that is pulled loses bytes while readings grow old, and is plugged in again",
  { timeout: 60_000 },
  async () => {
    const page = await open(WANDER, "dark");
    const lost = async () => Number(/lost\D*(\d+)/i.exec(await text(page, "losses"))?.[1] ?? NaN);
    assert.equal(await lost(), 0);
    await page.getByTestId("cable").click();
    const begun = Date.now();
    while ((await lost()) < 20) {
      assert.ok(Date.now() - begun < 20_000, `losses: ${await text(page, "losses")}`);
      await page.waitForTimeout(100);
    }
    await page.waitForFunction(() => {
      const age = document.querySelector("[data-testid=sensor-age-ir_front]")?.textContent ?? "";
      return / s$/.test(age) && parseFloat(age) >= 1;
    });
    if (shots) await page.screenshot({ path: `${shots}/viewer-dark.png` });
    const second = await open(WANDER);
    await second.waitForFunction(() => document.querySelector("[data-testid=cable]")?.textContent === "Plug cable in");
    await second.close();
    await page.getByTestId("cable").click();
    await page.waitForFunction(() =>
      / ms$/.test(document.querySelector("[data-testid=sensor-age-ir_front]")?.textContent ?? ""),
    );
    await settled(lost);
    await page.close();
  },
);

test("a robot without a brain is driven by the page, through its cable", { timeout: 60_000 }, async () => {
  const page = await open("#world=khepera&robot=khepera");
  await page.getByTestId("run").click();
  const from = await page.evaluate(() => window.baudbotViewer.pose);
  await page.getByTestId("drive").click();
  await page.getByTestId("arena-canvas").focus();
  await page.keyboard.down("w");
  await page.waitForFunction((from) => {
    const now = window.baudbotViewer.pose;
    return now !== undefined && from !== undefined && Math.hypot(now.x_m - from.x_m, now.y_m - from.y_m) > 0.03;
  }, from);
  await page.keyboard.up("w");
  await page.keyboard.press("Escape");
  await page.close();
});

test("a run is recorded, and gone through forwards and backwards", { timeout: 90_000 }, async () => {
  const page = await open(WANDER);
  await page.getByTestId("record-toggle").click();
  await page.getByTestId("record-state").waitFor();
  const begun = await page.evaluate(() => window.baudbotViewer.tick);
  await page.waitForFunction((tick) => window.baudbotViewer.tick > tick + 400, begun);
  await page.getByTestId("record-toggle").click();
  await page.getByTestId("recording-open-wander-1").click();
  await page.getByTestId("replay-bar").waitFor();
  await page.waitForFunction(() => window.baudbotViewer.replayTick !== undefined && window.baudbotViewer.pose);
  const slider = await page.getByTestId("replay-slider").boundingBox();
  assert.ok(slider);
  // However long the page takes to hear of the mouse, to get the tick and to draw it.
  const arrives = async (act: () => Promise<void>) => {
    const before = await page.evaluate(() => window.baudbotViewer.replayTick);
    await act();
    await page.waitForFunction((before) => {
      const { tick, replayTick } = window.baudbotViewer;
      return replayTick !== before && tick === replayTick;
    }, before);
    await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
  };
  const scrub = async (share: number) => {
    await arrives(() => page.mouse.move(slider.x + slider.width * share, slider.y + slider.height / 2));
    const { tick, pose } = await page.evaluate(() => ({ ...window.baudbotViewer, pose: window.baudbotViewer.pose }));
    assert.ok(pose);
    return { tick, pose, picture: await picture(page, "arena-canvas") };
  };
  await page.mouse.move(slider.x + slider.width * 0.1, slider.y + slider.height / 2);
  await arrives(() => page.mouse.down());
  const early = await scrub(0.2);
  const late = await scrub(0.9);
  const again = await scrub(0.2);
  await page.mouse.up();
  assert.ok(late.tick > early.tick + 200, `${early.tick} ${late.tick}`);
  assert.deepEqual([again.tick, again.pose], [early.tick, early.pose], "the same tick is the same picture");
  // It may have turned before a wall all the while.
  assert.notDeepEqual(late.pose, early.pose);
  assert.notEqual(late.picture, early.picture);
  await page.getByTestId("replay-back").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick === tick - 1, again.tick);
  await page.getByTestId("replay-play").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick > tick + 50, again.tick);
  assert.equal(await page.getByTestId("replay-differs").isVisible(), false);
  if (shots) await page.screenshot({ path: `${shots}/viewer-replay.png` });
  await page.getByTestId("replay-fork").click();
  await page.getByTestId("replay-bar").waitFor({ state: "hidden" });
  assert.deepEqual(await readdir(folder), ["wander-1.mcap"]);
  await page.close();
});

test("a brain is restarted by its program, and goes when it is thrown off", { timeout: 60_000 }, async () => {
  const page = await open(WANDER);
  const until = async (what: string) => {
    const begun = Date.now();
    while (!complaints.includes(what)) {
      assert.ok(Date.now() - begun < 20_000, complaints);
      await page.waitForTimeout(50);
    }
  };
  await page.getByTestId("restart").click();
  await until("the operator has restarted the brain of robot\n");
  await page.getByTestId("run").click();
  const from = await page.evaluate(() => window.baudbotViewer.pose);
  await page.waitForFunction((from) => {
    const now = window.baudbotViewer.pose;
    return now !== undefined && from !== undefined && Math.hypot(now.x_m - from.x_m, now.y_m - from.y_m) > 0.1;
  }, from);
  assert.equal(brain.exitCode, null);
  await page.getByTestId("detach").click();
  await until("the operator has detached this brain");
  await page.waitForFunction(() => document.querySelector<HTMLButtonElement>("[data-testid=restart]")?.disabled);
  await page.close();
});
